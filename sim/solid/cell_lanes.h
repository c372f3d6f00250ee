#pragma once

#include "sim/solid/cell_kernel.h"

/// Vectors of 8 doubles or 16 floats, and the transposition between nodes (x y z -) and lanes (one cell each). For the
/// kernel sources only: everything has internal linkage and is inlined.

namespace powbench::sim {
namespace {

#define POWBENCH_INLINE inline __attribute__((always_inline))

typedef double D2 __attribute__((vector_size(16)));
typedef double D4 __attribute__((vector_size(32)));
typedef double D8 __attribute__((vector_size(64)));
typedef float S4 __attribute__((vector_size(16)));
typedef float S8 __attribute__((vector_size(32)));
typedef float S16 __attribute__((vector_size(64)));
typedef double D4u __attribute__((vector_size(32), aligned(8), may_alias));
typedef double D8u __attribute__((vector_size(64), aligned(8), may_alias));
typedef float S4u __attribute__((vector_size(16), aligned(4), may_alias));
typedef float S16u __attribute__((vector_size(64), aligned(4), may_alias));

template <class Real>
struct Lanes;

template <>
struct Lanes<double> {
  using V = D8;
  using Vu = D8u;
  static constexpr int width = 8;
};

template <>
struct Lanes<float> {
  using V = S16;
  using Vu = S16u;
  static constexpr int width = 16;
};

POWBENCH_INLINE D8 pair(const double* p, int low, int high) {
  const D4 a = *reinterpret_cast<const D4u*>(p + low), b = *reinterpret_cast<const D4u*>(p + high);
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// x, y, z of 8 nodes.
POWBENCH_INLINE void gather(const double* p, const int* c, D8& x, D8& y, D8& z) {
  const D8 a = pair(p, c[0], c[4]), b = pair(p, c[1], c[5]), d = pair(p, c[2], c[6]), e = pair(p, c[3], c[7]);
  const D8 ab0 = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  const D8 ab1 = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  const D8 de0 = __builtin_shufflevector(d, e, 0, 8, 2, 10, 4, 12, 6, 14);
  const D8 de1 = __builtin_shufflevector(d, e, 1, 9, 3, 11, 5, 13, 7, 15);
  x = __builtin_shufflevector(ab0, de0, 0, 1, 8, 9, 4, 5, 12, 13);
  y = __builtin_shufflevector(ab1, de1, 0, 1, 8, 9, 4, 5, 12, 13);
  z = __builtin_shufflevector(ab0, de0, 2, 3, 10, 11, 6, 7, 14, 15);
}

POWBENCH_INLINE void add_to(double* p, const D4& value) {
  *reinterpret_cast<D4u*>(p) += value;
}

/// Adds x, y, z to 8 nodes, lane after lane: two lanes may name one node.
POWBENCH_INLINE void scatter(double* p, const int* c, const D8& x, const D8& y, const D8& z) {
  const D8 none{};
  const D8 xy0 = __builtin_shufflevector(x, y, 0, 8, 2, 10, 4, 12, 6, 14);
  const D8 xy1 = __builtin_shufflevector(x, y, 1, 9, 3, 11, 5, 13, 7, 15);
  const D8 z0 = __builtin_shufflevector(z, none, 0, 8, 2, 10, 4, 12, 6, 14);
  const D8 z1 = __builtin_shufflevector(z, none, 1, 9, 3, 11, 5, 13, 7, 15);
  const D8 n04 = __builtin_shufflevector(xy0, z0, 0, 1, 8, 9, 4, 5, 12, 13);
  const D8 n26 = __builtin_shufflevector(xy0, z0, 2, 3, 10, 11, 6, 7, 14, 15);
  const D8 n15 = __builtin_shufflevector(xy1, z1, 0, 1, 8, 9, 4, 5, 12, 13);
  const D8 n37 = __builtin_shufflevector(xy1, z1, 2, 3, 10, 11, 6, 7, 14, 15);
  add_to(p + c[0], __builtin_shufflevector(n04, n04, 0, 1, 2, 3));
  add_to(p + c[1], __builtin_shufflevector(n15, n15, 0, 1, 2, 3));
  add_to(p + c[2], __builtin_shufflevector(n26, n26, 0, 1, 2, 3));
  add_to(p + c[3], __builtin_shufflevector(n37, n37, 0, 1, 2, 3));
  add_to(p + c[4], __builtin_shufflevector(n04, n04, 4, 5, 6, 7));
  add_to(p + c[5], __builtin_shufflevector(n15, n15, 4, 5, 6, 7));
  add_to(p + c[6], __builtin_shufflevector(n26, n26, 4, 5, 6, 7));
  add_to(p + c[7], __builtin_shufflevector(n37, n37, 4, 5, 6, 7));
}

POWBENCH_INLINE S16 quad(const float* p, int a, int b, int c, int d) {
  const S4 n0 = *reinterpret_cast<const S4u*>(p + a), n1 = *reinterpret_cast<const S4u*>(p + b);
  const S4 n2 = *reinterpret_cast<const S4u*>(p + c), n3 = *reinterpret_cast<const S4u*>(p + d);
  const S8 low = __builtin_shufflevector(n0, n1, 0, 1, 2, 3, 4, 5, 6, 7);
  const S8 high = __builtin_shufflevector(n2, n3, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

// Within each group of four numbers: unpack low, unpack high, low halves, high halves.
#define POWBENCH_LOW(a, b) \
  __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define POWBENCH_HIGH(a, b) \
  __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#define POWBENCH_FIRST(a, b) \
  __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29)
#define POWBENCH_SECOND(a, b) \
  __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)

POWBENCH_INLINE void gather(const float* p, const int* c, S16& x, S16& y, S16& z) {
  const S16 a = quad(p, c[0], c[4], c[8], c[12]), b = quad(p, c[1], c[5], c[9], c[13]);
  const S16 d = quad(p, c[2], c[6], c[10], c[14]), e = quad(p, c[3], c[7], c[11], c[15]);
  const S16 ab0 = POWBENCH_LOW(a, b), ab1 = POWBENCH_HIGH(a, b);
  const S16 de0 = POWBENCH_LOW(d, e), de1 = POWBENCH_HIGH(d, e);
  x = POWBENCH_FIRST(ab0, de0);
  y = POWBENCH_SECOND(ab0, de0);
  z = POWBENCH_FIRST(ab1, de1);
}

POWBENCH_INLINE void add_four(float* p, const int* c, const S16& n) {
  *reinterpret_cast<S4u*>(p + c[0]) += __builtin_shufflevector(n, n, 0, 1, 2, 3);
  *reinterpret_cast<S4u*>(p + c[4]) += __builtin_shufflevector(n, n, 4, 5, 6, 7);
  *reinterpret_cast<S4u*>(p + c[8]) += __builtin_shufflevector(n, n, 8, 9, 10, 11);
  *reinterpret_cast<S4u*>(p + c[12]) += __builtin_shufflevector(n, n, 12, 13, 14, 15);
}

POWBENCH_INLINE void scatter(float* p, const int* c, const S16& x, const S16& y, const S16& z) {
  const S16 none{};
  const S16 xy0 = POWBENCH_LOW(x, y), xy1 = POWBENCH_HIGH(x, y);
  const S16 z0 = POWBENCH_LOW(z, none), z1 = POWBENCH_HIGH(z, none);
  add_four(p, c, POWBENCH_FIRST(xy0, z0));
  add_four(p, c + 1, POWBENCH_SECOND(xy0, z0));
  add_four(p, c + 2, POWBENCH_FIRST(xy1, z1));
  add_four(p, c + 3, POWBENCH_SECOND(xy1, z1));
}

/// W_1 .. W_7 ([0] .. [6]) of one component at the corners of hexahedra: sums and differences, no product.
template <class V>
POWBENCH_INLINE void to_modes(const V (&n)[8], V (&w)[7]) {
  const V s0 = n[4] + n[0], s1 = n[5] + n[1], s2 = n[6] + n[2], s3 = n[7] + n[3];
  const V d0 = n[4] - n[0], d1 = n[5] - n[1], d2 = n[6] - n[2], d3 = n[7] - n[3];
  const V a = s1 - s0, b = s2 - s3;
  w[0] = a + b;
  w[5] = b - a;
  w[1] = (s2 + s3) - (s1 + s0);
  const V p = d1 - d0, q = d2 - d3, r = d1 + d0, t = d2 + d3;
  w[2] = r + t;
  w[3] = t - r;
  w[4] = p + q;
  w[6] = q - p;
}

/// Nodal values of the sum of g_m L_m: the transpose of to_modes.
template <class V>
POWBENCH_INLINE void from_modes(const V (&g)[7], V (&n)[8]) {
  const V sum = g[0] + g[1], rest = g[0] - g[1];
  const V s0 = g[5] - sum, s1 = rest - g[5], s2 = g[5] + sum, s3 = -rest - g[5];
  const V e = g[2] + g[6], h = g[2] - g[6], q = g[3] + g[4], r = g[4] - g[3];
  const V d0 = e - q, d1 = h + r, d2 = e + q, d3 = h - r;
  n[4] = s0 + d0;
  n[0] = s0 - d0;
  n[5] = s1 + d1;
  n[1] = s1 - d1;
  n[6] = s2 + d2;
  n[2] = s2 - d2;
  n[7] = s3 + d3;
  n[3] = s3 - d3;
}

}  // namespace
}  // namespace powbench::sim
