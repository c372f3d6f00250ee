#include "sim/study/modes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace powbench::sim {
namespace {

constexpr double least_share = 0.05;
constexpr std::size_t least_count = 5;
constexpr double apart = 4;  // pooled deviations between the means

Mode describe(std::span<const double> sorted, std::size_t total) {
  Mode m;
  const auto n = static_cast<double>(sorted.size());
  for (const double v : sorted) m.mean += v / n;
  double squares = 0;
  for (const double v : sorted) squares += (v - m.mean) * (v - m.mean);
  m.deviation = sorted.size() > 1 ? std::sqrt(squares / (n - 1)) : 0.0;
  m.share = n / static_cast<double>(total);
  m.low = sorted.front();
  m.high = sorted.back();
  return m;
}

/// Splits at the place that leaves the smallest sum of squares within both parts, as long as that separates them.
void split(std::span<const double> sorted, std::size_t total, std::vector<Mode>& out) {
  const std::size_t n = sorted.size();
  const auto least =
      std::max(least_count, static_cast<std::size_t>(std::ceil(least_share * static_cast<double>(total))));
  if (n >= 2 * least) {
    const double centre = describe(sorted, total).mean;
    double sum = 0;
    for (const double v : sorted) sum += v - centre;
    double left = 0;
    double best_gain = -1;
    std::size_t cut = 0;
    for (std::size_t k = 1; k < n; ++k) {
      left += sorted[k - 1] - centre;
      if (k < least || n - k < least) continue;
      const double right = sum - left;
      const double gain = left * left / static_cast<double>(k) + right * right / static_cast<double>(n - k);
      if (gain > best_gain) best_gain = gain, cut = k;
    }
    const Mode a = describe(sorted.first(cut), total);
    const Mode b = describe(sorted.subspan(cut), total);
    const double pooled = std::sqrt(0.5 * (a.deviation * a.deviation + b.deviation * b.deviation));
    if (b.mean - a.mean > apart * pooled && b.mean > a.mean) {
      split(sorted.first(cut), total, out);
      split(sorted.subspan(cut), total, out);
      return;
    }
  }
  out.push_back(describe(sorted, total));
}

}  // namespace

std::vector<Mode> modes(std::span<const double> sample) {
  std::vector<double> sorted;
  for (const double v : sample)
    if (std::isfinite(v)) sorted.push_back(v);
  std::sort(sorted.begin(), sorted.end());
  std::vector<Mode> out;
  if (!sorted.empty()) split(sorted, sorted.size(), out);
  return out;
}

double quantile_of_sorted(std::span<const double> sorted, double share) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(at);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (at - std::floor(at)) * (sorted[k + 1] - sorted[k]);
}

}  // namespace powbench::sim
