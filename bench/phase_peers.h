#pragma once

#include <cstdint>

#include "bench/phase_judge.h"
#include "firmware/phase_tracker.h"
#include "firmware/sogi.h"
#include "firmware/zero_cross.h"

/// The estimators that are compared: all get the same samples, and the peers the same decimation to 10 kS/s.

namespace powbench::bench {

struct OurTracker {
  firmware::PhaseTracker tracker{firmware::PhaseTrackerConfig{}};

  void push(std::int16_t counts) { tracker.push(counts); }
  PhaseSay say() const {
    const firmware::PhaseEstimate& e = tracker.estimate();
    return {e.phase_turns, e.frequency, e.frequency_rate, e.valid(),
            e.valid(0.001F, firmware::PhaseEstimate::usual_tolerance)};
  }
};

/// Sums ten samples; the middle of the sum lies 4.5 samples before its last.
template <class Follower>
struct DecimatedPeer {
  Follower follower;
  std::int32_t sum = 0;
  int summed = 0;

  void push(std::int16_t counts) {
    sum += counts;
    if (++summed < 10) return;
    follower.push(static_cast<float>(sum) / static_cast<float>(10 * mains_counts));
    sum = 0;
    summed = 0;
  }
  PhaseSay say() const {
    const double hertz = follower.hertz();
    return {static_cast<double>(follower.turns()) + hertz * 4.5 / mains_rate, hertz, 0.0, true, true};
  }
};

/// The plain controller: low-pass at 60 Hz, newest zero crossing, frequency of the last cycle.
struct ZeroCrossPeer : DecimatedPeer<firmware::ZeroCross> {
  ZeroCrossPeer() : DecimatedPeer{firmware::ZeroCross({.corner_hertz = 60.0F, .cancel_offset = false})} {}
};

/// SOGI-PLL with offset rejection, 8 Hz loop.
struct SogiPeer : DecimatedPeer<firmware::SogiPll> {
  SogiPeer() : DecimatedPeer{firmware::SogiPll({.loop_hertz = 8.0F})} {}
};

}  // namespace powbench::bench
