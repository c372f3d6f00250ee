#include "dsp/pair_convolver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/units.h"
#include "dsp/pair_kernel.h"

namespace powbench::dsp {

namespace {

struct Aligned {
  explicit Aligned(std::size_t n)
      : data(static_cast<double*>(::operator new(n * sizeof(double), std::align_val_t(64)))) {
    std::fill_n(data, n, 0.0);
  }
  ~Aligned() { ::operator delete(data, std::align_val_t(64)); }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;
  double* data;
};

/// For each 8 columns, q = 1 .. radix - 1: cosines, negative sines.
std::unique_ptr<Aligned> twiddles(std::size_t length, int radix) {
  const std::size_t stride = length / static_cast<std::size_t>(radix);
  auto table = std::make_unique<Aligned>(2 * stride * static_cast<std::size_t>(radix - 1));
  double* at = table->data;
  for (std::size_t j = 0; j < stride; j += pair_lanes)
    for (int q = 1; q < radix; ++q, at += 16)
      for (std::size_t lane = 0; lane < pair_lanes; ++lane) {
        const std::size_t turns = (j + lane) * static_cast<std::size_t>(q) % length;
        const double angle = 2 * pi * static_cast<double>(turns) / static_cast<double>(length);
        at[lane] = std::cos(angle);
        at[8 + lane] = -std::sin(angle);
      }
  return table;
}

/// Radix 8 as long as it goes, the rest in fours: the levels above pieces of 64.
std::vector<int> radices(int levels) {
  std::vector<int> list;
  while (levels > 0) {
    const int bits = levels == 2 || levels == 4 ? 2 : 3;
    list.push_back(1 << bits);
    levels -= bits;
  }
  return list;
}

}  // namespace

struct PairConvolver::Tables {
  /// The imaginary parts are a few lines further on than the real ones, so that they do not fall into the same cache sets.
  static constexpr std::size_t offset = 264;
  explicit Tables(std::size_t n) : re(n), im(n + offset), response(2 * n), spare(n) {}
  Aligned re, im, response, spare;
  std::vector<std::unique_ptr<Aligned>> twiddle;
  std::vector<PairLevel> level;
  PairPlan plan{};
};

bool PairConvolver::available() {
#ifdef __x86_64__
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

PairConvolver::PairConvolver(std::size_t length, std::span<const double> taps) : length_(length) {
  if (!std::has_single_bit(length) || length < 256 || length > (std::size_t{1} << 22) || taps.size() > length)
    throw std::invalid_argument("length = " + std::to_string(length) +
                                ": allowed a power of two, 256 .. 4194304, not below the number of taps");
  tables_ = std::make_unique<Tables>(length);
  Tables& t = *tables_;
  std::size_t piece = length;
  for (const int radix : radices(std::countr_zero(length) - std::countr_zero(pair_leaf))) {
    t.twiddle.push_back(twiddles(piece, radix));
    t.level.push_back({piece, radix, t.twiddle.back()->data});
    piece /= static_cast<std::size_t>(radix);
  }
  t.twiddle.push_back(twiddles(pair_leaf, 8));
  t.plan = {t.level.data(),  t.level.size(), t.twiddle.back()->data,
            t.response.data, t.re.data,      t.im.data + Tables::offset};
  const std::vector<double> zero(length, 0.0);
  std::vector<double> h(length, 0.0);
  for (std::size_t k = 0; k < taps.size(); ++k) h[k] = taps[k] / static_cast<double>(length);
  pair_forward(t.plan, h.data(), zero.data(), t.response.data);
}
PairConvolver::~PairConvolver() = default;
PairConvolver::PairConvolver(PairConvolver&&) noexcept = default;
PairConvolver& PairConvolver::operator=(PairConvolver&&) noexcept = default;

void PairConvolver::run(const double* a, const double* b, double* out_a, double* out_b, std::size_t skip) {
  Tables& t = *tables_;
  const int rows = t.level.front().radix;
  const std::size_t stride = length_ / static_cast<std::size_t>(rows);
  double *row_a[8]{}, *row_b[8]{};
  int partial = -1;
  for (int r = 0; r < rows; ++r) {
    const std::size_t first = static_cast<std::size_t>(r) * stride;
    if (first >= skip) {  // all of the row is wanted, where it belongs
      row_a[r] = out_a + (first - skip);
      row_b[r] = out_b + (first - skip);
      continue;
    }
    row_a[r] = t.spare.data;
    row_b[r] = t.spare.data + stride;
    if (first + stride > skip) partial = r;
  }
  pair_convolve(t.plan, a, b, row_a, row_b);
  if (partial < 0) return;
  const std::size_t from = skip - static_cast<std::size_t>(partial) * stride;
  std::copy(t.spare.data + from, t.spare.data + stride, out_a);
  std::copy(t.spare.data + stride + from, t.spare.data + 2 * stride, out_b);
}

}  // namespace powbench::dsp
