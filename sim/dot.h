#pragma once

#include <cstddef>
#include <span>

namespace powbench::sim {

/// Sum of a_k b_k over the entries of `a`, in their order; `b` has at least as many.
inline double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace powbench::sim
