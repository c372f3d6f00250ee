#include "bench/dsp_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "dsp/signal/least_squares.h"
#include "dsp/signal/statistics.h"

namespace powbench::bench {

namespace {

constexpr double tolerance = 300e-6;

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return x.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(x.size());
}

double rms(std::vector<double> x) {
  for (double& v : x) v *= v;
  return std::sqrt(mean(x));
}

double force(const TrueContact& c, PulseForm form, double exponent, double t) {
  const double v = (t - c.touch) / (c.release - c.touch);
  if (!(v > 0) || !(v < 1)) return 0.0;
  const double base = std::sin(pi * (form == PulseForm::asymmetric ? std::pow(v, 0.8) : v));
  return base > 0 ? c.peak * std::pow(base, exponent) : 0.0;
}

}  // namespace

double touch_bound(const TrueContact& c, PulseForm form, double noise, double rate) {
  if (!std::isfinite(c.release)) return std::numeric_limits<double>::quiet_NaN();
  const double p = form == PulseForm::hertz ? 1.5 : 1.0, width = c.release - c.touch, step = 1e-5 * width;
  std::vector<std::vector<double>> columns(4);
  for (double t = c.touch - 5 / rate; t < c.release + 5 / rate; t += 1 / rate) {
    const auto slope = [&](const TrueContact& up, const TrueContact& down, double h) {
      return (force(up, form, p, t) - force(down, form, p, t)) / (2 * h);
    };
    columns[0].push_back(
        slope({c.touch + step, c.release, c.peak}, {c.touch - step, c.release, c.peak}, step));
    columns[1].push_back(
        slope({c.touch, c.release + step, c.peak}, {c.touch, c.release - step, c.peak}, step));
    columns[2].push_back(force(c, form, p, t) / c.peak);
    columns[3].push_back((force(c, form, p + 1e-4, t) - force(c, form, p - 1e-4, t)) / 2e-4);
  }
  const std::vector<double> zero(columns[0].size(), 0.0);
  return noise * dsp::linear_least_squares(columns, zero).u(0);
}

void Scorer::add(const std::vector<TrueContact>& truth, const std::vector<Contact>& found,
                 const std::vector<double>& bounds) {
  std::vector<bool> used(found.size(), false);
  int matched = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const TrueContact& c = truth[k];
    std::size_t best = found.size();
    double distance = tolerance;
    for (std::size_t j = 0; j < found.size(); ++j) {
      const double d = std::abs(found[j].touch.value - c.touch);
      if (!used[j] && d < distance) distance = d, best = j;
    }
    if (best == found.size()) {
      ++missed_;
      continue;
    }
    used[best] = true;
    ++matched;
    const Contact& f = found[best];
    const double e = f.touch.value - c.touch;
    touch_.push_back(e);
    if (k < bounds.size() && std::isfinite(bounds[k])) bound_.push_back(e / bounds[k]);
    if (std::isfinite(f.touch.u) && f.touch.u > 0) z_.push_back(e / f.touch.u);
    if (!std::isfinite(c.release) || !f.release.known() ||
        std::abs(f.release.value - c.release) > 4 * tolerance)
      continue;
    const double r = f.release.value - c.release;
    release_.push_back(r);
    duration_.push_back(r - e);
    if (std::isfinite(f.release.u) && f.release.u > 0) z_.push_back(r / f.release.u);
    if (f.peak.known()) peak_.push_back(f.peak.value / c.peak - 1);
  }
  matched_ += matched;
  invented_ += static_cast<int>(found.size()) - matched;
  exact_ += found.size() == truth.size() && matched == static_cast<int>(truth.size());
  ++records_;
}

Score Scorer::score() const {
  Score s;
  s.records = records_;
  s.recall = static_cast<double>(matched_) / std::max(1, matched_ + missed_);
  s.precision = static_cast<double>(matched_) / std::max(1, matched_ + invented_);
  s.exact = static_cast<double>(exact_) / std::max(1, records_);
  s.touch_rmse = rms(touch_);
  s.touch_bias = mean(touch_);
  std::vector<double> magnitude = touch_;
  for (double& v : magnitude) v = std::abs(v);
  s.touch_median = dsp::median(magnitude);
  s.release_rmse = rms(release_);
  s.release_bias = mean(release_);
  s.duration_bias = mean(duration_);
  s.peak_bias = mean(peak_);
  s.z_std = rms(z_);
  s.bound_ratio = rms(bound_);
  return s;
}

}  // namespace powbench::bench
