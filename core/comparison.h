#pragma once

#include <string>
#include <vector>

#include "core/events.h"
#include "core/outcome.h"

namespace powbench {

/// One quantity at one closing angle: measured beside simulated beside published. Filled by `host/compare`.
struct ComparisonRow {
  double closing_angle = 0.0;  ///< rad, commanded
  std::string quantity;        ///< symbol of the quantity table, e.g. t_ct1
  std::string unit;            ///< SI unit of all values below
  int repeats = 0;             ///< number of measured values behind the mean
  Measured measured;     ///< mean over repeats; u combines scatter (type A) and event uncertainty (type B)
  double scatter = 0.0;  ///< standard deviation over repeats; NaN for fewer than two
  double dof = std::numeric_limits<double>::infinity();  ///< effective degrees of freedom of measured.u
  double coverage =
      std::numeric_limits<double>::quiet_NaN();  ///< k: expanded uncertainty U = k u covers 95 %
  double lowest = std::numeric_limits<double>::quiet_NaN();
  double highest = std::numeric_limits<double>::quiet_NaN();
  bool two_modes = false;  ///< the repeats fall into two groups: the mean describes neither
  double simulated = std::numeric_limits<double>::quiet_NaN();
  double published_measurement = std::numeric_limits<double>::quiet_NaN();
  double published_simulation = std::numeric_limits<double>::quiet_NaN();
  Outcome outcome = Outcome::pass;  ///< against the plan's limits
};

struct Comparison {
  std::vector<ComparisonRow> rows;  ///< ordered by quantity, then angle
};

}  // namespace powbench
