#pragma once

#include <vector>

#include "sim/magnetics/plane/field_space.h"

namespace powbench::sim {

/// The force on a body in linear air as a quadratic form, F = a^T P a: int T . grad(weight) with Maxwell's stress T.
class PullForm {
 public:
  PullForm() = default;

  /// Against y, on what has the weight 1; `weight` by vertex, 0 on what stands still. Only triangles over which it
  /// varies count: they must be air.
  PullForm(const FieldSpace&, const std::vector<double>& weight);

  /// F in N, and `slope` becomes dF/da.
  double force(const std::vector<double>& a, std::vector<double>& slope) const;
  double force(const std::vector<double>& a) const;

 private:
  /// One entry of the lower triangle of P, row >= column.
  struct Entry {
    int row, column;
    double value;
  };
  std::vector<Entry> entries_;
};

}  // namespace powbench::sim
