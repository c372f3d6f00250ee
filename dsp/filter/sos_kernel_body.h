#pragma once

#include <cstddef>

#include "dsp/filter/sos_kernel.h"

/// The loops of sos_kernel.h. Included by one source file for each instruction set; everything has internal
/// linkage, and no other header is included, so that no shared inline function is built for a processor that is
/// not there.

namespace powbench::dsp {

namespace {

using Vector = double __attribute__((vector_size(lanes * sizeof(double))));
/// The same in memory that is aligned for double only.
using Unaligned =
    double __attribute__((vector_size(lanes * sizeof(double)), aligned(sizeof(double)), may_alias));

constexpr std::size_t tile_frames = 64;
constexpr double silent = 1e-280;  ///< flushed to zero before it turns subnormal

inline void flush(Vector& s) {
  const Vector zero{};
  s = (s < silent) & (s > -silent) ? zero : s;
}
inline void flush(double& s) {
  if (s < silent && s > -silent) s = 0;
}

inline void load(Vector& v, const double* p) {
  v = *reinterpret_cast<const Unaligned*>(p);
}
inline void load(double& v, const double* p) {
  v = *p;
}
inline void store(const Vector& v, double* p) {
  *reinterpret_cast<Unaligned*>(p) = v;
}
inline void store(const double& v, double* p) {
  *p = v;
}

/// `count` steps of S sections. V is a vector of eight lanes, or one double. `before` is x[n - 1] for Difference.
template <class V, int S, bool Difference>
void sweep(const Coefficient* c, double* before, double* state, double* x, std::ptrdiff_t step,
           std::size_t count) {
  constexpr std::ptrdiff_t width = sizeof(V) / sizeof(double);
  V s1[S], s2[S], b0[S], m1[S], c1[S], c0[S], d0[S];
  for (int k = 0; k < S; ++k) {
    load(s1[k], state + (2 * k) * width);
    load(s2[k], state + (2 * k + 1) * width);
    b0[k] = V{} + c[k].b0, m1[k] = V{} + c[k].m1, c1[k] = V{} + c[k].c1;
    c0[k] = V{} + c[k].c0, d0[k] = V{} + c[k].d0;
  }
  V previous{};
  if constexpr (Difference) load(previous, before);
  const std::ptrdiff_t stride = step * width;
  for (std::size_t i = 0; i < count; ++i, x += stride) {
    V v;
    load(v, x);
    if constexpr (Difference) {
      const V now = v;
      v = now - previous;
      previous = now;
    }
    for (int k = 0; k < S; ++k) {
      const V y = b0[k] * v + s1[k];
      const V next = m1[k] * s1[k] + (c1[k] * v + s2[k]);
      s2[k] = (s2[k] + c0[k] * v) - d0[k] * s1[k];
      s1[k] = next;
      v = y;
    }
    store(v, x);
  }
  if constexpr (Difference) store(previous, before);
  for (int k = 0; k < S; ++k) {
    flush(s1[k]);
    flush(s2[k]);
    store(s1[k], state + (2 * k) * width);
    store(s2[k], state + (2 * k + 1) * width);
  }
}

template <class V, int S>
void sweep(bool difference, const Coefficient* c, double* before, double* state, double* x,
           std::ptrdiff_t step, std::size_t count) {
  if (difference)
    sweep<V, S, true>(c, before, state, x, step, count);
  else
    sweep<V, S, false>(c, before, state, x, step, count);
}

/// Any number of sections, up to four in one sweep, on a tile that stays in the first-level cache.
template <class V>
void run_tile(const SosLoop& loop, double* state, double* x, std::ptrdiff_t step, std::size_t count) {
  constexpr std::size_t width = sizeof(V) / sizeof(double);
  const Coefficient* c = loop.coefficients;
  double* s = state + width;
  std::size_t left = loop.sections;
  bool difference = loop.difference;
  while (left > 0) {
    const std::size_t now = left == 5 ? 3 : (left > 4 ? 4 : left);
    if (now == 4) sweep<V, 4>(difference, c, state, s, x, step, count);
    if (now == 3) sweep<V, 3>(difference, c, state, s, x, step, count);
    if (now == 2) sweep<V, 2>(difference, c, state, s, x, step, count);
    if (now == 1) sweep<V, 1>(difference, c, state, s, x, step, count);
    c += now;
    s += 2 * now * width;
    left -= now;
    difference = false;
  }
}

template <class V>
void run(const SosLoop& loop, double* state, double* x, std::ptrdiff_t step, std::size_t count) {
  constexpr auto width = static_cast<std::ptrdiff_t>(sizeof(V) / sizeof(double));
  constexpr std::size_t tile = width == 1 ? 4 * tile_frames : tile_frames;
  while (count > 0) {
    const std::size_t now = count < tile ? count : tile;
    run_tile<V>(loop, state, x, step, now);
    x += step * width * static_cast<std::ptrdiff_t>(now);
    count -= now;
  }
}

#ifdef __AVX512F__
using Index = long long __attribute__((vector_size(lanes * sizeof(long long))));

/// Transposes eight rows of eight.
inline void transpose(Vector* r) {
  constexpr Index low2{0, 8, 2, 10, 4, 12, 6, 14}, high2{1, 9, 3, 11, 5, 13, 7, 15};
  constexpr Index low4{0, 1, 8, 9, 4, 5, 12, 13}, high4{2, 3, 10, 11, 6, 7, 14, 15};
  constexpr Index low8{0, 1, 2, 3, 8, 9, 10, 11}, high8{4, 5, 6, 7, 12, 13, 14, 15};
  Vector a[8], b[8];
  for (int i = 0; i < 8; i += 2) {
    a[i] = __builtin_shuffle(r[i], r[i + 1], low2);
    a[i + 1] = __builtin_shuffle(r[i], r[i + 1], high2);
  }
  for (int i = 0; i < 8; i += 4)
    for (int j = 0; j < 2; ++j) {
      b[i + j] = __builtin_shuffle(a[i + j], a[i + j + 2], low4);
      b[i + j + 2] = __builtin_shuffle(a[i + j], a[i + j + 2], high4);
    }
  for (int j = 0; j < 4; ++j) {
    r[j] = __builtin_shuffle(b[j], b[j + 4], low8);
    r[j + 4] = __builtin_shuffle(b[j], b[j + 4], high8);
  }
}

/// Eight samples of each lane at p + w stride + step i  <->  eight frames. With step = -1 the samples lie
/// backward in memory, so the frames come out in backward order.
inline void gather(const double* p, std::ptrdiff_t stride, std::ptrdiff_t step, double* tile) {
  Vector r[8];
  const double* first = step > 0 ? p : p - 7;
  for (int w = 0; w < 8; ++w) load(r[w], first + w * stride);
  transpose(r);
  for (int i = 0; i < 8; ++i) store(r[i], tile + 8 * (step > 0 ? i : 7 - i));
}
inline void scatter(const double* tile, double* p, std::ptrdiff_t stride, std::ptrdiff_t step) {
  Vector r[8];
  for (int i = 0; i < 8; ++i) load(r[i], tile + 8 * (step > 0 ? i : 7 - i));
  transpose(r);
  double* first = step > 0 ? p : p - 7;
  for (int w = 0; w < 8; ++w) store(r[w], first + w * stride);
}
#else
inline void gather(const double* p, std::ptrdiff_t stride, std::ptrdiff_t step, double* tile) {
  for (int w = 0; w < 8; ++w)
    for (int i = 0; i < 8; ++i) tile[8 * i + w] = p[w * stride + step * i];
}
inline void scatter(const double* tile, double* p, std::ptrdiff_t stride, std::ptrdiff_t step) {
  for (int w = 0; w < 8; ++w)
    for (int i = 0; i < 8; ++i) p[w * stride + step * i] = tile[8 * i + w];
}
#endif

void run_frames(const SosLoop& loop, double* state, double* x, std::ptrdiff_t step, std::size_t frames) {
  run<Vector>(loop, state, x, step, frames);
}

void run_one(const SosLoop& loop, double* state, double* x, std::ptrdiff_t step, std::size_t samples) {
  run<double>(loop, state, x, step, samples);
}

void run_pieces(const SosLoop& loop, double* state, const double* in, double* out, std::ptrdiff_t stride,
                std::ptrdiff_t step, std::size_t samples) {
  alignas(64) double tile[tile_frames * lanes];
  for (std::size_t i = 0; i < samples;) {
    const std::size_t now = samples - i < tile_frames ? samples - i : tile_frames;
    const std::size_t whole = now / 8 * 8;
    const std::ptrdiff_t at = step * static_cast<std::ptrdiff_t>(i);
    for (std::size_t j = 0; j < whole; j += 8)
      gather(in + at + step * static_cast<std::ptrdiff_t>(j), stride, step, tile + j * lanes);
    for (std::size_t j = whole; j < now; ++j)
      for (std::size_t w = 0; w < lanes; ++w)
        tile[j * lanes + w] =
            in[at + step * static_cast<std::ptrdiff_t>(j) + static_cast<std::ptrdiff_t>(w) * stride];
    run_tile<Vector>(loop, state, tile, 1, now);
    i += now;
    if (!out) continue;
    for (std::size_t j = 0; j < whole; j += 8)
      scatter(tile + j * lanes, out + at + step * static_cast<std::ptrdiff_t>(j), stride, step);
    for (std::size_t j = whole; j < now; ++j)
      for (std::size_t w = 0; w < lanes; ++w)
        out[at + step * static_cast<std::ptrdiff_t>(j) + static_cast<std::ptrdiff_t>(w) * stride] =
            tile[j * lanes + w];
  }
}

}  // namespace

}  // namespace powbench::dsp
