#pragma once

#include <cstddef>

/// Inner loops of four factorisations side by side, once for each instruction set; the best one that the processor has
/// is chosen at run time. Matrices are column-major, of four numbers an entry. Only in these files are products and
/// sums fused.

namespace powbench::sim {

/// The same number of four problems.
struct alignas(32) Four {
  double of[4];
};

/// Where column j of a lower triangle of m rows begins, by columns.
inline std::size_t packed_column(std::size_t m, std::size_t j) {
  return j * m - j * (j - 1) / 2;
}

class Steel;

/// The steel of four meshes that differ in the places of their vertices only.
struct FourSteel {
  int nodes = 0, points = 0;  ///< of an element
  std::size_t elements = 0;
  const Four* curls = nullptr;           ///< by element and point: nodes x B_x, nodes x B_y
  const Four* weights = nullptr;         ///< by element and point
  const int* unknowns = nullptr;         ///< by element and node
  const int* positions = nullptr;        ///< by element, as element_positions
  const Steel* const* steels = nullptr;  ///< by element
};

/// H, dH/dB and w of one steel at four B >= 0.
struct FourSteelPoint {
  Four h, dh_db, energy;
};
FourSteelPoint steel_points(const Steel&, const Four& b);

struct FourKernel {
  const char* name;

  /// Sets the energy of the steel; adds the gradient, and the Hessian where `values` is given.
  void (*add_steel)(const FourSteel&, const Four* a, Four* energy, Four* gradient, Four* values);

  /// y = A x for symmetric matrices of `size` rows given by their lower triangles, by columns.
  void (*multiply)(int size, const int* start, const int* row, const Four* values, const Four* x, Four* y);

  /// Cholesky of the leading n x n block of the m x n panel and the rows below solved with it; the diagonal becomes
  /// that of L^-1. Returns the column of the first pivot that is not positive in one of the four, or -1.
  int (*factor_panel)(Four* a, int m, int n);

  /// C = -A A^T: the lower triangle of m rows, by columns; A is m x k, `lda` entries a column.
  void (*square)(Four* c, const Four* a, int lda, int m, int k);

  /// Adds `count` entries to those at `place`.
  void (*add)(Four* to, const int* place, const Four* from, int count);

  /// With such a panel L: x_1 = L_1^-1 x_1 of its own n entries, then x_2 -= L_2 x_1 of those at `below`.
  /// One to three vectors.
  void (*forward)(const Four* a, int m, int n, Four* const* x, int first, const int* below, int vectors);

  /// x_1 = L_1^-T (x_1 - L_2^T x_2).
  void (*backward)(const Four* a, int m, int n, Four* const* x, int first, const int* below, int vectors);
};

const FourKernel& portable_four_kernel();
const FourKernel& avx2_four_kernel();

/// The fastest for this processor.
const FourKernel& best_four_kernel();

}  // namespace powbench::sim
