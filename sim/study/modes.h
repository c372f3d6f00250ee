#pragma once

#include <span>
#include <vector>

/// Statistics of samples that may have more than one mode.

namespace powbench::sim {

/// A cluster of values.
struct Mode {
  double share = 0;  ///< of the sample
  double mean = 0, deviation = 0;
  double low = 0, high = 0;  ///< smallest and largest value
};

/// The clusters of a sample in ascending order: one, unless it falls into parts, each of at least 5 % and 5 values,
/// whose means are 4 pooled standard deviations apart (a uniform sample cut in half reaches 3.5). A mean of the whole
/// says nothing where there is more than one. NaN are left out; no value: no mode.
std::vector<Mode> modes(std::span<const double> sample);

/// Quantile of an ascending sample, linear between values; share in [0, 1]. NaN for an empty one.
double quantile_of_sorted(std::span<const double> sorted, double share);

}  // namespace powbench::sim
