#pragma once

#include <cstdint>
#include <vector>

#include "bench/dsp_synth.h"
#include "core/record.h"

/// Records of the simulated rig, where the ringing comes from the mechanics and not from a formula, with the
/// simulator's own truth about every break.

namespace powbench::bench {

struct RigTruth {
  Record record;
  std::vector<TrueContact> film_a, film_b;  ///< s; peak not known (0)
  std::vector<TrueContact> pole;            ///< closed only while both breaks are
  double core_seat = 0, core_settled = 0;   ///< s: first and last arrival of the core
  double core_retouch = 0;                  ///< s: second arrival; 0 when there is none
  double closing_angle = 0;                 ///< rad
};

/// The reference contactor closed at `closing_angle`, all eight channels at `rate`, 40 ms before and 60 ms after
/// switch-on, with the noise and hum of the rig's sensors. `mains_hertz` changes the supply.
RigTruth rig_record(double rate, double closing_angle, double mains_hertz, std::uint64_t seed);

}  // namespace powbench::bench
