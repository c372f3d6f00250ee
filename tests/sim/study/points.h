#pragma once

#include "sim/study/sweep.h"

namespace powbench::sim {

/// The results of all these points, in order.
inline std::vector<ClosingMetrics> run_points(const Design& design, const Case& base,
                                              std::span<const std::int64_t> points,
                                              const MetricOptions& options, Team& team) {
  std::vector<ClosingMetrics> results(points.size());
  stream_points(
      design, base, points, options, team,
      [&](std::size_t place, const ClosingMetrics& m) { results[place] = m; }, [] { return true; });
  return results;
}

}  // namespace powbench::sim
