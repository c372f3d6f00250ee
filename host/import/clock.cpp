#include "host/import/clock.h"

#include <algorithm>
#include <cmath>

namespace powbench::host {

namespace {

std::vector<double> intervals(std::span<const double> t) {
  std::vector<double> d(t.size() - 1);
  for (std::size_t i = 0; i + 1 < t.size(); ++i) d[i] = t[i + 1] - t[i];
  return d;
}

double quantile(std::vector<double> x, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), x.begin() + at, x.end());
  return x[static_cast<std::size_t>(at)];
}

/// Mean of the intervals near their median: stamps that were rounded have a median that is not the clock's.
double mean_interval(const std::vector<double>& d) {
  const double middle = quantile(d, 0.5);
  double sum = 0, n = 0;
  for (const double v : d)
    if (v > 0.4 * middle && v < 1.6 * middle) sum += v, n += 1;
  return sum / n;
}

/// Half of the last decimal digit the stamps were written with.
double half_digit(std::span<const double> t) {
  const double largest = std::max(std::abs(t.front()), std::abs(t.back()));
  for (int digits = 0; digits <= 13; ++digits) {
    const double scale = std::pow(10.0, digits);
    if (largest * scale > 1e14) break;
    const bool all = std::all_of(t.begin(), t.end(), [&](double v) {
      const double scaled = v * scale;
      return std::abs(scaled - std::round(scaled)) < 1e-3 + 4e-16 * std::abs(scaled);
    });
    if (all) return 0.5 / scale;
  }
  return 0.0;
}

struct Line {
  double t0 = 0, dt = 0;
};

/// Least squares of the stamps over their ticks.
Line fit_line(std::span<const double> t, const std::vector<std::int64_t>& k) {
  const auto n = static_cast<double>(t.size());
  double mean_t = 0, mean_k = 0;
  for (std::size_t i = 0; i < t.size(); ++i) mean_t += t[i] / n, mean_k += static_cast<double>(k[i]) / n;
  double kk = 0, kt = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double dk = static_cast<double>(k[i]) - mean_k;
    kk += dk * dk;
    kt += dk * (t[i] - mean_t);
  }
  const double dt = kt / kk;
  return {mean_t - dt * mean_k, dt};
}

double largest_error(std::span<const double> t, const std::vector<std::int64_t>& k, const Line& line) {
  double worst = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    worst = std::max(worst, std::abs(t[i] - line.t0 - line.dt * static_cast<double>(k[i])));
  return worst;
}

/// The roundest rate that moves no tick by more than `freedom` over `ticks`.
double round_rate(double rate, double ticks, double freedom) {
  for (int digits = 1; digits <= 12; ++digits) {
    const double step = std::pow(10.0, std::floor(std::log10(rate)) + 1 - digits);
    const double candidate = std::round(rate / step) * step;
    if (candidate > 0 && ticks * std::abs(1 / candidate - 1 / rate) <= freedom) return candidate;
  }
  return rate;
}

std::vector<std::int64_t> ticks_of(std::span<const double> t, double dt) {
  std::vector<std::int64_t> k(t.size(), 0);
  for (std::size_t i = 1; i < t.size(); ++i)
    k[i] = k[i - 1] + std::max<std::int64_t>(1, std::llround(std::min((t[i] - t[i - 1]) / dt, 1e15)));
  return k;
}

void even_clock(UniformClock& c, std::span<const double> t, std::vector<std::int64_t> k, Line line,
                double worst) {
  const auto span = static_cast<double>(k.back());
  c.rate = round_rate(1 / line.dt, span, std::max(0.5 * worst, 1e-4 * line.dt));
  double mean = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    mean += (t[i] - static_cast<double>(k[i]) / c.rate) / static_cast<double>(t.size());
  c.t0 = mean;
  c.error = largest_error(t, k, {c.t0, 1 / c.rate});
  c.n = static_cast<std::size_t>(k.back()) + 1;
  for (std::size_t i = 1; i < k.size(); ++i)
    if (k[i] - k[i - 1] > 1) c.gaps.push_back({k[i - 1] + 1, k[i] - k[i - 1] - 1});
  c.tick = std::move(k);
}

void uneven_clock(UniformClock& c, std::span<const double> t, const std::vector<double>& d) {
  const double middle = quantile(d, 0.5), quick = quantile(d, 0.1);
  double dt = quick < 0.2 * middle ? quick : mean_interval(d);  // bursts set the pace, rests become gaps
  const double span = t.back() - t.front();
  c.even = false;
  c.rate = round_rate(1 / dt, 1, 0.02 * dt);
  dt = 1 / c.rate;
  c.t0 = t.front();
  c.n = static_cast<std::size_t>(std::min(std::floor(span / dt + 1e-9), 1e12)) + 1;
  c.error = 0.5 * dt;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (d[i] <= 3 * dt) continue;
    const auto first = static_cast<std::int64_t>(std::ceil((t[i] + 1.5 * dt - c.t0) / dt));
    const auto last = static_cast<std::int64_t>(std::floor((t[i + 1] - 1.5 * dt - c.t0) / dt));
    if (last >= first) c.gaps.push_back({first, last - first + 1});
  }
}

/// Lagrange cubic through four points.
double cubic(const double* t, const double* v, double x) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    double w = v[i];
    for (int j = 0; j < 4; ++j)
      if (j != i) w *= (x - t[j]) / (t[i] - t[j]);
    sum += w;
  }
  return sum;
}

bool alike(const double* t) {
  const double a = t[1] - t[0], b = t[2] - t[1], c = t[3] - t[2];
  return std::max({a, b, c}) <= 3 * std::min({a, b, c});
}

}  // namespace

StampMistake check_stamps(std::span<const double> t) {
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!std::isfinite(t[i])) return {i, "has no number"};
    if (i == 0) continue;
    if (t[i] == t[i - 1]) return {i, "stands there twice"};
    if (t[i] < t[i - 1]) return {i, "is earlier than the one before"};
  }
  return {};
}

UniformClock find_clock(std::span<const double> t) {
  UniformClock c;
  const std::vector<double> d = intervals(t);
  const double dt = mean_interval(d);
  std::vector<std::int64_t> k = ticks_of(t, dt);
  const Line line = fit_line(t, k);
  const double worst = largest_error(t, k, line);
  const bool even = worst <= 0.05 * line.dt || (worst <= 0.5 * line.dt && worst <= 1.1 * half_digit(t));
  if (even)
    even_clock(c, t, std::move(k), line, worst);
  else
    uneven_clock(c, t, d);
  return c;
}

std::vector<double> resample(const UniformClock& c, std::span<const double> seconds,
                             std::span<const double> values, double& correction) {
  std::vector<double> t, v;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    t.push_back(seconds[i]);
    v.push_back(values[i]);
  }
  correction = 0;
  std::vector<double> out(c.n, v.empty() ? 0.0 : v.front());
  if (v.size() < 2) return out;
  std::size_t i = 0;
  for (std::size_t k = 0; k < c.n; ++k) {
    const double x = c.time(k);
    while (i + 2 < t.size() && t[i + 1] <= x) ++i;
    const double share = std::clamp((x - t[i]) / (t[i + 1] - t[i]), 0.0, 1.0);
    const double straight = v[i] + share * (v[i + 1] - v[i]);
    out[k] = straight;
    const bool inside = i > 0 && i + 2 < t.size() && x >= t[i] && x <= t[i + 1];
    if (!inside || !alike(&t[i - 1])) continue;
    out[k] = cubic(&t[i - 1], &v[i - 1], x);
    correction = std::max(correction, std::abs(out[k] - straight));
  }
  return out;
}

}  // namespace powbench::host
