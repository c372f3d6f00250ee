#pragma once

#include <cstddef>

#include "dsp/gram.h"

/// The loop of gram.h. Included by one source file for each instruction set; internal linkage throughout.

namespace powbench::dsp {

namespace {

using Lanes = double __attribute__((vector_size(64)));
using UnalignedLanes = double __attribute__((vector_size(64), aligned(sizeof(double)), may_alias));
constexpr std::size_t gram_lanes = 8;

inline double sum_of(const Lanes& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

/// M x N products at once: their columns are read once.
template <std::size_t M, std::size_t N>
inline void gram_block(const double* a, std::size_t as, const double* b, std::size_t bs, std::size_t rows,
                       double* c, std::size_t cs) {
  Lanes sum[M][N] = {};
  std::size_t r = 0;
  for (; r + gram_lanes <= rows; r += gram_lanes) {
    Lanes x[M], y[N];
    for (std::size_t i = 0; i < M; ++i) x[i] = *reinterpret_cast<const UnalignedLanes*>(a + i * as + r);
    for (std::size_t k = 0; k < N; ++k) y[k] = *reinterpret_cast<const UnalignedLanes*>(b + k * bs + r);
    for (std::size_t i = 0; i < M; ++i)
      for (std::size_t k = 0; k < N; ++k) sum[i][k] += x[i] * y[k];
  }
  for (std::size_t i = 0; i < M; ++i)
    for (std::size_t k = 0; k < N; ++k) {
      double total = sum_of(sum[i][k]);
      for (std::size_t q = r; q < rows; ++q) total += a[i * as + q] * b[k * bs + q];
      c[i + k * cs] = total;
    }
}

template <std::size_t M>
void gram_run(const ColumnSet& a, const ColumnSet& b, std::size_t rows, double* c, std::size_t cs,
              bool upper) {
  for (std::size_t k = 0; k < b.count; k += 2) {
    const double* y = b.data + k * b.stride;
    const bool two = k + 2 <= b.count;
    const std::size_t end = upper ? (a.count < k + 2 ? a.count : k + 2) : a.count;
    for (std::size_t i = 0; i < end;) {
      const double* x = a.data + i * a.stride;
      double* out = c + i + k * cs;
      const bool block = i + M <= end;
      if (block && two)
        gram_block<M, 2>(x, a.stride, y, b.stride, rows, out, cs);
      else if (block)
        gram_block<M, 1>(x, a.stride, y, b.stride, rows, out, cs);
      else if (two)
        gram_block<1, 2>(x, a.stride, y, b.stride, rows, out, cs);
      else
        gram_block<1, 1>(x, a.stride, y, b.stride, rows, out, cs);
      i += block ? M : 1;
    }
  }
}

}  // namespace

}  // namespace powbench::dsp
