#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <string_view>
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
  int closings = 0;      ///< number of closings that were measured; those without a value are no repeats
  Measured measured;     ///< mean over repeats; u combines scatter (type A) and event uncertainty (type B)
  double scatter = 0.0;  ///< standard deviation over repeats; NaN for fewer than two
  /// what is left of it when each closing is held against the simulation at its own angle, voltage and frequency;
  /// NaN: not known
  double unexplained = std::numeric_limits<double>::quiet_NaN();
  double dof = std::numeric_limits<double>::infinity();  ///< effective degrees of freedom of measured.u
  double coverage =
      std::numeric_limits<double>::quiet_NaN();  ///< k: expanded uncertainty U = k u covers 95.45 %
  double lowest = std::numeric_limits<double>::quiet_NaN();
  double highest = std::numeric_limits<double>::quiet_NaN();
  bool two_modes = false;  ///< the repeats fall into two groups: the mean describes neither
  double simulated = std::numeric_limits<double>::quiet_NaN();
  double u_simulated =
      std::numeric_limits<double>::quiet_NaN();  ///< propagated from the inputs; NaN = not known
  double coverage_difference = std::numeric_limits<
      double>::quiet_NaN();          ///< k of simulated - measured; NaN = that of the measured mean
  bool u_simulated_unknown = false;  ///< the inputs' share was asked for and cannot be told
  double published_measurement = std::numeric_limits<double>::quiet_NaN();
  double published_simulation = std::numeric_limits<double>::quiet_NaN();
  bool seen_in_one = false;  ///< by measurement or simulation alone, though both have the channel
  Outcome outcome = Outcome::not_judged;  ///< against the plan's limits on the quantity
  Outcome against_simulation =
      Outcome::not_judged;  ///< against the plan's largest difference from the simulation

  /// U of simulated - measured, 95.45 %: k sqrt(u^2 + u_simulated^2); NaN when u is unknown.
  double expanded_difference() const {
    if (u_simulated_unknown) return std::numeric_limits<double>::quiet_NaN();
    const double s = std::isfinite(u_simulated) ? u_simulated : 0.0;
    const double k = std::isfinite(coverage_difference) ? coverage_difference : coverage;
    return k * std::sqrt(measured.u * measured.u + s * s);
  }
  /// |simulated - measured| / U; NaN when either is unknown. Up to 1 the two agree.
  double difference_over_U() const {
    const double U = expanded_difference();
    return U > 0 ? std::fabs(simulated - measured.value) / U : std::numeric_limits<double>::quiet_NaN();
  }
};

/// "agrees" up to a difference of U, else "differs"; "not known" without both values and an uncertainty.
inline std::string_view agreement(double difference_over_U) {
  if (!std::isfinite(difference_over_U)) return "not known";
  return difference_over_U <= 1 ? "agrees" : "differs";
}

struct Comparison {
  std::vector<ComparisonRow> rows;  ///< ordered by quantity, then angle
};

}  // namespace powbench
