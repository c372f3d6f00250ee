#pragma once

#include <functional>

#include "sim/models/plant.h"

namespace powbench::sim {

/// Plants advanced side by side in the lanes of vector instructions, each with steps and events of its own: a lane that
/// has come to its end takes the next plant. Equations and steps are in the lanes, events are located one by one. A
/// plant that the lanes do not know (another coil than one on the AC source, remanence, an odd law of the iron) is
/// advanced alone; up to 64 with another number of states wait for each other.
///
/// The result of each is that of Plant::advance, to the bit where the compiler fuses no products and sums, as on
/// x86-64. Lanes with steps of their own, and what they cost: L. Nagy, L. Plavecz, F. Hegedus, arXiv 2011.01740.
struct LaneRun {
  Plant* plant = nullptr;  ///< null: there is none
  double t_end = 0;        ///< s, to advance it to
};
struct LaneLayout;
struct LaneBlock;
/// One try of a step in all lanes (lane_block.h).
using LaneKernel = void (*)(const LaneLayout&, LaneBlock&);
/// The fastest this processor can run.
LaneKernel best_lane_kernel();
/// A plant that could not be advanced.
using LaneFailure = std::function<void(Plant&)>;
/// `done` is called when its plant is there; where nothing was left, `next` is asked again after it. A plant that
/// Plant::advance would end with a std::runtime_error goes to `failed`; without `failed` that is thrown.
void advance_in_lanes(const std::function<LaneRun()>& next, const std::function<void(Plant&)>& done,
                      const LaneFailure& failed = {}, LaneKernel kernel = best_lane_kernel());

}  // namespace powbench::sim
