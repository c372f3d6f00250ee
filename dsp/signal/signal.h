#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/record.h"

/// One channel in SI units on its own time axis, with a reason for every sample that must not be trusted.

namespace powbench::dsp {

/// Why a sample is masked. A bit set; 0 = good.
enum Mask : std::uint8_t {
  mask_none = 0,
  mask_clipped = 1U << 0,  ///< at or beyond the converter's or amplifier's limit
  mask_gap = 1U << 1,      ///< lost or not finite; the value is interpolated
  mask_edge = 1U << 2,     ///< inside the invalid edge of a filter
};

/// Uniformly sampled values: sample i shows the quantity at t0 + i dt, seconds after switch-on, delay already
/// applied.
struct Signal {
  std::vector<double> value;         ///< (n), SI
  double t0 = 0.0;                   ///< s, time of sample 0
  double dt = 0.0;                   ///< s, > 0 when not empty
  std::vector<std::uint8_t> masked;  ///< (n), bits of `Mask`

  std::size_t size() const { return value.size(); }
  bool empty() const { return value.empty(); }
  double rate() const { return 1.0 / dt; }
  double time(std::size_t i) const { return t0 + static_cast<double>(i) * dt; }
  double end() const { return t0 + static_cast<double>(size()) * dt; }

  /// Index of the first sample at or after t, clamped to 0 .. n.
  std::size_t index_at(double t) const;
  /// Bits set anywhere in [t1, t2].
  std::uint8_t mask_within(double t1, double t2) const;
};

/// Counts to SI: (raw + offset) scale. The channel's delay shifts the time axis, gaps of the record and of the
/// channel are bridged by a straight line and masked, samples at the clip limits are masked. Empty when the channel
/// is absent. Throws std::invalid_argument when the record's rate is not positive or the channel's scale is zero or
/// not finite.
Signal to_signal(const Record&, Channel);

/// Masks values that are not finite, and bridges every run of `mask_gap` by a straight line (or by its only
/// neighbour). All samples masked: values become zero.
void bridge_gaps(Signal&);

}  // namespace powbench::dsp
