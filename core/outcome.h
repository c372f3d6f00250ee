#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// How a shot, a check or a program ended. The same five words everywhere: store, report, JUnit, command line.

namespace powbench {

enum class Outcome : std::uint8_t {
  pass,     ///< measured, inside the limits
  fail,     ///< measured, outside the limits
  error,    ///< no valid measurement: rig fault, lost server, interlock
  timeout,  ///< the rig did not finish in time
  aborted,  ///< stopped by the operator
};

inline constexpr std::array<std::string_view, 5> outcome_names{"PASS", "FAIL", "ERROR", "TIMEOUT", "ABORTED"};
constexpr std::string_view name(Outcome o) {
  return outcome_names[static_cast<std::size_t>(o)];
}

/// Exit codes of the command line.
enum class Exit : int {
  pass = 0,
  outside_limits = 1,
  bad_input = 2,
  rig_fault = 3,  ///< rig unreachable or at fault
  timeout = 4,
  data_damaged = 5,
  interlock = 6,
  interrupted = 130,
};

}  // namespace powbench
