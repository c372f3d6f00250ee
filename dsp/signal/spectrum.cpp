#include "dsp/signal/spectrum.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/units.h"

namespace powbench::dsp {

namespace {

std::size_t checked_size(std::size_t n, double rate) {
  if (n < 8) throw std::invalid_argument("n = " + std::to_string(n) + ": allowed 8 samples or more");
  if (!(rate > 0) || !std::isfinite(rate))
    throw std::invalid_argument("rate = " + std::to_string(rate) + ": allowed > 0 Hz");
  return n;
}

void require_finite(double sum) {
  if (!std::isfinite(sum)) throw std::invalid_argument("record: allowed finite values only");
}

}  // namespace

double Spectrum::power(double low, double high) const {
  double sum = 0;
  for (std::size_t k = 0; k < density.size(); ++k)
    if (hertz(k) >= low && hertz(k) < high) sum += density[k];
  return sum * bin_hertz;
}

double coherence_threshold(std::size_t averages, double probability) {
  if (averages < 2 || !(probability > 0) || !(probability < 1))
    throw std::invalid_argument("averages = " + std::to_string(averages) + ", probability = " +
                                std::to_string(probability) + ": allowed >= 2 and 0 .. 1");
  return 1 - std::pow(probability, 1.0 / static_cast<double>(averages - 1));
}

SpectrumEstimator::SpectrumEstimator(std::size_t n, double rate, FftEffort effort)
    : fft_(checked_size(n, rate), effort), rate_(rate), window_(n) {
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    window_[i] = 0.5 - 0.5 * std::cos(2 * pi * static_cast<double>(i) / static_cast<double>(n));
    squares += window_[i] * window_[i];
  }
  for (double& w : window_) w /= std::sqrt(rate * squares);  // |spectrum|^2 is then a two-sided density
}

void SpectrumEstimator::clear() {
  const std::size_t bins = size() / 2 + 1;
  xx_.assign(bins, 0.0);
  yy_.assign(bins, 0.0);
  xy_.assign(bins, 0.0);
}

void SpectrumEstimator::load(std::span<const double> x) {
  constexpr std::size_t ways = 8;  // eight sums side by side: fast, and the same on every machine
  double part[ways]{};
  std::size_t i = 0;
  for (; i + ways <= x.size(); i += ways)
    for (std::size_t w = 0; w < ways; ++w) part[w] += x[i + w];
  double sum = 0;
  for (; i < x.size(); ++i) sum += x[i];
  for (const double p : part) sum += p;
  require_finite(sum);
  const double mean = sum / static_cast<double>(x.size());
  double* t = fft_.time().data();
  for (std::size_t k = 0; k < x.size(); ++k) t[k] = (x[k] - mean) * window_[k];
  fft_.forward();
}

void SpectrumEstimator::add(std::span<const double> x, std::span<const double> y) {
  load(x);
  const auto s = fft_.spectrum();
  const std::size_t bins = s.size();
  if (y.empty()) {
    const double* a = reinterpret_cast<const double*>(s.data());
    for (std::size_t k = 0; k < bins; ++k) xx_[k] += a[2 * k] * a[2 * k] + a[2 * k + 1] * a[2 * k + 1];
    return;
  }
  first_.assign(s.begin(), s.end());
  load(y);
  const double* a = reinterpret_cast<const double*>(first_.data());
  const double* b = reinterpret_cast<const double*>(s.data());
  double* c = reinterpret_cast<double*>(xy_.data());
  for (std::size_t k = 0; k < bins; ++k) {
    const double ar = a[2 * k], ai = a[2 * k + 1], br = b[2 * k], bi = b[2 * k + 1];
    xx_[k] += ar * ar + ai * ai;
    yy_[k] += br * br + bi * bi;
    c[2 * k] += ar * br + ai * bi;
    c[2 * k + 1] += ar * bi - ai * br;
  }
}

Coherence SpectrumEstimator::result(std::size_t averages) {
  Coherence out;
  const std::size_t bins = size() / 2 + 1;
  out.averages = out.x.averages = out.y.averages = averages;
  out.bin_hertz = out.x.bin_hertz = out.y.bin_hertz = rate_ / static_cast<double>(size());
  out.value.resize(bins);
  out.x.density.resize(bins);
  out.y.density.resize(bins);
  for (std::size_t k = 0; k < bins; ++k) {
    const double product = xx_[k] * yy_[k];
    out.value[k] = product > 0 ? std::min(1.0, std::norm(xy_[k]) / product) : 0.0;
    const bool both_sides = k > 0 && 2 * k < size();
    const double scale = (both_sides ? 2.0 : 1.0) / static_cast<double>(averages);
    out.x.density[k] = xx_[k] * scale;
    out.y.density[k] = yy_[k] * scale;
  }
  return out;
}

Spectrum SpectrumEstimator::welch(std::span<const double> x) {
  const std::size_t n = size(), step = n - n / 2;
  if (x.size() < n)
    throw std::invalid_argument("record of " + std::to_string(x.size()) + " samples: allowed " +
                                std::to_string(n) + " or more");
  clear();
  std::size_t count = 0;
  for (std::size_t i = 0; i + n <= x.size(); i += step, ++count) add(x.subspan(i, n), {});
  return result(count).x;
}

Coherence SpectrumEstimator::coherence(std::span<const double> x, std::span<const double> y) {
  const std::size_t n = size(), step = n - n / 2;
  if (x.size() < n || x.size() != y.size())
    throw std::invalid_argument("records of " + std::to_string(x.size()) + " and " +
                                std::to_string(y.size()) + " samples: allowed equal, " + std::to_string(n) +
                                " or more");
  clear();
  std::size_t count = 0;
  for (std::size_t i = 0; i + n <= x.size(); i += step, ++count) add(x.subspan(i, n), y.subspan(i, n));
  return result(count);
}

Coherence SpectrumEstimator::shot_coherence(std::span<const std::span<const double>> x,
                                            std::span<const std::span<const double>> y) {
  if (x.size() < 3 || x.size() != y.size())
    throw std::invalid_argument("closings = " + std::to_string(x.size()) + " and " +
                                std::to_string(y.size()) +
                                ": allowed equal, 3 or more (the coherence of fewer says nothing)");
  clear();
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (x[k].size() != size() || y[k].size() != size())
      throw std::invalid_argument("closing " + std::to_string(k) + ": allowed " + std::to_string(size()) +
                                  " samples");
    add(x[k], y[k]);
  }
  return result(x.size());
}

}  // namespace powbench::dsp
