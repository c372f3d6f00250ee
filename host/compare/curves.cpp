#include "host/compare/curves.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::host {
namespace {

/// Mean of the values in [from, to); NaN without any, or where one was not measured: half a bin is another instant.
double mean(const Curve& c, double from, double to) {
  const auto n = static_cast<std::int64_t>(c.values.size());
  const auto place = [&](double t) {
    return static_cast<std::size_t>(
        std::clamp<std::int64_t>(std::llround(std::ceil((t - c.t0) / c.dt)), 0, n));
  };
  const std::size_t first = place(from), last = place(to);
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += static_cast<double>(c.values[i]);
  return last > first && std::isfinite(sum) ? sum / static_cast<double>(last - first) : CurveDeviation::none;
}

std::vector<double> binned(const Curve& c, double end) {
  if (!(c.dt > 0)) throw std::invalid_argument("curve: dt: allowed above 0 s");
  constexpr double before = 2e-3;  // s
  const double rest = mean(c, -before, 0);
  std::vector<double> bins(static_cast<std::size_t>(std::clamp(end / curve_bin, 0.0, 1e6)));
  for (std::size_t k = 0; k < bins.size(); ++k)
    bins[k] = mean(c, static_cast<double>(k) * curve_bin, static_cast<double>(k + 1) * curve_bin) -
              (std::isfinite(rest) ? rest : 0.0);
  return bins;
}

}  // namespace

CurveDeviation curve_deviation(const Curve& measured, const Curve& simulated, double end) {
  const auto m = binned(measured, end), s = binned(simulated, end);
  CurveDeviation found;
  double low = INFINITY, high = -INFINITY, squares = 0, along = 0, slopes = 0;
  int common = 0;
  for (std::size_t k = 0; k < m.size(); ++k) {
    const double d = s[k] - m[k];
    if (!std::isfinite(d)) continue;
    ++common;
    low = std::min(low, m[k]);
    high = std::max(high, m[k]);
    squares += d * d;
    if (!(std::fabs(d) <= found.largest)) {
      found.largest = std::fabs(d);
      found.at = (static_cast<double>(k) + 0.5) * curve_bin;
      found.measured = m[k];
      found.simulated = s[k];
    }
    if (k == 0 || k + 1 == m.size() || !std::isfinite(m[k + 1] - m[k - 1])) continue;
    const double slope = (m[k + 1] - m[k - 1]) / (2 * curve_bin);
    along += d * slope;
    slopes += slope * slope;
  }
  if (common < 10) return {};
  if (high > low) found.rms_share = std::sqrt(squares / common) / (high - low);
  if (slopes > 0) found.late = -along / slopes;
  return found;
}

CurveRow curve_row(std::string quantity, std::string unit, double closing_angle,
                   std::vector<CurveDeviation> repeats) {
  std::erase_if(repeats, [](const CurveDeviation& d) { return !std::isfinite(d.largest); });
  CurveRow row{std::move(quantity), std::move(unit), closing_angle, static_cast<int>(repeats.size()), {}};
  if (repeats.empty()) return row;
  const auto middle = repeats.begin() + static_cast<std::ptrdiff_t>((repeats.size() - 1) / 2);
  std::nth_element(repeats.begin(), middle, repeats.end(),
                   [](const auto& a, const auto& b) { return a.largest < b.largest; });
  row.median = *middle;
  return row;
}

}  // namespace powbench::host
