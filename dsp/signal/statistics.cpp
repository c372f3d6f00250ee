#include "dsp/signal/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/normal.h"
#include "dsp/signal/wide.h"

namespace powbench::dsp {

namespace {

std::vector<double> gaussian_half_kernel(double sigma) {
  if (!(sigma > 0.05)) return {1.0};
  const auto half = static_cast<std::size_t>(std::ceil(4.0 * sigma));
  std::vector<double> k(half + 1);
  double sum = 0;
  for (std::size_t i = 0; i <= half; ++i) {
    const double u = static_cast<double>(i) / sigma;
    k[i] = std::exp(-0.5 * u * u);
    sum += i ? 2 * k[i] : k[i];
  }
  for (double& v : k) v /= sum;
  return k;
}

/// Shortens v to its values between two that enclose the middle by a sample of it, and `place` to the place among them;
/// false where the sample was wrong. One pass that takes a quarter of v costs less than a selection among all.
bool keep_middle(std::vector<double>& v, std::size_t& place) {
  constexpr std::size_t sample = 63, middle = sample / 2, margin = 8;
  double of[sample];
  for (std::size_t k = 0; k < sample; ++k) of[k] = v[k * v.size() / sample];
  std::sort(of, of + sample);
  const double low = of[middle - margin], high = of[middle + margin];
  std::size_t below = 0, kept = 0;
  std::vector<double> between(v.size());
  for (const double x : v) {
    between[kept] = x;
    kept += static_cast<std::size_t>(x >= low) & static_cast<std::size_t>(x <= high);
    below += x < low;
  }
  // one more below the place: an even number of values has two in the middle
  if (place <= below || place >= below + kept) return false;
  place -= below;
  between.resize(kept);
  v.swap(between);
  return true;
}

/// Reorders and shortens; not empty.
double median_of(std::vector<double>& v) {
  const bool odd = v.size() % 2 != 0;
  std::size_t h = v.size() / 2;
  if (v.size() >= 512) keep_middle(v, h);
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(h), v.end());
  if (odd) return v[h];
  return 0.5 * (v[h] + *std::max_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(h)));
}

}  // namespace

double median(std::span<const double> x) {
  if (x.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> v(x.begin(), x.end());
  return median_of(v);
}

double robust_sigma(std::span<const double> x) {
  if (x.empty()) return 0.0;
  const double m = median(x);
  std::vector<double> v(x.begin(), x.end());
  for (double& d : v) d = std::abs(d - m);
  return 1.4826 * median_of(v);
}

double reduced_chi2_quantile(double p, double dof) {
  const double c = 2.0 / (9.0 * dof);
  const double base = std::max(1.0 - c + normal_quantile(p) * std::sqrt(c), 0.0);
  return base * base * base;
}

namespace {

/// y += k (a[i - j] + a[i + j]) of all taps j, a stretch of y at a time that stays near the processor.
POWBENCH_WIDE void add_taps(std::span<double> y, const double* middle, std::span<const double> k) {
  constexpr std::size_t stretch = 1024;
  for (std::size_t from = 0; from < y.size(); from += stretch) {
    const std::size_t to = std::min(y.size(), from + stretch);
    for (std::size_t i = from; i < to; ++i) y[i] = k[0] * middle[i];
    for (std::size_t j = 1; j < k.size(); ++j) {
      const double *before = middle - j, *after = middle + j, share = k[j];
      for (std::size_t i = from; i < to; ++i) y[i] += share * (before[i] + after[i]);
    }
  }
}

}  // namespace

std::vector<double> gaussian_smooth(std::span<const double> x, double sigma) {
  const auto k = gaussian_half_kernel(sigma);
  const std::size_t n = x.size(), half = k.size() - 1;
  std::vector<double> y(n, 0.0);
  if (n == 0) return y;
  std::vector<double> padded(n + 2 * half);
  std::fill_n(padded.begin(), half, x.front());
  std::copy(x.begin(), x.end(), padded.begin() + static_cast<std::ptrdiff_t>(half));
  std::fill(padded.end() - static_cast<std::ptrdiff_t>(half), padded.end(), x.back());
  add_taps(y, padded.data() + half, k);
  return y;
}

std::vector<double> bell_mean(std::span<const double> x, double sigma) {
  // A running mean of 2 h + 1 samples has the variance (h^2 + h) / 3; three of them are to have sigma^2.
  const auto half =
      static_cast<std::size_t>(std::lround(std::max(0.0, std::sqrt(0.25 + sigma * sigma) - 0.5)));
  const std::size_t n = x.size();
  std::vector<double> y(x.begin(), x.end()), in(n);
  const double share = 1.0 / static_cast<double>(2 * half + 1);
  for (int pass = 0; pass < 3; ++pass) {
    in.swap(y);
    double sum = 0;
    for (std::size_t i = 0; i < std::min(half, n); ++i) sum += in[i];
    const auto step = [&](std::size_t i) {
      if (i + half < n) sum += in[i + half];
      if (i > half) sum -= in[i - half - 1];
      y[i] = sum * share;
    };
    const std::size_t first = std::min(half + 1, n), last = std::max(first, n > half ? n - half : 0);
    for (std::size_t i = 0; i < first; ++i) step(i);
    for (std::size_t i = first; i < last; ++i) {
      sum += in[i + half] - in[i - half - 1];  // one sum to wait for a sample
      y[i] = sum * share;
    }
    for (std::size_t i = last; i < n; ++i) step(i);
  }
  return y;
}

double gaussian_noise_gain(double sigma) {
  const auto k = gaussian_half_kernel(sigma);
  double sum = k[0] * k[0];
  for (std::size_t i = 1; i < k.size(); ++i) sum += 2 * k[i] * k[i];
  return std::sqrt(sum);
}

}  // namespace powbench::dsp
