#pragma once

#include <memory>
#include <vector>

#include "sim/magnetics/space/coenergy.h"

/// Newton's method on the co-energy. Each winding has a given current or a given flux linkage; for the latter its
/// current is one more unknown, and W'(u, I) - sum psi_k I_k is what becomes least. Convex, so every step is
/// downhill.

namespace powbench::sim::space {

/// What drives one winding.
struct Drive {
  bool flux = false;  ///< value is a flux linkage, Wb; else a current, A
  double value = 0;
};

struct NewtonOptions {
  double tolerance = 1e-12;  ///< stop when the Newton decrement is below this share of the co-energy
  int most_iterations = 60;
};

struct Solution {
  State state;
  std::vector<double> flux;  ///< psi_k, Wb
  double coenergy = 0;       ///< W', J
  double energy = 0;         ///< W = sum psi_k I_k - W', J
  double decrement = 0;      ///< the last one, relative
  int iterations = 0;
  int line_steps = 0;  ///< evaluations of the co-energy beyond one an iteration
  bool converged = false;
};

class Newton {
 public:
  /// Orders the matrix. Keeps a reference.
  explicit Newton(const Coenergy&);
  ~Newton();

  /// From a start (empty: zero).
  Solution solve(const std::vector<Drive>&, const State& start = {}, const NewtonOptions& = {});

  /// d psi_k / d I_l at a solution, row after row: the differential inductances, H.
  std::vector<double> inductance(const State&);

  /// du/dI_k at a solution, one vector a winding; `inductance` on the way. `factored`: with the matrix of the last step
  /// that led there, which saves a factorisation; off by the length of that step, the root of its decrement.
  std::vector<std::vector<double>> tangents(const State&, std::vector<double>& inductance,
                                            bool factored = false);

 private:
  struct Step;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::sim::space
