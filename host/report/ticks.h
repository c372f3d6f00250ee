#pragma once

#include <vector>

namespace powbench::host {

/// A closed interval of an axis. Starts empty.
struct Range {
  double low = 1.0;
  double high = -1.0;

  bool empty() const { return !(low <= high); }
  double span() const { return high - low; }
  /// Grows to hold `value`; ignores what is not finite.
  void include(double value);
  /// Grown by `share` of the span on both ends. A range of one point grows by `least` each way; an empty one becomes
  /// 0..1.
  Range padded(double share, double least = 1.0) const;
};

/// Round positions for an axis: the step is 1, 2 or 5 times a power of ten, chosen to give about `target` steps; all
/// positions lie within [low, high]. Empty when the range is empty, not finite or of zero span.
struct Ticks {
  std::vector<double> at;
  int decimals = 0;  ///< needed to tell the labels apart
};
Ticks nice_ticks(const Range&, int target);

/// Positions at multiples of a given step > 0.
Ticks ticks_every(const Range&, double step);

}  // namespace powbench::host
