#pragma once

#include <type_traits>

#include "sim/magnetics/plane/four_kernel.h"

/// The loops of four_kernel.h. Included by one source file for each instruction set; internal linkage throughout.

namespace powbench::sim {

namespace {

using Vector = double __attribute__((vector_size(32), may_alias));

inline const Vector* vectors_of(const Four* p) {
  return reinterpret_cast<const Vector*>(p);
}
inline Vector* vectors_of(Four* p) {
  return reinterpret_cast<Vector*>(p);
}

constexpr int tile_rows = 3, strip_columns = 3;  // nine sums, and what they are made of, fit the registers

inline int least(int a, int b) {
  return a < b ? a : b;
}

/// Sums over p of A(i, p) B(j, p) for R rows and C columns.
template <int R, int C>
inline void product_tile(Vector (&sum)[C][R], const Vector* a, const Vector* b, std::ptrdiff_t ld, int k) {
  for (int j = 0; j < C; ++j)
    for (int r = 0; r < R; ++r) sum[j][r] = Vector{};
  for (int p = 0; p < k; ++p, a += ld, b += ld) {
    Vector x[R];
    for (int r = 0; r < R; ++r) x[r] = a[r];
    for (int j = 0; j < C; ++j) {
      const Vector y = b[j];
      for (int r = 0; r < R; ++r) sum[j][r] += x[r] * y;
    }
  }
}

/// One tile of a panel: c(i, j) -= ..., columns `ld` apart.
template <int R, int C>
inline void panel_tile(Vector* c, const Vector* a, const Vector* b, std::ptrdiff_t ld, int k) {
  Vector sum[C][R];
  product_tile<R, C>(sum, a, b, ld, k);
  for (int j = 0; j < C; ++j)
    for (int r = 0; r < R; ++r) c[r + j * ld] -= sum[j][r];
}

/// C columns of the panel: `rows` rows from their own diagonal on, less what the k columns before contribute.
template <int C>
inline void panel_strip(Vector* c, const Vector* a, std::ptrdiff_t ld, int rows, int k) {
  int i = 0;
  for (; i + tile_rows <= rows; i += tile_rows) panel_tile<tile_rows, C>(c + i, a + i, a, ld, k);
  for (; i < rows; ++i) panel_tile<1, C>(c + i, a + i, a, ld, k);
}

/// The triangle of C columns and the rows below it.
template <int C>
inline int factor_strip(Vector* a, std::ptrdiff_t ld, int rows) {
  Vector l[C][C], inverse[C];
  for (int j = 0; j < C; ++j) {
    for (int i = j; i < C; ++i) {
      Vector x = a[i + j * ld];
      for (int p = 0; p < j; ++p) x -= l[i][p] * l[j][p];
      l[i][j] = x;
    }
    Vector pivot = l[j][j];
    for (int k = 0; k < 4; ++k) {
      if (!(pivot[k] > 0)) return j;
      pivot[k] = __builtin_sqrt(pivot[k]);
    }
    a[j + j * ld] = inverse[j] = 1 / pivot;
    for (int i = j + 1; i < C; ++i) a[i + j * ld] = l[i][j] *= inverse[j];
  }
  for (int i = C; i < rows; ++i) {
    Vector x[C];
    for (int j = 0; j < C; ++j) {
      Vector rest = a[i + j * ld];
      for (int p = 0; p < j; ++p) rest -= x[p] * l[j][p];
      a[i + j * ld] = x[j] = rest * inverse[j];
    }
  }
  return -1;
}

template <int C>
inline int next_strip(Vector* a, std::ptrdiff_t ld, int m, int j) {
  Vector* const block = a + j + j * ld;
  if (j > 0) panel_strip<C>(block, a + j, ld, m - j, j);
  return factor_strip<C>(block, ld, m - j);
}

int factor_panel(Four* four, int m, int n) {
  Vector* const a = vectors_of(four);
  for (int j = 0; j < n; j += 3) {
    const int width = least(3, n - j);
    const int bad = width == 3   ? next_strip<3>(a, m, m, j)
                    : width == 2 ? next_strip<2>(a, m, m, j)
                                 : next_strip<1>(a, m, m, j);
    if (bad >= 0) return j + bad;
  }
  return -1;
}

/// C columns of the square, from their diagonal on. `c[j]` is where row 0 of the strip would be in column j.
template <int C>
inline void square_strip(Vector* const* c, const Vector* a, std::ptrdiff_t lda, int rows, int k) {
  Vector corner[C][C];
  product_tile<C, C>(corner, a, a, lda, k);
  for (int j = 0; j < C; ++j)
    for (int i = j; i < C; ++i) c[j][i] = -corner[j][i];
  int i = C;
  for (; i + tile_rows <= rows; i += tile_rows) {
    Vector sum[C][tile_rows];
    product_tile<tile_rows, C>(sum, a + i, a, lda, k);
    for (int j = 0; j < C; ++j)
      for (int r = 0; r < tile_rows; ++r) c[j][i + r] = -sum[j][r];
  }
  for (; i < rows; ++i) {
    Vector sum[C][1];
    product_tile<1, C>(sum, a + i, a, lda, k);
    for (int j = 0; j < C; ++j) c[j][i] = -sum[j][0];
  }
}

void square(Four* four, const Four* panel, int lda, int m, int k) {
  Vector* const to = vectors_of(four);
  const Vector* const a = vectors_of(panel);
  const auto rows = static_cast<std::size_t>(m);
  for (int j = 0; j < m; j += 3) {
    const int width = least(3, m - j);
    Vector* c[3];
    for (int w = 0; w < width; ++w) c[w] = to + packed_column(rows, static_cast<std::size_t>(j + w)) - w;
    if (width == 3)
      square_strip<3>(c, a + j, lda, m - j, k);
    else if (width == 2)
      square_strip<2>(c, a + j, lda, m - j, k);
    else
      square_strip<1>(c, a + j, lda, m - j, k);
  }
}

void add(Four* to, const int* place, const Four* from, int count) {
  Vector* const target = vectors_of(to);
  const Vector* const source = vectors_of(from);
  for (int i = 0; i < count; ++i) target[place[i]] += source[i];
}

/// W columns of a panel, for V vectors.
template <int V, int W>
inline void forward_group(const Vector* a, std::ptrdiff_t ld, int inside, int m, Vector* const* own,
                          Vector* const* all, const int* below) {
  Vector x[V][W];
  for (int v = 0; v < V; ++v)
    for (int c = 0; c < W; ++c) {
      Vector rest = own[v][c];
      for (int d = 0; d < c; ++d) rest -= a[c + d * ld] * x[v][d];
      own[v][c] = x[v][c] = rest * a[c + c * ld];
    }
  for (int i = W; i < inside; ++i)
    for (int v = 0; v < V; ++v) {
      Vector y = own[v][i];
      for (int c = 0; c < W; ++c) y -= a[i + c * ld] * x[v][c];
      own[v][i] = y;
    }
  for (int i = inside; i < m; ++i) {
    const int row = below[i - inside];
    Vector y[V];
    for (int v = 0; v < V; ++v) y[v] = all[v][row];
    for (int c = 0; c < W; ++c) {
      const Vector l = a[i + c * ld];
      for (int v = 0; v < V; ++v) y[v] -= l * x[v][c];
    }
    for (int v = 0; v < V; ++v) all[v][row] = y[v];
  }
}

template <int V, int W>
inline void backward_group(const Vector* a, std::ptrdiff_t ld, int inside, int m, Vector* const* own,
                           Vector* const* all, const int* below) {
  Vector sum[V][W] = {};
  for (int i = W; i < inside; ++i)
    for (int v = 0; v < V; ++v)
      for (int c = 0; c < W; ++c) sum[v][c] += a[i + c * ld] * own[v][i];
  for (int i = inside; i < m; ++i) {
    const int row = below[i - inside];
    for (int c = 0; c < W; ++c) {
      const Vector l = a[i + c * ld];
      for (int v = 0; v < V; ++v) sum[v][c] += l * all[v][row];
    }
  }
  for (int v = 0; v < V; ++v)
    for (int c = W - 1; c >= 0; --c) {
      Vector rest = own[v][c] - sum[v][c];
      for (int d = c + 1; d < W; ++d) rest -= a[d + c * ld] * own[v][d];
      own[v][c] = rest * a[c + c * ld];
    }
}

/// The group of up to four columns of a panel from j on; `group(width, a, own)` with the width as a type.
template <int V, class Group>
inline void in_group(const Four* panel, int m, int n, int j, Vector* const* all, int first,
                     const Group& group) {
  const Vector* const a = vectors_of(panel) + j + static_cast<std::ptrdiff_t>(j) * m;
  Vector* own[V];
  for (int v = 0; v < V; ++v) own[v] = all[v] + first + j;
  switch (least(4, n - j)) {
    case 4:
      return group(std::integral_constant<int, 4>{}, a, own);
    case 3:
      return group(std::integral_constant<int, 3>{}, a, own);
    case 2:
      return group(std::integral_constant<int, 2>{}, a, own);
    default:
      return group(std::integral_constant<int, 1>{}, a, own);
  }
}

template <int V>
void forward_by(const Four* panel, int m, int n, Four* const* x, int first, const int* below) {
  Vector* all[V];
  for (int v = 0; v < V; ++v) all[v] = vectors_of(x[v]);
  for (int j = 0; j < n; j += 4)
    in_group<V>(panel, m, n, j, all, first, [&](auto width, const Vector* a, Vector* const* own) {
      forward_group<V, width()>(a, m, n - j, m - j, own, all, below);
    });
}

template <int V>
void backward_by(const Four* panel, int m, int n, Four* const* x, int first, const int* below) {
  Vector* all[V];
  for (int v = 0; v < V; ++v) all[v] = vectors_of(x[v]);
  for (int j = (n - 1) / 4 * 4; j >= 0; j -= 4)
    in_group<V>(panel, m, n, j, all, first, [&](auto width, const Vector* a, Vector* const* own) {
      backward_group<V, width()>(a, m, n - j, m - j, own, all, below);
    });
}

template <int nodes>
Vector add_steel_by(const FourSteel& s, const Four* solution, Four* slope, Four* matrix) {
  constexpr int entries = nodes * (nodes + 1) / 2;
  const Vector* const a = vectors_of(solution);
  Vector* const gradient = vectors_of(slope);
  Vector energy{};
  const Vector* curls = vectors_of(s.curls);
  const Vector* weights = vectors_of(s.weights);
  for (std::size_t e = 0; e < s.elements; ++e) {
    const int* const u = s.unknowns + e * nodes;
    Vector local[nodes], force[nodes] = {}, hessian[entries] = {};
    for (int n = 0; n < nodes; ++n) local[n] = a[u[n]];
    for (int q = 0; q < s.points; ++q, curls += 2 * nodes, ++weights) {
      const Vector* const cx = curls;
      const Vector* const cy = curls + nodes;
      Vector bx{}, by{};
      for (int n = 0; n < nodes; ++n) {
        bx += cx[n] * local[n];
        by += cy[n] * local[n];
      }
      const Vector square = bx * bx + by * by;
      Four b;
      for (int k = 0; k < 4; ++k) b.of[k] = __builtin_sqrt(square[k]);
      const FourSteelPoint p = steel_points(*s.steels[e], b);
      const Vector h = *vectors_of(&p.h), dh_db = *vectors_of(&p.dh_db), length = *vectors_of(&b);
      const Vector weight = *weights;
      energy += weight * *vectors_of(&p.energy);
      const Vector nu = weight * (length > 0 ? h / length : dh_db);
      const Vector extra = square > 0 ? (weight * dh_db - nu) / square : Vector{};
      Vector along[nodes];
      for (int n = 0; n < nodes; ++n) {
        along[n] = bx * cx[n] + by * cy[n];
        force[n] += nu * along[n];
      }
      if (!matrix) continue;
      for (int i = 0, at = 0; i < nodes; ++i) {
        const Vector x = nu * cx[i], y = nu * cy[i], z = extra * along[i];
        for (int j = 0; j <= i; ++j, ++at) hessian[at] += x * cx[j] + y * cy[j] + z * along[j];
      }
    }
    for (int n = 0; n < nodes; ++n) gradient[u[n]] += force[n];
    if (!matrix) continue;
    const int* const to = s.positions + e * entries;
    for (int at = 0; at < entries; ++at) vectors_of(matrix)[to[at]] += hessian[at];
  }
  return energy;
}

void add_steel(const FourSteel& s, const Four* a, Four* energy, Four* gradient, Four* values) {
  *vectors_of(energy) =
      s.nodes == 3 ? add_steel_by<3>(s, a, gradient, values) : add_steel_by<6>(s, a, gradient, values);
}

void multiply(int size, const int* start, const int* row, const Four* values, const Four* in, Four* out) {
  const Vector* const x = vectors_of(in);
  const Vector* const a = vectors_of(values);
  Vector* const y = vectors_of(out);
  for (int j = 0; j < size; ++j) y[j] = Vector{};
  for (int j = 0; j < size; ++j) {
    const Vector right = x[j];
    Vector sum = a[start[j]] * right;
    for (int at = start[j] + 1; at < start[j + 1]; ++at) {
      sum += a[at] * x[row[at]];
      y[row[at]] += a[at] * right;
    }
    y[j] += sum;
  }
}

void forward(const Four* a, int m, int n, Four* const* x, int first, const int* below, int vectors) {
  vectors == 3   ? forward_by<3>(a, m, n, x, first, below)
  : vectors == 2 ? forward_by<2>(a, m, n, x, first, below)
                 : forward_by<1>(a, m, n, x, first, below);
}

void backward(const Four* a, int m, int n, Four* const* x, int first, const int* below, int vectors) {
  vectors == 3   ? backward_by<3>(a, m, n, x, first, below)
  : vectors == 2 ? backward_by<2>(a, m, n, x, first, below)
                 : backward_by<1>(a, m, n, x, first, below);
}

}  // namespace

}  // namespace powbench::sim
