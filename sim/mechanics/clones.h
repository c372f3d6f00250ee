#pragma once

/// Marks for kernels that are compiled for several vector widths. The loader picks the widest that the machine
/// has; every clone does the same operations in the same order, so the bits are the same. Sanitizers cannot look
/// into the choice, so there is one version with them.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    defined(__OPTIMIZE__)
#define POWBENCH_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define POWBENCH_CLONES
#endif

/// Inlined into each clone, so that it takes the clone's vector width.
#define POWBENCH_INLINE __attribute__((always_inline)) inline
