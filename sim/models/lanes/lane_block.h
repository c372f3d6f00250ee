#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/models/contactor_model.h"
#include "sim/models/integrator.h"
#include "sim/models/lanes/plant_lanes.h"

/// Contactors side by side: number k of every array below is of lane k. The equations are those of a single one: where
/// the compiler fuses no products and sums, the results are the same bits.

namespace powbench::sim {

inline constexpr int lane_width = 8;
/// Of the stages 0 .. 5 of a step, as shares of it; 6 is 5.
inline constexpr std::array<double, 6> stage_times{0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0};
using Lane = std::array<double, lane_width>;
using LaneMask = std::array<std::int64_t, lane_width>;  ///< -1 or 0

/// What must be alike in all lanes.
struct LaneLayout : ContactorLayout {
  int size = 0;
  int even_power = 0;  ///< of the law of the iron
  bool operator==(const LaneLayout&) const = default;
};

struct alignas(64) LaneBlock {
  static constexpr std::size_t states = ContactorModel::capacity, guards = ContactorModel::guard_capacity;
  static constexpr int samples = EventIntegrator<ContactorModel>::parts + 1;  ///< of the guards in a step

  ContactorNumbers<Lane> numbers;
  Lane friction;                       ///< N, largest
  std::array<Lane, states> tolerance;  ///< of each state

  // modes
  std::array<LaneMask, guards> pressed;
  LaneMask stick, slides;  ///< of the core's friction
  Lane way, sliding_force;

  // a step: asked for
  LaneMask accepted;  ///< of the last call: `result` and its slope are the beginning of the next step
  Lane begin, step;   ///< t and h, s
  LaneMask one_sine;  ///< its source is amplitude sin(rate t + phase), V
  Lane amplitude, rate, phase;
  std::array<Lane, stage_times.size()> source;  ///< V at the stages, of any other source; 0 is not read
  std::array<Lane, states> y, first_slope;      ///< at its beginning

  // and what came of it
  std::array<Lane, states> result, last_slope;
  std::array<std::array<Lane, states>, 5> dense;
  std::array<std::array<Lane, guards>, samples> guard;  ///< contacts, then friction
  Lane error;                                           ///< over the tolerance; infinite: not finite
  LaneMask interesting;  ///< a guard is below zero, or dips between two samples
};

void portable_lane_kernel(const LaneLayout&, LaneBlock&);
void avx2_lane_kernel(const LaneLayout&, LaneBlock&);    ///< built on x86-64 only
void avx512_lane_kernel(const LaneLayout&, LaneBlock&);  ///< built on x86-64 only

}  // namespace powbench::sim
