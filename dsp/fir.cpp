#include "dsp/fir.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/units.h"
#include "dsp/sos.h"

namespace powbench::dsp {

namespace {

double sinc(double x) {
  return x == 0 ? 1.0 : std::sin(pi * x) / (pi * x);
}

/// Cost of one point of a block, relative, by what the caches hold: measured for pairs, n log n otherwise.
double point_cost(std::size_t n) {
  if (!PairConvolver::available()) return (n > 32768 ? 1.5 : 1.0) * std::log2(static_cast<double>(n));
  return n <= 8192 ? 1.0 : n <= 16384 ? 1.04 : n <= 32768 ? 1.25 : 1.8;
}

/// Block length that costs least for a sample that comes out: n points for n - M + 1 samples.
std::size_t block_length(std::size_t taps) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t n = 256; n <= (std::size_t{1} << 22); n *= 2) {
    if (n < 2 * taps && n < (std::size_t{1} << 22)) continue;
    const double cost = point_cost(n) * static_cast<double>(n) / static_cast<double>(n - taps + 1);
    if (cost < least) least = cost, best = n;
  }
  return best;
}

std::vector<double> checked_taps(std::vector<double> taps) {
  if (taps.size() % 2 == 0 || taps.size() > (std::size_t{1} << 21))
    throw std::invalid_argument("taps = " + std::to_string(taps.size()) + ": allowed odd, up to 2097151");
  for (const double v : taps)
    if (!std::isfinite(v)) throw std::invalid_argument("taps: allowed finite");
  return taps;
}

/// y *= h for all bins, as real arithmetic: std::complex's product looks for NaN.
void multiply(std::span<std::complex<double>> y, const std::vector<std::complex<double>>& h) {
  double* a = reinterpret_cast<double*>(y.data());
  const double* b = reinterpret_cast<const double*>(h.data());
  for (std::size_t k = 0; k < 2 * h.size(); k += 2) {
    const double re = a[k] * b[k] - a[k + 1] * b[k + 1];
    a[k + 1] = a[k] * b[k + 1] + a[k + 1] * b[k];
    a[k] = re;
  }
}

}  // namespace

std::vector<double> design_fir(FilterKind kind, double low_hertz, double high_hertz, double rate,
                               std::size_t taps) {
  if (taps < 3 || taps % 2 == 0) throw FilterDesignError("taps", static_cast<double>(taps), "odd, 3 or more");
  FilterSpec edges{kind, 1, low_hertz, high_hertz, rate};
  design_zpk(edges);  // the same rules for edges and rate
  const double lo = kind == FilterKind::low ? 0 : 2 * low_hertz / rate;
  const double hi = kind == FilterKind::high ? 1 : 2 * high_hertz / rate;
  const double middle = static_cast<double>(taps - 1) / 2;
  std::vector<double> h(taps);
  for (std::size_t i = 0; i < taps; ++i) {
    const double m = static_cast<double>(i) - middle;
    const double window =
        0.54 - 0.46 * std::cos(2 * pi * static_cast<double>(i) / static_cast<double>(taps - 1));
    const double band = hi * sinc(hi * m) - lo * sinc(lo * m);
    h[i] = window * (kind == FilterKind::stop ? sinc(m) - band : band);
  }
  const double at = kind == FilterKind::high ? 1.0 : (kind == FilterKind::band ? (lo + hi) / 2 : 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < taps; ++i) sum += h[i] * std::cos(pi * (static_cast<double>(i) - middle) * at);
  for (double& v : h) v /= sum;
  return h;
}

OverlapSave::OverlapSave(std::vector<double> taps, FftEffort effort)
    : taps_(checked_taps(std::move(taps))), length_(block_length(taps_.size())) {
  if (PairConvolver::available()) {
    pair_.emplace(length_, taps_);
    edge_.resize(4 * length_);
    return;
  }
  fft_.emplace(length_, effort);
  std::copy(taps_.begin(), taps_.end(), fft_->time().begin());
  fft_->forward();
  const auto h = fft_->spectrum();
  response_.assign(h.begin(), h.end());
  for (auto& v : response_) v /= static_cast<double>(length_);
}

void OverlapSave::run(std::span<const double> in, std::span<double> out) {
  if (in.size() != out.size()) throw std::invalid_argument("out: allowed as long as in");
  if (pair_)
    run_pairs(in, out);
  else
    run_one(in, out);
}

namespace {

/// `length` samples from `first` on, zeros outside the record.
void cut(std::span<const double> in, std::ptrdiff_t first, std::span<double> block) {
  const auto size = static_cast<std::ptrdiff_t>(in.size()),
             length = static_cast<std::ptrdiff_t>(block.size());
  const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(first, 0, size);
  const std::ptrdiff_t to = std::clamp<std::ptrdiff_t>(first + length, from, size);
  std::fill(block.begin(), block.begin() + (from - first), 0.0);
  std::copy(in.begin() + from, in.begin() + to, block.begin() + (from - first));
  std::fill(block.begin() + (to - first), block.end(), 0.0);
}

}  // namespace

// A block begins M - 1 samples before the first one it decides, which is `edge` after `start`.

void OverlapSave::run_one(std::span<const double> in, std::span<double> out) {
  const std::size_t step = length_ - taps_.size() + 1;
  for (std::size_t start = 0; start < in.size(); start += step) {
    const auto t = fft_->time();
    cut(in, static_cast<std::ptrdiff_t>(start) - static_cast<std::ptrdiff_t>(edge()), t);
    fft_->forward();
    multiply(fft_->spectrum(), response_);
    fft_->inverse();
    std::copy_n(t.begin() + static_cast<std::ptrdiff_t>(taps_.size() - 1), std::min(step, in.size() - start),
                out.begin() + static_cast<std::ptrdiff_t>(start));
  }
}

void OverlapSave::run_pairs(std::span<const double> in, std::span<double> out) {
  const std::size_t step = length_ - taps_.size() + 1;
  const auto size = static_cast<std::ptrdiff_t>(in.size()), length = static_cast<std::ptrdiff_t>(length_);
  for (std::size_t start = 0; start < in.size(); start += 2 * step) {
    const double* from[2];
    double* to[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t begin = start + k * step;
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(begin) - static_cast<std::ptrdiff_t>(edge());
      const std::span<double> spare = std::span(edge_).subspan(k * length_, length_);
      if (first >= 0 && first + length <= size) {
        from[k] = in.data() + first;
      } else {
        cut(in, std::min(first, size), spare);
        from[k] = spare.data();
      }
      to[k] = begin + step <= in.size() ? out.data() + begin : edge_.data() + (2 + k) * length_;
    }
    pair_->run(from[0], from[1], to[0], to[1], taps_.size() - 1);
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t begin = start + k * step;
      if (begin < in.size() && begin + step > in.size())
        std::copy_n(to[k], in.size() - begin, out.begin() + static_cast<std::ptrdiff_t>(begin));
    }
  }
}

Signal filter_linear_phase(OverlapSave& filter, const Signal& in) {
  if (in.size() <= filter.taps()) throw FilterMemoryError(in.size(), filter.taps());
  Signal out = in;
  filter.run(in.value, out.value);
  for (std::size_t i = 0; i < filter.edge(); ++i) {
    out.masked[i] |= mask_edge;
    out.masked[out.size() - 1 - i] |= mask_edge;
  }
  return out;
}

SpectralFilter::SpectralFilter(std::size_t samples, std::size_t padding, std::span<const double> gain,
                               FftEffort effort)
    : samples_(samples), length_(good_length(samples + padding)), gain_(gain.begin(), gain.end()) {
  if (gain_.size() != length_ / 2 + 1)
    throw std::invalid_argument("gain = " + std::to_string(gain_.size()) + " values: allowed " +
                                std::to_string(length_ / 2 + 1));
  if (LargeSpectralGain::serves(length_)) {
    large_.emplace(length_, gain_, effort);
    return;
  }
  fft_.emplace(length_, effort);
  for (double& g : gain_) g /= static_cast<double>(length_);
}

void SpectralFilter::run(std::span<double> x) {
  if (x.size() != samples_ || x.empty())
    throw std::invalid_argument("record of " + std::to_string(x.size()) + " samples: allowed " +
                                std::to_string(samples_));
  const auto t = large_ ? large_->time() : fft_->time();
  std::copy(x.begin(), x.end(), t.begin());
  const std::size_t padding = t.size() - samples_;
  for (std::size_t i = 0; i < padding; ++i)
    t[samples_ + i] =
        x.back() + (x.front() - x.back()) * static_cast<double>(i + 1) / static_cast<double>(padding + 1);
  if (large_) {
    large_->run();
  } else {
    fft_->forward();
    const auto y = fft_->spectrum();
    for (std::size_t k = 0; k < y.size(); ++k) y[k] *= gain_[k];
    fft_->inverse();
  }
  std::copy_n(t.begin(), samples_, x.begin());
}

std::vector<double> two_pass_gain(std::span<const Section> sections, std::size_t length) {
  const std::vector<Section> s(sections.begin(), sections.end());
  std::vector<double> gain(length / 2 + 1);
  for (std::size_t k = 0; k < gain.size(); ++k)
    gain[k] = std::norm(response(s, static_cast<double>(k) / static_cast<double>(length), 1.0));
  return gain;
}

}  // namespace powbench::dsp
