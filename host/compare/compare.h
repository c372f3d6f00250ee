#pragma once

#include <span>
#include <vector>

#include "core/comparison.h"
#include "core/conditions.h"
#include "core/events.h"
#include "host/compare/limits.h"
#include "host/paper/published.h"

namespace powbench::host {

/// Everything known about one closing angle.
struct AngleGroup {
  double closing_angle = 0.0;     ///< rad, [0, 2 pi)
  std::vector<Events> measured;   ///< of every shot with a valid measurement
  std::vector<Events> simulated;  ///< same conditions, simulated; the mean counts, usually of one
};

/// Phase of the coil voltage asked for, polarity included: closing_angle, or closing_angle + pi. rad, [0, 2 pi).
double effective_angle(const Conditions&);

/// Puts the shot into the group of its angle (equal to 0.01 deg), which is created in ascending order when missing.
AngleGroup& group_at(std::vector<AngleGroup>&, double closing_angle);

/// One row per quantity of the quantity table and angle, ordered by quantity, then angle; see `Repeats` for the
/// statistics. Published values come from rows with the same symbol and the same angle, excluded ones included (the
/// report marks them). outcome: fail when any repeat is outside the limit of its quantity or does not show it, error
/// when the angle has no valid measurement at all, else pass.
Comparison compare(std::vector<AngleGroup> groups, std::span<const PublishedRow> published,
                   const std::vector<Limit>& limits);

}  // namespace powbench::host
