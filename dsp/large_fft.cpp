#include "dsp/large_fft.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "dsp/fft_batch.h"

namespace powbench::dsp {

namespace {

constexpr std::size_t group = 16;  ///< columns handled together

struct Complex {
  double re, im;
};

Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
Complex conjugate(Complex a) {
  return {a.re, -a.im};
}

/// exp(-2 pi i k / n)
Complex root(std::size_t k, std::size_t n) {
  const double a = -2 * pi * static_cast<double>(k % n) / static_cast<double>(n);
  return {std::cos(a), std::sin(a)};
}

/// Rows of the matrix: the largest power of two, at most 1024, that leaves rows at least as long as columns.
std::size_t split(std::size_t half) {
  std::size_t n1 = 1;
  while (n1 < 1024 && half % (2 * n1) == 0 && 4 * n1 * n1 <= half) n1 *= 2;
  return n1;
}

}  // namespace

/// The record as N1 rows of N2 complex numbers x[2m] + i x[2m + 1]; after columns, twiddle factors and rows the
/// value at (k1, k2) is the transform at k1 + N1 k2.
struct LargeSpectralGain::Work {
  std::size_t n1, n2, half;
  FftBatch columns, rows;
  std::vector<double> gain;                    ///< (n1, n2) in that order, with the scale of both transforms
  double nyquist = 0;                          ///< gain at rate / 2
  std::vector<Complex> inner, base, row_root;  ///< twiddles: (n1, group), (n2 / group, n1), (n2)

  Work(std::size_t length, std::span<const double> g, FftEffort effort)
      : n1(split(length / 2)),
        n2(length / 2 / n1),
        half(length / 2),
        columns(n1, group, group, 1, n1 * group, effort),
        rows(n2, 1, 1, n2, half, effort),
        gain(half) {
    const double scale = 1 / static_cast<double>(half);
    for (std::size_t k1 = 0; k1 < n1; ++k1)
      for (std::size_t k2 = 0; k2 < n2; ++k2) gain[k1 * n2 + k2] = scale * g[k1 + n1 * k2];
    nyquist = scale * g[half];
    for (std::size_t k1 = 0; k1 < n1; ++k1)
      for (std::size_t j = 0; j < group; ++j) inner.push_back(root(k1 * j, half));
    for (std::size_t b = 0; b < n2; b += group)
      for (std::size_t k1 = 0; k1 < n1; ++k1) base.push_back(root(k1 * b, half));
    for (std::size_t k2 = 0; k2 < n2; ++k2) row_root.push_back(root(k2, 2 * n2));
  }

  Complex* matrix() { return reinterpret_cast<Complex*>(rows.data()); }

  void transform_columns(bool forward) {
    Complex* tile = reinterpret_cast<Complex*>(columns.data());
    for (std::size_t b = 0; b < n2; b += group) {
      const Complex* start = base.data() + b / group * n1;
      for (std::size_t r = 0; r < n1; ++r) {
        const Complex* from = matrix() + r * n2 + b;
        if (forward) {
          std::copy_n(from, group, tile + r * group);
          continue;
        }
        for (std::size_t j = 0; j < group; ++j)
          tile[r * group + j] = from[j] * conjugate(start[r] * inner[r * group + j]);
      }
      columns.run(0, forward);
      for (std::size_t r = 0; r < n1; ++r) {
        Complex* to = matrix() + r * n2 + b;
        if (!forward) {
          std::copy_n(tile + r * group, group, to);
          continue;
        }
        for (std::size_t j = 0; j < group; ++j)
          to[j] = tile[r * group + j] * (start[r] * inner[r * group + j]);
      }
    }
  }

  /// Gains at k and M - k on the packed values there. With E and O the transforms of the even and odd samples and
  /// w = exp(-2 pi i k / 2M): E' = s E + d w O, O' = d conj(w) E + s O.
  static void apply(Complex& a, Complex& b, double ga, double gb, Complex w) {
    const double s = (ga + gb) / 2, d = (ga - gb) / 2;
    const Complex e{(a.re + b.re) / 2, (a.im - b.im) / 2}, o{(a.im + b.im) / 2, (b.re - a.re) / 2};
    const Complex wo = w * o, we = conjugate(w) * e;
    const Complex e2{s * e.re + d * wo.re, s * e.im + d * wo.im},
        o2{d * we.re + s * o.re, d * we.im + s * o.im};
    a = {e2.re - o2.im, e2.im + o2.re};
    b = {e2.re + o2.im, o2.re - e2.im};
  }

  void weigh(std::size_t k1) {
    const std::size_t p1 = k1 == 0 ? 0 : n1 - k1;
    Complex *x = matrix() + k1 * n2, *y = matrix() + p1 * n2;
    const double *gx = gain.data() + k1 * n2, *gy = gain.data() + p1 * n2;
    const Complex turn = root(k1, 2 * half);
    if (k1 == 0) {  // k2 with n2 - k2; the first is its own partner and carries 0 and rate / 2
      const Complex z = x[0];
      const double sum = gx[0] * (z.re + z.im), difference = nyquist * (z.re - z.im);
      x[0] = {(sum + difference) / 2, (sum - difference) / 2};
      for (std::size_t k2 = 1; 2 * k2 < n2; ++k2) apply(x[k2], x[n2 - k2], gx[k2], gx[n2 - k2], row_root[k2]);
      if (n2 % 2 == 0) x[n2 / 2] = {x[n2 / 2].re * gx[n2 / 2], x[n2 / 2].im * gx[n2 / 2]};
      return;
    }
    const std::size_t end = k1 == p1 ? n2 / 2 : n2;
    for (std::size_t k2 = 0; k2 < end; ++k2)
      apply(x[k2], y[n2 - 1 - k2], gx[k2], gy[n2 - 1 - k2], turn * row_root[k2]);
    if (k1 == p1 && n2 % 2) x[end] = {x[end].re * gx[end], x[end].im * gx[end]};
  }

  void run() {
    transform_columns(true);
    for (std::size_t k1 = 0; 2 * k1 <= n1; ++k1) {
      const std::size_t p1 = k1 == 0 ? 0 : n1 - k1;
      rows.run(k1 * n2, true);
      if (p1 != k1) rows.run(p1 * n2, true);
      weigh(k1);
      rows.run(k1 * n2, false);
      if (p1 != k1) rows.run(p1 * n2, false);
    }
    transform_columns(false);
  }
};

bool LargeSpectralGain::serves(std::size_t length) {
  if (length < (std::size_t{1} << 17) || length % 2) return false;
  const std::size_t half = length / 2, n1 = split(half);
  return n1 >= 64 && half / n1 % group == 0 && half / n1 <= 32768;
}

LargeSpectralGain::LargeSpectralGain(std::size_t length, std::span<const double> gain, FftEffort effort)
    : work_(std::make_unique<Work>(length, gain, effort)) {}
LargeSpectralGain::~LargeSpectralGain() = default;
LargeSpectralGain::LargeSpectralGain(LargeSpectralGain&&) noexcept = default;
LargeSpectralGain& LargeSpectralGain::operator=(LargeSpectralGain&&) noexcept = default;

std::span<double> LargeSpectralGain::time() {
  return {work_->rows.data(), 2 * work_->half};
}
void LargeSpectralGain::run() {
  work_->run();
}

}  // namespace powbench::dsp
