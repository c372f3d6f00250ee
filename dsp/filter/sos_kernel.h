#pragma once

#include <cstddef>

/// The inner loops of a cascade of second-order sections, compiled once for each instruction set and chosen at
/// run time. Only plain pointers cross this border.
///
/// One step of a section, s1 and s2 its state:
///   y = b0 x + s1,  s1' = m1 s1 + (c1 x + s2),  s2' = (s2 + c0 x) - d0 s1
/// with m1 = 1 - d1, c1 = n1 - d1 b0, c0 = n0 - d0 b0 (see Section). The loop from sample to sample goes through
/// one multiply-add, not through y.
///
/// With `difference` the first section sees x[n] - x[n - 1]: a zero at z = 1 taken before anything is rounded, so
/// that a large constant never enters the resonators. The state is one row for x[n - 1], then s1, s2 of every
/// section: (1 + 2 sections) rows of one value a lane.
///
/// Rounding: where the processor has fused multiply-add (the avx2 and avx512 versions, which give the same bits)
/// each of the five lines' products is fused with the addition that follows; the portable version rounds both.
/// The two differ by rounding errors of the output, below 1e-14 of the peak with 8 poles and 1e-12 with 16 in the
/// tests.

namespace powbench::dsp {

inline constexpr std::size_t lanes = 8;

struct Coefficient {
  double b0, m1, c1, c0, d0;
};

struct SosLoop {
  const Coefficient* coefficients;
  std::size_t sections;
  bool difference;
};

struct SosKernel {
  const char* name;
  /// `frames` frames of eight interleaved lanes, in place; frame i at x + 8 step i.
  void (*run_frames)(const SosLoop&, double* state, double* x, std::ptrdiff_t step, std::size_t frames);
  /// One lane, in place; sample i at x + step i.
  void (*run_one)(const SosLoop&, double* state, double* x, std::ptrdiff_t step, std::size_t samples);
  /// Eight pieces of one channel at once: sample i of lane w at x + w stride + step i, step = +-1. `in` is read,
  /// `out` written in the same order, or nothing is written when it is null.
  void (*run_pieces)(const SosLoop&, double* state, const double* in, double* out, std::ptrdiff_t stride,
                     std::ptrdiff_t step, std::size_t samples);
};

const SosKernel& portable_sos_kernel();
const SosKernel& avx2_sos_kernel();    ///< built on x86-64 only
const SosKernel& avx512_sos_kernel();  ///< built on x86-64 only

/// The fastest version this processor can run.
const SosKernel& best_sos_kernel();

}  // namespace powbench::dsp
