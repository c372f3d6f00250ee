#include "dsp/pair_kernel.h"

namespace powbench::dsp {

namespace {

using V = double __attribute__((vector_size(64)));
using Unaligned = double __attribute__((vector_size(64), aligned(8), may_alias));

struct C {
  V re, im;
};

inline V load(const double* p) {
  return *reinterpret_cast<const Unaligned*>(p);
}
inline void store(double* p, V v) {
  *reinterpret_cast<Unaligned*>(p) = v;
}
inline C load(const double* re, const double* im) {
  return {load(re), load(im)};
}
inline C operator+(C a, C b) {
  return {a.re + b.re, a.im + b.im};
}
inline C operator-(C a, C b) {
  return {a.re - b.re, a.im - b.im};
}
inline C operator*(C a, C b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline C conjugate(C a) {
  return {a.re, -a.im};
}
/// By -i forward, by +i backward.
template <bool Forward>
inline C turn(C a) {
  if constexpr (Forward)
    return {a.im, -a.re};
  else
    return {-a.im, a.re};
}
/// By exp(-+ i pi / 4).
template <bool Forward>
inline C eighth(C a) {
  constexpr double r = 0.70710678118654752440;
  const C t = turn<Forward>(a);
  return {(a.re + t.re) * r, (a.im + t.im) * r};
}

/// Four-point transform in natural order.
template <bool Forward>
inline void dft4(C* x) {
  const C s = x[0] + x[2], d = x[0] - x[2], t = x[1] + x[3], u = turn<Forward>(x[1] - x[3]);
  x[0] = s + t, x[1] = d + u, x[2] = s - t, x[3] = d - u;
}

/// Eight-point transform in natural order.
template <bool Forward>
inline void dft8(C* x) {
  C even[4], odd[4];
  for (int k = 0; k < 4; ++k) even[k] = x[k] + x[k + 4], odd[k] = x[k] - x[k + 4];
  odd[1] = eighth<Forward>(odd[1]);
  odd[2] = turn<Forward>(odd[2]);
  odd[3] = turn<Forward>(eighth<Forward>(odd[3]));
  dft4<Forward>(even);
  dft4<Forward>(odd);
  for (int k = 0; k < 4; ++k) x[2 * k] = even[k], x[2 * k + 1] = odd[k];
}

template <int R, bool Forward>
inline void dft(C* x) {
  if constexpr (R == 8)
    dft8<Forward>(x);
  else
    dft4<Forward>(x);
}

/// One level down: columns of R values `stride` apart, transformed, then twiddled.
template <int R>
void down(std::size_t stride, const double* w, const double* a, const double* b, double* re, double* im) {
  for (std::size_t j = 0; j < stride; j += pair_lanes, w += 16 * (R - 1)) {
    C x[R];
    for (int r = 0; r < R; ++r) {
      const std::size_t at = static_cast<std::size_t>(r) * stride + j;
      x[r] = load(a + at, b + at);
    }
    dft<R, true>(x);
    store(re + j, x[0].re);
    store(im + j, x[0].im);
    for (int q = 1; q < R; ++q) {
      const std::size_t at = static_cast<std::size_t>(q) * stride + j;
      const C y = x[q] * load(w + 16 * (q - 1), w + 16 * (q - 1) + 8);
      store(re + at, y.re);
      store(im + at, y.im);
    }
  }
}

/// One level up: twiddled back, then transformed; row r goes to row_a[r], row_b[r].
template <int R>
void up(std::size_t stride, const double* w, const double* re, const double* im, double* const* row_a,
        double* const* row_b) {
  for (std::size_t j = 0; j < stride; j += pair_lanes, w += 16 * (R - 1)) {
    C x[R];
    x[0] = load(re + j, im + j);
    for (int q = 1; q < R; ++q) {
      const std::size_t at = static_cast<std::size_t>(q) * stride + j;
      x[q] = load(re + at, im + at) * conjugate(load(w + 16 * (q - 1), w + 16 * (q - 1) + 8));
    }
    dft<R, false>(x);
    for (int r = 0; r < R; ++r) {
      store(row_a[r] + j, x[r].re);
      store(row_b[r] + j, x[r].im);
    }
  }
}

#define POWBENCH_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

/// Rows become columns.
inline void transpose(V* v) {
  V t[8], u[8];
  for (int k = 0; k < 8; k += 2) {
    t[k] = POWBENCH_SHUFFLE(v[k], v[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    t[k + 1] = POWBENCH_SHUFFLE(v[k], v[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int h = 0; h < 8; h += 4)
    for (int k = 0; k < 2; ++k) {
      u[h + k] = POWBENCH_SHUFFLE(t[h + k], t[h + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      u[h + k + 2] = POWBENCH_SHUFFLE(t[h + k], t[h + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int k = 0; k < 4; ++k) {
    v[k] = POWBENCH_SHUFFLE(u[k], u[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    v[k + 4] = POWBENCH_SHUFFLE(u[k], u[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

inline void transpose(C* x) {
  V part[8];
  for (int k = 0; k < 8; ++k) part[k] = x[k].re;
  transpose(part);
  for (int k = 0; k < 8; ++k) x[k].re = part[k], part[k] = x[k].im;
  transpose(part);
  for (int k = 0; k < 8; ++k) x[k].im = part[k];
}

/// The last six levels of 64 points.
inline void leaf_down(C* x, const double* w, const double* re, const double* im) {
  for (int r = 0; r < 8; ++r) x[r] = load(re + 8 * r, im + 8 * r);
  dft8<true>(x);
  for (int q = 1; q < 8; ++q) x[q] = x[q] * load(w + 16 * (q - 1), w + 16 * (q - 1) + 8);
  transpose(x);
  dft8<true>(x);
}

void leaf(const double* w, const double* h, double* re, double* im) {
  C x[8];
  leaf_down(x, w, re, im);
  for (int k = 0; k < 8; ++k) x[k] = x[k] * load(h + 16 * k, h + 16 * k + 8);
  dft8<false>(x);
  transpose(x);
  for (int q = 1; q < 8; ++q) x[q] = x[q] * conjugate(load(w + 16 * (q - 1), w + 16 * (q - 1) + 8));
  dft8<false>(x);
  for (int r = 0; r < 8; ++r) {
    store(re + 8 * r, x[r].re);
    store(im + 8 * r, x[r].im);
  }
}

void level_down(const PairLevel& level, const double* a, const double* b, double* re, double* im) {
  const std::size_t stride = level.length / static_cast<std::size_t>(level.radix);
  if (level.radix == 8)
    down<8>(stride, level.twiddle, a, b, re, im);
  else
    down<4>(stride, level.twiddle, a, b, re, im);
}

void level_up(const PairLevel& level, const double* re, const double* im, double* const* row_a,
              double* const* row_b) {
  const std::size_t stride = level.length / static_cast<std::size_t>(level.radix);
  if (level.radix == 8)
    up<8>(stride, level.twiddle, re, im, row_a, row_b);
  else
    up<4>(stride, level.twiddle, re, im, row_a, row_b);
}

/// All levels from `k` on for the piece at `offset`, forward, product and back: what is small stays in the nearest cache.
void piece(const PairPlan& p, std::size_t k, std::size_t offset) {
  double *re = p.re + offset, *im = p.im + offset;
  if (k == p.levels) {
    leaf(p.leaf_twiddle, p.response + 2 * offset, re, im);
    return;
  }
  const PairLevel& level = p.level[k];
  const std::size_t stride = level.length / static_cast<std::size_t>(level.radix);
  level_down(level, re, im, re, im);
  double *row_a[8], *row_b[8];
  for (int r = 0; r < level.radix; ++r) {
    const std::size_t at = static_cast<std::size_t>(r) * stride;
    piece(p, k + 1, offset + at);
    row_a[r] = re + at;
    row_b[r] = im + at;
  }
  level_up(level, re, im, row_a, row_b);
}

void forward_piece(const PairPlan& p, std::size_t k, std::size_t offset, double* response) {
  double *re = p.re + offset, *im = p.im + offset;
  if (k == p.levels) {
    C x[8];
    leaf_down(x, p.leaf_twiddle, re, im);
    for (int q = 0; q < 8; ++q) {
      store(response + 2 * offset + 16 * static_cast<std::size_t>(q), x[q].re);
      store(response + 2 * offset + 16 * static_cast<std::size_t>(q) + 8, x[q].im);
    }
    return;
  }
  const PairLevel& level = p.level[k];
  level_down(level, re, im, re, im);
  for (int r = 0; r < level.radix; ++r)
    forward_piece(
        p, k + 1,
        offset + static_cast<std::size_t>(r) * (level.length / static_cast<std::size_t>(level.radix)),
        response);
}

}  // namespace

void pair_convolve(const PairPlan& p, const double* a, const double* b, double* const* row_a,
                   double* const* row_b) {
  const PairLevel& top = p.level[0];
  level_down(top, a, b, p.re, p.im);
  for (int r = 0; r < top.radix; ++r)
    piece(p, 1, static_cast<std::size_t>(r) * (top.length / static_cast<std::size_t>(top.radix)));
  level_up(top, p.re, p.im, row_a, row_b);
}

void pair_forward(const PairPlan& p, const double* a, const double* b, double* response) {
  const PairLevel& top = p.level[0];
  level_down(top, a, b, p.re, p.im);
  for (int r = 0; r < top.radix; ++r)
    forward_piece(p, 1, static_cast<std::size_t>(r) * (top.length / static_cast<std::size_t>(top.radix)),
                  response);
}

}  // namespace powbench::dsp
