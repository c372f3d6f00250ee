#pragma once

/// Dense inner loops of the sparse Cholesky factorisation, once for each instruction set; the best one that the
/// processor has is chosen at run time. Matrices are column-major; at least `dense_slack` doubles must be readable
/// behind the last element. Only in these files are products and sums fused.

namespace powbench::sim {

inline constexpr int dense_slack = 16;

struct DenseKernel {
  const char* name;

  /// C -= A B^T on the lower trapezoid (i >= j) of C: m rows, n <= m columns; A is m x k, B its first n rows.
  void (*subtract_square)(double* c, int ldc, const double* a, int lda, int m, int n, int k);

  /// Cholesky of the leading n x n block of the m x n panel and the rows below solved with it. Returns the column of
  /// the first pivot that is not positive, or -1.
  int (*factor_panel)(double* a, int lda, int m, int n);
};

const DenseKernel& portable_dense_kernel();
const DenseKernel& avx2_dense_kernel();
const DenseKernel& avx512_dense_kernel();

/// The fastest for this processor.
const DenseKernel& best_dense_kernel();

}  // namespace powbench::sim
