#pragma once

#include <cstddef>
#include <vector>

#include "sim/magnetics/plane/four_kernel.h"
#include "sim/magnetics/plane/fronts.h"

/// Cholesky factorisations A = L L^T of four matrices of equal pattern at once, one in each lane of a vector. Every
/// operation is a whole vector's, however small a front is; one matrix alone (Cholesky) leaves lanes idle in small
/// fronts. Not thread-safe: one object a thread; copying shares nothing.

namespace powbench::sim {

class CholeskyFour {
 public:
  explicit CholeskyFour(const Pattern&);

  /// Columns, 1, whose values change from one `solve` to the next; the others, 0, may be kept. Called before `solve`.
  void set_changing(const std::vector<char>& columns);

  /// `values` belong to the rows of the pattern. b becomes A^-1 b, for one to three b. The first half of the solve goes
  /// along with the factorisation, while each front is in the cache. With `others_kept` the values of the columns that
  /// do not change are those of the last time, and fronts made of nothing else are not factored again. False where one
  /// of the four is not positive definite; then b means nothing.
  bool solve(const Four* values, const std::vector<Four*>& b, bool others_kept = false);

  /// b becomes A^-1 b with the matrices of the last `solve`.
  void solve_again(Four* b);

 private:
  void backward(const std::vector<Four*>& b);
  void add_children(const Front&, Four* panel, Four* update);
  Four* update_of(std::size_t front);
  const int* rows_below(const Front& f) const { return structure_.rows.data() + f.structure + f.columns; }

  /// Where the parts of a front lie.
  struct Place {
    std::size_t panel = 0;     ///< offset in panels_
    std::size_t update = 0;    ///< offset in the stack of its depth, or in kept_
    int depth = 0;             ///< which of the two stacks, even or odd depth
    bool constant = false;     ///< with all below it
    bool handed_over = false;  ///< constant, the parent is not: the update matrix is kept
  };

  Pattern pattern_;
  Fronts structure_;
  std::vector<Place> places_;
  std::vector<Four> panels_;
  /// Update matrices: a front takes those of its children from the other stack.
  std::vector<Four> stacks_[2];
  std::vector<Four> kept_;
  bool kept_valid_ = false;
};

}  // namespace powbench::sim
