#pragma once

#include <memory>
#include <vector>

/// Cholesky factors of a sparse symmetric positive definite matrix whose pattern stays: ordered and analysed once
/// (nested dissection by METIS, supernodes), factored again for every set of values. CHOLMOD behind it.

namespace powbench::sim::space {

/// The lower triangle by columns, rows rising, the diagonal first.
struct SymmetricMatrix {
  std::vector<int> start;  ///< [column], one more than columns
  std::vector<int> row;
  std::vector<double> value;

  int size() const { return static_cast<int>(start.size()) - 1; }

  /// y = A x
  void multiply(const std::vector<double>& x, std::vector<double>& y) const;
};

class Cholesky {
 public:
  explicit Cholesky(const SymmetricMatrix& pattern);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  /// False if the matrix is not positive definite.
  bool factor(const SymmetricMatrix&);
  /// Solves A x = b for each column.
  std::vector<double> solve(const std::vector<double>& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::sim::space
