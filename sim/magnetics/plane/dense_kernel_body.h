#pragma once

#include <cstddef>

#include "sim/magnetics/plane/dense_kernel.h"

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

constexpr int group = 4;  // columns of a panel that a solve takes at a time

template <int R, int W>
inline void forward_group(const double* a, std::ptrdiff_t lda, int m, double* x, std::ptrdiff_t ldx) {
  double value[R][W];
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < W; ++c) {
      double rest = x[c + r * ldx];
      for (int d = 0; d < c; ++d) rest -= a[c + d * lda] * value[r][d];
      x[c + r * ldx] = value[r][c] = rest / a[c + c * lda];
    }
  for (int i = W; i < m; i += lanes) {
    Vector y[R];
    for (int r = 0; r < R; ++r) y[r] = load(x + i + r * ldx);
    for (int c = 0; c < W; ++c) {
      const Vector l = load(a + i + c * lda);
      for (int r = 0; r < R; ++r) y[r] -= l * value[r][c];
    }
    for (int r = 0; r < R; ++r) *reinterpret_cast<Unaligned*>(x + i + r * ldx) = y[r];
  }
}

template <int R, int W>
inline void backward_group(const double* a, std::ptrdiff_t lda, int m, double* x, std::ptrdiff_t ldx) {
  Vector sum[R][W];
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < W; ++c) sum[r][c] = Vector{};
  for (int i = W; i < m; i += lanes)
    for (int c = 0; c < W; ++c) {
      const Vector l = load(a + i + c * lda);
      for (int r = 0; r < R; ++r) sum[r][c] += l * load(x + i + r * ldx);
    }
  for (int r = 0; r < R; ++r)
    for (int c = W - 1; c >= 0; --c) {
      double rest = x[c + r * ldx];
      for (int k = 0; k < lanes; ++k) rest -= sum[r][c][k];
      for (int d = c + 1; d < W; ++d) rest -= a[d + c * lda] * x[d + r * ldx];
      x[c + r * ldx] = rest / a[c + c * lda];
    }
}

template <int R>
void forward_by(const double* a, std::ptrdiff_t lda, int m, int n, double* x, std::ptrdiff_t ldx) {
  for (int j = 0; j < n; j += group) {
    const double* const block = a + j + j * lda;
    if (n - j >= group)
      forward_group<R, group>(block, lda, m - j, x + j, ldx);
    else if (n - j == 3)
      forward_group<R, 3>(block, lda, m - j, x + j, ldx);
    else if (n - j == 2)
      forward_group<R, 2>(block, lda, m - j, x + j, ldx);
    else
      forward_group<R, 1>(block, lda, m - j, x + j, ldx);
  }
}

template <int R>
void backward_by(const double* a, std::ptrdiff_t lda, int m, int n, double* x, std::ptrdiff_t ldx) {
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < dense_slack; ++k) x[m + k + r * ldx] = 0;
  int j = n / group * group;
  const double* const block = a + j + j * lda;
  if (n - j == 3) backward_group<R, 3>(block, lda, m - j, x + j, ldx);
  if (n - j == 2) backward_group<R, 2>(block, lda, m - j, x + j, ldx);
  if (n - j == 1) backward_group<R, 1>(block, lda, m - j, x + j, ldx);
  for (j -= group; j >= 0; j -= group) backward_group<R, group>(a + j + j * lda, lda, m - j, x + j, ldx);
}

void forward(const double* a, int lda, int m, int n, double* x, int ldx, int vectors) {
  vectors == 2 ? forward_by<2>(a, lda, m, n, x, ldx) : forward_by<1>(a, lda, m, n, x, ldx);
}

void backward(const double* a, int lda, int m, int n, double* x, int ldx, int vectors) {
  vectors == 2 ? backward_by<2>(a, lda, m, n, x, ldx) : backward_by<1>(a, lda, m, n, x, ldx);
}

}  // namespace

}  // namespace powbench::sim
