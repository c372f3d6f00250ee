#pragma once

#include <cstddef>

/// The inner loops of pair_convolver.h. Only plain pointers cross this border; built with 512-bit instructions, so nothing inline
/// is shared with code for other processors.

namespace powbench::dsp {

inline constexpr std::size_t pair_lanes = 8;
inline constexpr std::size_t pair_leaf = 64;  ///< points whose last levels stay in registers

/// One level of the transform: `radix` (4 or 8) interleaved parts of a piece of `length` points.
/// Twiddles for each 8 columns j: q = 1 .. radix - 1, then 8 cosines and 8 negative sines of 2 pi j q / length.
struct PairLevel {
  std::size_t length;
  int radix;
  const double* twiddle;
};

struct PairPlan {
  const PairLevel* level;  ///< from the whole block down to pieces of 2 * leaf or more
  std::size_t levels;
  const double* leaf_twiddle;  ///< q = 1 .. 7: 8 cosines, 8 negative sines of 2 pi j q / 64
  const double* response;  ///< for each leaf 8 rows of 8 real and 8 imaginary parts, as the leaf holds them
  double* re;              ///< (length) work, 64-byte aligned
  double* im;
};

/// Two blocks through forward transform, product and inverse; row r of the last level is stored at `row_a[r]`, `row_b[r]`
/// (length / radix values each; 8 or 4 rows).
void pair_convolve(const PairPlan&, const double* a, const double* b, double* const* row_a,
                   double* const* row_b);

/// The forward transform alone, into plan.re and plan.im, leaves in the order in which `response` is kept.
void pair_forward(const PairPlan&, const double* a, const double* b, double* response);

}  // namespace powbench::dsp
