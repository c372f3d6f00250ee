#include "bench/dsp_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/statistics.h"

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

}  // namespace

void Scorer::add(const std::vector<TrueContact>& truth, const std::vector<Contact>& found) {
  std::vector<bool> used(found.size(), false);
  int matched = 0;
  for (const TrueContact& c : truth) {
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
  return s;
}

}  // namespace powbench::bench
