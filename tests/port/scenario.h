#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/port/driver.h"

/// Scenarios as text, one statement a line, `#` begins a comment; the first line says what is shown.
/// tests/replay/scenario_port.py plays the same files. Times are a number and `us` or `ms`.
///
///   needs WHAT                      what the driver must offer, else the scenario is not played
///   shot DEGREES HOLD_MS            set-points, arm, 80 ms
///   set ATTRIBUTE VALUE             by the owner, accepted; `angle` is the closing angle in 0.01 degrees
///   refused ATTRIBUTE VALUE
///   is ATTRIBUTE VALUE
///   until ATTRIBUTE VALUE within TIME
///   wait TIME
///   cause NAME, end NAME
///   gate on within TIME
///   gate off within TIME            since the last `cause`, `set` or on edge; looked at until 0.5 ms later
///   gate off for TIME
///   held TIME within TIME           the gate's last time on
///   angle DEGREES within DEGREES    of the last on edge
///   relay in, relay out within TIME
namespace powbench::test {

struct Played {
  bool played = true;
  std::string failure;       ///< `line N: statement: what was found`; empty: all statements hold
  double slowest_off = 0.0;  ///< us, of all `gate off within`
};

struct Statement {
  int line = 0;
  std::string text;
  std::vector<std::string> words;
};

/// Throws std::runtime_error for a line that is no statement.
std::vector<Statement> read_scenario(const std::filesystem::path&);
Played play(const std::vector<Statement>&, Driver&);

}  // namespace powbench::test
