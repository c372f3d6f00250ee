#pragma once

#include <cstddef>

/// Loops over several numbers at once, the same on every instruction set: without fused products (-ffp-contract=off)
/// every version rounds alike. Columns of least squares are in gram.h, where products are fused.

/// Before a function: it is built a second time for AVX2, and the processor decides when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define POWBENCH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define POWBENCH_WIDE
#endif

/// Before a helper of such functions: it becomes part of each version.
#define POWBENCH_WITHIN_WIDE __attribute__((always_inline)) inline

namespace powbench::dsp {

constexpr std::size_t wide_lanes = 8;
using Wide = double __attribute__((vector_size(wide_lanes * sizeof(double))));
/// The same at any address of doubles.
using WideView =
    double __attribute__((vector_size(wide_lanes * sizeof(double)), aligned(sizeof(double)), may_alias));

}  // namespace powbench::dsp
