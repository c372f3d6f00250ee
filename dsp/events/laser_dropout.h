#pragma once

#include <cstddef>
#include <vector>

#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// A while in which a laser that lost its target shows its last value.
struct Dropout {
  double from = 0, to = 0;  ///< s: its first value that is old, and the next new one
};

/// Flight as the laser shows it: samples `first` .. `last`, at rest `open` m, `travel` m > 0 further when closed,
/// `noise` m rms.
struct LaserFlight {
  std::size_t first = 0, last = 0;
  double open = 0, travel = 0, noise = 0;
};

/// One value held for 0.3 ms or more and left by a jump of more than 2 % of the travel, 8 times the noise and 5 times
/// the smallest step: no core moves so. A slow laser holds every value: there it has to be held for three times as
/// long as values in mid-travel are.
std::vector<Dropout> laser_dropouts(const Signal& laser, const LaserFlight&, double step);

}  // namespace powbench::dsp
