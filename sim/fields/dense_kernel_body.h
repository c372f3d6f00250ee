#pragma once

#include <cstddef>

#include "sim/fields/dense_kernel.h"

/// The loops of dense_kernel.h. Included by one source file for each instruction set, which sets `lanes` (doubles in a
/// vector) and `columns` (of a register tile); internal linkage throughout.

namespace powbench::sim {

namespace {

using Vector = double __attribute__((vector_size(lanes * sizeof(double))));
using Unaligned =
    double __attribute__((vector_size(lanes * sizeof(double)), aligned(sizeof(double)), may_alias));

inline Vector load(const double* p) {
  return *reinterpret_cast<const Unaligned*>(p);
}

inline void take_off(double* c, Vector v, int rows) {
  if (rows >= lanes) {
    *reinterpret_cast<Unaligned*>(c) = load(c) - v;
    return;
  }
  for (int r = 0; r < rows; ++r) c[r] -= v[r];
}

/// V vectors of rows, N columns. `rows` of them are written.
template <int V, int N>
inline void tile(double* c, std::ptrdiff_t ldc, const double* a, std::ptrdiff_t lda, const double* b, int k,
                 int rows) {
  Vector sum[V][N];
  for (int v = 0; v < V; ++v)
    for (int j = 0; j < N; ++j) sum[v][j] = Vector{};
  for (int p = 0; p < k; ++p, a += lda, b += lda)
    for (int v = 0; v < V; ++v) {
      const Vector x = load(a + v * lanes);
      for (int j = 0; j < N; ++j) sum[v][j] += x * b[j];
    }
  for (int j = 0; j < N; ++j)
    for (int v = 0; v < V; ++v) take_off(c + j * ldc + v * lanes, sum[v][j], rows - v * lanes);
}

template <int N>
inline void strip(double* c, std::ptrdiff_t ldc, const double* a, std::ptrdiff_t lda, const double* b, int m,
                  int k) {
  constexpr int two = 2 * lanes;
  int i = 0;
  for (; i + lanes < m; i += two) tile<2, N>(c + i, ldc, a + i, lda, b, k, m - i);
  if (i < m) tile<1, N>(c + i, ldc, a + i, lda, b, k, m - i);
}

/// C -= A B^T, n <= columns.
inline void subtract_strip(double* c, int ldc, const double* a, const double* b, int ld, int m, int n,
                           int k) {
  if constexpr (columns >= 8) {
    if (n == 8) return strip<8>(c, ldc, a, ld, b, m, k);
    if (n == 7) return strip<7>(c, ldc, a, ld, b, m, k);
    if (n == 6) return strip<6>(c, ldc, a, ld, b, m, k);
    if (n == 5) return strip<5>(c, ldc, a, ld, b, m, k);
  }
  if (n == 4) return strip<4>(c, ldc, a, ld, b, m, k);
  if (n == 3) return strip<3>(c, ldc, a, ld, b, m, k);
  if (n == 2) return strip<2>(c, ldc, a, ld, b, m, k);
  return strip<1>(c, ldc, a, ld, b, m, k);
}

inline int least(int a, int b) {
  return a < b ? a : b;
}

void subtract_square(double* c, int ldc, const double* a, int lda, int m, int n, int k) {
  for (int j = 0; j < n; j += columns)
    subtract_strip(c + j + static_cast<std::ptrdiff_t>(j) * ldc, ldc, a + j, a + j, lda, m - j,
                   least(columns, n - j), k);
}

/// The same for a few columns, one by one.
int factor_few(double* a, std::ptrdiff_t lda, int m, int n) {
  for (int j = 0; j < n; ++j) {
    double* const column = a + j * lda;
    const double pivot = column[j];
    if (!(pivot > 0)) return j;
    const double root = __builtin_sqrt(pivot);
    const double inverse = 1 / root;
    column[j] = root;
    for (int i = j + 1; i < m; ++i) column[i] *= inverse;
    for (int l = j + 1; l < n; ++l) {
      double* const right = a + l * lda;
      const double factor = column[l];
      for (int i = l; i < m; ++i) right[i] -= column[i] * factor;
    }
  }
  return -1;
}

int factor_panel(double* a, int lda, int m, int n) {
  for (int j = 0; j < n; j += columns) {
    const int width = least(columns, n - j);
    double* const block = a + j + static_cast<std::ptrdiff_t>(j) * lda;
    if (j > 0) subtract_strip(block, lda, a + j, a + j, lda, m - j, width, j);
    const int bad = factor_few(block, lda, m - j, width);
    if (bad >= 0) return j + bad;
  }
  return -1;
}

}  // namespace

}  // namespace powbench::sim
