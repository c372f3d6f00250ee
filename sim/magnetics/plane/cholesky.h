#pragma once

#include <cstddef>
#include <vector>

#include "sim/magnetics/plane/fronts.h"

/// Sparse Cholesky factorisation A = L L^T with one symbolic analysis for many matrices of equal pattern:
/// multifrontal over relaxed supernodes. The pattern must be in a postordered order of elimination already
/// (`fill_reducing_order`). Not thread-safe: one object a thread; copying shares nothing.

namespace powbench::sim {

class Cholesky {
 public:
  explicit Cholesky(const Pattern&);

  /// Which columns have entries that change from one matrix to the next, one flag each. Only their supernodes, and
  /// those above, are factored anew by `factor(values, true)`.
  void set_changing(const std::vector<char>& columns);

  /// `values` belong to the rows of the pattern. False where A is not positive definite; then no solve is allowed.
  /// `others_kept`: columns that do not change have the values of the last call. The factor is the same to the bit.
  bool factor(const double* values, bool others_kept = false);

  /// b becomes A^-1 b, for each of several: two at a time cost little more than one.
  void solve(const std::vector<double*>& b) const;
  void solve(double* b) const { solve(std::vector{b}); }

 private:
  struct Node : Front {
    int ld = 0;                ///< of the panel
    std::size_t panel = 0;     ///< offset in panels_
    bool constant = false;     ///< with all below it
    bool handed_over = false;  ///< constant, the parent is not: the update matrix is kept
    std::size_t kept = 0;      ///< its offset in kept_
  };
  void take_structure(const Pattern&);
  void solve_some(double* const* b, int vectors) const;
  void add_child(const Node& parent, const Node& child, const double* from, double* update, int ldu);

  Pattern pattern_;
  std::vector<Node> nodes_;
  std::vector<int> rows_;
  std::vector<int> relative_;
  std::vector<int> local_;  ///< for each entry of the pattern, its offset within the panel of its node
  std::vector<double> panels_;
  std::vector<double> stack_;
  std::vector<double> kept_;
  bool kept_valid_ = false;
  mutable std::vector<double> work_;  ///< two vectors of a front
  int work_rows_ = 0;
};

}  // namespace powbench::sim
