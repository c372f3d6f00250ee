#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/conditions.h"
#include "host/config/plan_file.h"

/// The list of shots that a plan means. A pure function of the plan: the same on every machine, so that a campaign can
/// be resumed and a simulation can follow the measurement shot by shot.

namespace powbench::host {

struct PlannedShot {
  int index = 0;   ///< place in the campaign, from 0, in the order of firing
  int repeat = 0;  ///< from 0
  Conditions conditions;
};

/// All shots in the order of firing. Each repeat is a block that holds every angle once; with Order::random each block
/// is shuffled by itself (Fisher-Yates on Random), so that slow drift spreads evenly over the angles.
/// Alternating polarity changes from shot to shot, so that remanence changes sign; with an even number of angles it
/// also starts each block with the other sign, so that no angle keeps the same one in sequential order.
std::vector<PlannedShot> expand(const Plan&, const std::string& specimen_name = "reference");

/// Seed of one shot: below 2^53, so that every language's numbers hold it; different for each index.
std::uint64_t shot_seed(std::uint64_t plan_seed, int index);

/// Expected duration, s: n (hold + overhead) + (n - 1) pause. `overhead_per_shot`: arming, waiting for the angle and
/// reading out, s.
double estimated_seconds(const Plan&, double overhead_per_shot = 0.3);

}  // namespace powbench::host
