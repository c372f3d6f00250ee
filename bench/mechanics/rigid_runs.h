#pragma once

#include <string>
#include <vector>

#include "sim/mechanics/bounce_error.h"

/// Runs of the reference closing by different integrators, all with the same right-hand side.

namespace powbench::bench {

inline constexpr double closing_end = 0.06;  ///< s

struct ClosingRun {
  std::string method;
  double tolerance = 0;
  std::vector<sim::RigidEvent> events;
  long steps = 0;
  long evaluations = 0;
  double cpu_ms = 0;  ///< best of the repeats
  bool finished = true;
};

/// Thread CPU time, ms.
double cpu_ms();

ClosingRun own_run(const sim::RigidParts&, double tolerance, int repeats);
/// The reference: long double.
ClosingRun exact_run(const sim::RigidParts&, long double tolerance);

/// The closing without any loss, with its ledger: largest residual over so many steps.
struct UndampedRun {
  double residual = 0, seconds = 0;
  long events = 0;
};
UndampedRun undamped_run(double tolerance, long steps);

/// SUNDIALS, if it was found when this was built: CVODE (Adams, BDF) and ARKODE (Dormand-Prince 5, Fehlberg 8), each
/// with roots for the contacts; the first two also restarted at every root.
bool have_sundials();
std::vector<std::string> sundials_methods();
ClosingRun sundials_run(const std::string& method, const sim::RigidParts&, double tolerance, int repeats);

}  // namespace powbench::bench
