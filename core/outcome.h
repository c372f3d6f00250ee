#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// How a shot, a check or a program ended. The same words everywhere: store, report, JUnit, command line.

namespace powbench {

enum class Outcome : std::uint8_t {
  pass,          ///< measured, inside the limits
  fail,          ///< measured, outside the limits
  error,         ///< no valid measurement: rig fault, lost server, interlock
  timeout,       ///< the rig did not finish in time
  aborted,       ///< stopped by the operator
  not_judged,    ///< measured, and no limit says what would be right; never a pass
  not_observed,  ///< the record does not show what a limit is about
};

inline constexpr std::array<std::string_view, 7> outcome_names{
    "PASS", "FAIL", "ERROR", "TIMEOUT", "ABORTED", "NOT JUDGED", "NOT OBSERVED"};
constexpr std::string_view name(Outcome o) {
  return outcome_names[static_cast<std::size_t>(o)];
}

/// There is a valid measurement, whatever was judged of it.
constexpr bool measured(Outcome o) {
  return o == Outcome::pass || o == Outcome::fail || o == Outcome::not_judged || o == Outcome::not_observed;
}

/// The worse of two: FAIL, ERROR, TIMEOUT, ABORTED, NOT OBSERVED, NOT JUDGED, PASS.
constexpr Outcome worse(Outcome a, Outcome b) {
  constexpr std::array<int, 7> rank{0, 6, 5, 4, 3, 1, 2};
  return rank[static_cast<std::size_t>(a)] >= rank[static_cast<std::size_t>(b)] ? a : b;
}

/// Who bears the uncertainty of a value near its limit (JCGM 106:2012, 8).
enum class Decision : std::uint8_t {
  simple,   ///< the value itself decides
  guarded,  ///< the value with its U = 2 u on either side must be inside
};

/// Exit codes of the command line.
enum class Exit : int {
  pass = 0,
  outside_limits = 1,  ///< not passed: outside limits, a limited quantity not observed, or shots missing
  bad_input = 2,
  rig_fault = 3,  ///< rig unreachable or at fault
  timeout = 4,
  data_damaged = 5,
  interlock = 6,
  not_known = 7,  ///< whether a wanted accuracy is reached: nothing to compare the model with
  interrupted = 130,
};

/// Of what looks at a campaign: 1 for all that is neither PASS nor NOT JUDGED.
constexpr Exit exit_of(Outcome verdict) {
  return verdict == Outcome::pass || verdict == Outcome::not_judged ? Exit::pass : Exit::outside_limits;
}

}  // namespace powbench
