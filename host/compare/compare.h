#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/comparison.h"
#include "core/conditions.h"
#include "core/events.h"
#include "host/compare/limits.h"
#include "host/paper/published.h"

namespace powbench::host {

/// Everything known about one closing angle.
struct AngleGroup {
  double closing_angle = 0.0;     ///< rad, [0, 2 pi); NaN = not known
  std::vector<Events> measured;   ///< of every shot with a valid measurement
  std::vector<Events> simulated;  ///< same conditions, simulated; the mean counts, usually of one
  std::map<std::string, double>
      u_simulated{};  ///< of its quantities, from the inputs' uncertainties, SI; empty: nominal conditions
  /// Of each of `measured`, in their order: what its own conditions add to the simulated quantities, SI, by symbol;
  /// empty: not known.
  std::vector<std::map<std::string, double>> moved{};
};

/// Phase of the coil voltage asked for, polarity included: closing_angle, or closing_angle + pi. rad, [0, 2 pi); NaN
/// when none is known.
double effective_angle(const Conditions&);

/// Degrees to 0.01, as they are stored; NaN stays NaN.
double stored_degrees(double angle);

/// Equal to 0.01 deg, or both unknown.
bool same_angle(double a, double b);

/// Puts the shot into the group of its angle (equal to 0.01 deg), which is created in ascending order when missing.
AngleGroup& group_at(std::vector<AngleGroup>&, double closing_angle);

/// One row per quantity of the quantity table and angle, ordered by quantity, then angle; see `Repeats` for the
/// statistics. Published values come from rows with the same symbol and the same angle, excluded ones included (the
/// report marks them). outcome: the worst of the repeats against the limit of their quantity, ERROR when the angle
/// has no valid measurement at all; without a limit NOT JUDGED. `most_from_simulation`: largest
/// |simulated - measured| as a share of the measured mean; NaN = no such limit.
Comparison compare(std::vector<AngleGroup> groups, std::span<const PublishedRow> published,
                   const std::vector<Limit>& limits, Decision = Decision::simple,
                   double most_from_simulation = std::numeric_limits<double>::quiet_NaN());

/// The rows whose difference over its U is known, the largest first.
std::vector<const ComparisonRow*> ranked(const Comparison&);

}  // namespace powbench::host
