#pragma once

#include <cstddef>

#include "dsp/signal/gram.h"

/// The loop of gram.h. Included by one source file for each instruction set; internal linkage throughout.

namespace powbench::dsp {

namespace {

constexpr std::size_t gram_lanes = 8;

/// Partial sums in registers of the processor: all eight of a product in one, or in `Parts` passes over the rows.
template <std::size_t Parts>
struct GramLanes;
#define POWBENCH_GRAM_LANES(parts, bytes)                                                        \
  template <>                                                                                    \
  struct GramLanes<parts> {                                                                      \
    static constexpr std::size_t width = gram_lanes / parts;                                     \
    using Type = double __attribute__((vector_size(bytes)));                                     \
    using View = double __attribute__((vector_size(bytes), aligned(sizeof(double)), may_alias)); \
  };
POWBENCH_GRAM_LANES(1, 64)
POWBENCH_GRAM_LANES(2, 32)
POWBENCH_GRAM_LANES(4, 16)
#undef POWBENCH_GRAM_LANES

/// M x N products at once: their columns are read once a pass.
template <std::size_t M, std::size_t N, std::size_t Parts>
void gram_block(const double* a, std::size_t as, const double* b, std::size_t bs, std::size_t rows, double* c,
                std::size_t cs) {
  using L = GramLanes<Parts>;
  using Lanes = typename L::Type;
  using View = typename L::View;
  double partial[M][N][gram_lanes] = {};
  for (std::size_t from = 0; from < gram_lanes; from += L::width) {
    Lanes sum[M][N] = {};
    for (std::size_t r = from; r + gram_lanes - from <= rows; r += gram_lanes) {
      Lanes y[N];
      for (std::size_t k = 0; k < N; ++k) y[k] = *reinterpret_cast<const View*>(b + k * bs + r);
      for (std::size_t i = 0; i < M; ++i) {
        const Lanes x = *reinterpret_cast<const View*>(a + i * as + r);
        for (std::size_t k = 0; k < N; ++k) sum[i][k] += x * y[k];
      }
    }
    for (std::size_t i = 0; i < M; ++i)
      for (std::size_t k = 0; k < N; ++k) *reinterpret_cast<View*>(&partial[i][k][from]) = sum[i][k];
  }
  for (std::size_t i = 0; i < M; ++i)
    for (std::size_t k = 0; k < N; ++k) {
      const double* v = partial[i][k];
      double total = ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
      for (std::size_t q = rows - rows % gram_lanes; q < rows; ++q) total += a[i * as + q] * b[k * bs + q];
      c[i + k * cs] = total;
    }
}

using GramBlock = void (*)(const double*, std::size_t, const double*, std::size_t, std::size_t, double*,
                           std::size_t);

/// All products, in blocks of at most 4 x 3; fewer at the ends.
template <std::size_t Parts>
void gram_run(const ColumnSet& a, const ColumnSet& b, std::size_t rows, double* c, std::size_t cs,
              bool upper) {
  constexpr std::size_t m = 4, n = 3;
  static constexpr GramBlock blocks[m][n] = {
      {gram_block<1, 1, Parts>, gram_block<1, 2, Parts>, gram_block<1, 3, Parts>},
      {gram_block<2, 1, Parts>, gram_block<2, 2, Parts>, gram_block<2, 3, Parts>},
      {gram_block<3, 1, Parts>, gram_block<3, 2, Parts>, gram_block<3, 3, Parts>},
      {gram_block<4, 1, Parts>, gram_block<4, 2, Parts>, gram_block<4, 3, Parts>}};
  for (std::size_t k = 0; k < b.count; k += n) {
    const std::size_t wide = b.count - k < n ? b.count - k : n;
    const std::size_t end = upper && k + wide < a.count ? k + wide : a.count;
    for (std::size_t i = 0; i < end; i += m) {
      const std::size_t high = end - i < m ? end - i : m;
      blocks[high - 1][wide - 1](a.data + i * a.stride, a.stride, b.data + k * b.stride, b.stride, rows,
                                 c + i + k * cs, cs);
    }
  }
}

}  // namespace

}  // namespace powbench::dsp
