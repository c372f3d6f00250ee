#include "host/report/ticks.h"

#include <algorithm>
#include <cmath>

namespace powbench::host {

void Range::include(double value) {
  if (!std::isfinite(value)) return;
  if (empty()) {
    low = high = value;
    return;
  }
  low = std::min(low, value);
  high = std::max(high, value);
}

Range Range::padded(double share, double least) const {
  if (empty()) return {0, 1};
  const double margin = span() > 0 ? share * span() : least;
  return {low - margin, high + margin};
}

Ticks ticks_every(const Range& range, double step) {
  Ticks ticks;
  if (range.empty() || !(step > 0) || !(range.span() / step < 1000)) return ticks;
  const double slack = 1e-9 * range.span();
  const double first = std::ceil((range.low - slack) / step);
  for (double k = first; k * step <= range.high + slack; ++k) ticks.at.push_back(k == 0 ? 0 : k * step);
  ticks.decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return ticks;
}

Ticks nice_ticks(const Range& range, int target) {
  if (range.empty() || !std::isfinite(range.span()) || !(range.span() > 0) || target < 1) return {};
  const double raw = range.span() / target;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / decade;
  const double step = lead < 1.414 ? 1 : lead < 3.162 ? 2 : lead < 7.071 ? 5 : 10;  // geometric means
  return ticks_every(range, step * decade);
}

}  // namespace powbench::host
