#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/record.h"

/// From time stamps to one uniform clock.

namespace powbench::host {

/// Sample k of the clock is at t0 + k / rate.
struct UniformClock {
  double t0 = 0.0;     ///< s, on the stamps' axis
  double rate = 0.0;   ///< Hz
  std::size_t n = 0;   ///< samples
  bool even = true;    ///< every stamp is a tick of the clock: values are taken as they are, not interpolated
  double error = 0.0;  ///< s: largest distance of a stamp from its tick (even), or from the nearest tick
  std::vector<std::int64_t> tick;  ///< (stamps), even only: tick of each stamp, rising
  std::vector<Gap> gaps;           ///< ticks without a stamp, or with none near

  double time(std::size_t k) const { return t0 + static_cast<double>(k) / rate; }
};

/// Why stamps cannot be used: `row` is the first one at fault.
struct StampMistake {
  std::size_t row = 0;
  std::string what;  ///< empty: none
};

/// Stamps must rise and be finite.
StampMistake check_stamps(std::span<const double> seconds);

/// The clock behind rising `seconds` (two at least). Stamps that lie on ticks to within a twentieth of the interval,
/// or to within half the last digit they were written with, make an even clock with dropped ticks as gaps. Others get
/// a clock of their typical interval; ticks further than 1.5 such intervals from every stamp are gaps. A rate within
/// the error of a round number is that number.
UniformClock find_clock(std::span<const double> seconds);

/// Values at the ticks from values at the stamps, by the cubic through the four nearest stamps (a straight line where
/// their intervals differ by more than 3). NaN values are skipped. `correction`: the largest distance of a result
/// from the straight line between its neighbours, an upper bound of the error made by interpolating.
std::vector<double> resample(const UniformClock&, std::span<const double> seconds,
                             std::span<const double> values, double& correction);

}  // namespace powbench::host
