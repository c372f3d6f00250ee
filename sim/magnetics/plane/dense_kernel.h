#pragma once

/// Dense inner loops of the sparse Cholesky factorisation, once for each instruction set; the best one that the
/// processor has is chosen at run time. Matrices are column-major; at least `dense_slack` doubles must be readable
/// behind the last element, and none of what lies between columns may be infinite. Only in these files are products
/// and sums fused.

namespace powbench::sim {

inline constexpr int dense_slack = 16;

struct DenseKernel {
  const char* name;

  /// C -= A B^T on the lower trapezoid (i >= j) of C: m rows, n <= m columns; A is m x k, B its first n rows.
  void (*subtract_square)(double* c, int ldc, const double* a, int lda, int m, int n, int k);

  /// Cholesky of the leading n x n block of the m x n panel and the rows below solved with it. Returns the column of
  /// the first pivot that is not positive, or -1.
  int (*factor_panel)(double* a, int lda, int m, int n);

  /// With such a panel L: x_1 = L_1^-1 x_1, then x_2 -= L_2 x_1; x has the n and the m - n rows of the panel. One or
  /// two vectors x, `ldx` apart; up to `dense_slack` doubles behind row m of each are overwritten.
  void (*forward)(const double* a, int lda, int m, int n, double* x, int ldx, int vectors);

  /// x_1 = L_1^-T (x_1 - L_2^T x_2). The `dense_slack` doubles behind row m of each become zero.
  void (*backward)(const double* a, int lda, int m, int n, double* x, int ldx, int vectors);
};

const DenseKernel& portable_dense_kernel();
const DenseKernel& avx2_dense_kernel();
const DenseKernel& avx512_dense_kernel();

/// The fastest for this processor.
const DenseKernel& best_dense_kernel();

}  // namespace powbench::sim
