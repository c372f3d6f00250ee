#pragma once

#include <cstddef>

/// Cross products of columns, C = A^T B: what every least-squares fit spends its time on. One version for each
/// instruction set, chosen at run time; all sum in the same order, eight partial sums a product, and differ by fused
/// rounding only.

namespace powbench::dsp {

/// Columns of doubles, each `stride` after the one before.
struct ColumnSet {
  const double* data;
  std::size_t stride, count;
};

/// c[i + k c_stride] = sum over `rows` of a_i b_k. Where `a` and `b` are the same columns half of them are mirrored.
/// Rounding: at most (rows / 8 + 8) units of the last place of the sum of magnitudes.
void cross_products(const ColumnSet& a, const ColumnSet& b, std::size_t rows, double* c,
                    std::size_t c_stride);

/// A^T B of column-major matrices, or vectors, that know data(), outerStride(), rows() and cols(); both of the same
/// rows.
template <class Matrix, class A, class B>
Matrix cross(const A& a, const B& b) {
  const auto size = [](auto n) { return static_cast<std::size_t>(n); };
  Matrix c(a.cols(), b.cols());
  cross_products({a.data(), size(a.outerStride()), size(a.cols())},
                 {b.data(), size(b.outerStride()), size(b.cols())}, size(a.rows()), c.data(), size(c.rows()));
  return c;
}

/// One version: the products of a_i, i < na, with b_k, k < nb; with `upper` only those with i <= k.
struct GramKernel {
  const char* name;
  void (*run)(const ColumnSet& a, const ColumnSet& b, std::size_t rows, double* c, std::size_t c_stride,
              bool upper);
};
const GramKernel& portable_gram_kernel();
const GramKernel& avx2_gram_kernel();    ///< built on x86-64 only
const GramKernel& avx512_gram_kernel();  ///< built on x86-64 only

}  // namespace powbench::dsp
