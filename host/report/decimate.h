#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace powbench::host {

/// A uniformly sampled trace: value i at t0 + i dt.
struct TracePoint {
  double t = 0;
  double value = 0;
  bool starts = false;  ///< first point after a break: what lies between is not finite
};

/// The trace between t_low and t_high with at most 2 `buckets` points: of each bucket of equal duration the smallest
/// and the largest sample, in order of time. Every extreme of the trace survives. Short traces come back unchanged.
/// Samples that are not finite break the line. Requires dt > 0 and buckets > 0; otherwise nothing.
std::vector<TracePoint> decimate(std::span<const float> values, double t0, double dt, double t_low,
                                 double t_high, std::size_t buckets);

}  // namespace powbench::host
