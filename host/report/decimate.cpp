#include "host/report/decimate.h"

#include <algorithm>
#include <cmath>

namespace powbench::host {
namespace {

/// Indices of the smallest and the largest finite sample in [first, last); `first == last` = none.
struct Extremes {
  std::size_t low, high;
  bool found = false;
};

Extremes extremes(std::span<const float> v, std::size_t first, std::size_t last) {
  Extremes e{first, first};
  for (std::size_t i = first; i < last; ++i) {
    if (!std::isfinite(v[i])) continue;
    if (!e.found || v[i] < v[e.low]) e.low = i;
    if (!e.found || v[i] > v[e.high]) e.high = i;
    e.found = true;
  }
  return e;
}

}  // namespace

std::vector<TracePoint> decimate(std::span<const float> values, double t0, double dt, double t_low,
                                 double t_high, std::size_t buckets) {
  std::vector<TracePoint> out;
  if (values.empty() || !(dt > 0) || !(t_high > t_low) || buckets == 0) return out;
  const double last_index = static_cast<double>(values.size() - 1);
  const double from = std::clamp(std::ceil((t_low - t0) / dt), 0.0, last_index + 1);
  const double to = std::clamp(std::floor((t_high - t0) / dt), -1.0, last_index);
  if (!(to >= from)) return out;
  const auto first = static_cast<std::size_t>(from);
  const std::size_t count = static_cast<std::size_t>(to) - first + 1;

  bool broken = true;
  const auto put = [&](std::size_t i) {
    out.push_back({t0 + static_cast<double>(i) * dt, static_cast<double>(values[i]), broken});
    broken = false;
  };
  const bool all = count <= 2 * buckets;
  const std::size_t groups = all ? count : buckets;
  for (std::size_t b = 0; b < groups; ++b) {
    const std::size_t begin = first + b * count / groups, end = first + (b + 1) * count / groups;
    const Extremes e = extremes(values, begin, end);
    if (!e.found) {
      broken = true;
      continue;
    }
    put(std::min(e.low, e.high));
    if (e.low != e.high) put(std::max(e.low, e.high));
  }
  return out;
}

}  // namespace powbench::host
