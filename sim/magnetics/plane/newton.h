#pragma once

#include <vector>

#include "sim/magnetics/plane/cholesky.h"
#include "sim/magnetics/plane/field_problem.h"

/// Newton's method on the energy of a FieldProblem, each winding either with a given current or in a given circuit
///
///   c_k^T a + r_k i_k = b_k     (r_k = 0: prescribed flux linkage; r_k = R dt: a step of implicit Euler).
///
/// The circuits border the sparse matrix: one factorisation and one more solve a circuit. The first step meets the
/// circuits (they are linear), every later one keeps them and is cut until the energy falls (Armijo). It ends on the
/// Newton decrement, lambda^2 <= tolerance E, after the step of that iteration: the relative error of the energy is
/// then far below the tolerance squared.

namespace powbench::sim {

struct Circuit {
  bool flux_given = false;  ///< false: `value` is the current
  double value = 0;         ///< A, or b_k in Wb
  double resistance = 0;    ///< r_k, Wb/A, >= 0
};

struct NewtonOptions {
  double tolerance = 1e-9;
  int most_iterations = 60;
  bool line_search = true;
};

struct NewtonReport {
  bool converged = false;
  int iterations = 0;    ///< factorisations
  int cuts = 0;          ///< halvings of a step
  double decrement = 0;  ///< lambda^2 / E of the last step
};

/// Armijo's rule: the first of 1, 1/2, 1/4 .. of a step that meets the circuits with which the energy falls enough.
struct LineSearch {
  const FieldProblem& problem;
  const std::vector<double>& matrix;  ///< of the linear part
  const std::vector<double>* load;    ///< nullptr: none
  const std::vector<Circuit>& circuits;

  /// `quadratic`: energy of the linear part at a; `cuts` grows by the halvings.
  double share(const std::vector<double>& a, const std::vector<double>& da,
               const std::vector<double>& current, const std::vector<double>& di, double decrement,
               double quadratic, int& cuts) const;
};

/// Inverse of a small symmetric positive definite matrix of n rows, by rows.
std::vector<double> inverse_of(std::vector<double> matrix, std::size_t n);

class Newton {
 public:
  explicit Newton(const FieldProblem&);

  /// Improves `a` (size + 1 entries, the last one zero) and sets `current` of every winding.
  NewtonReport solve(const std::vector<Circuit>&, std::vector<double>& a, std::vector<double>& current,
                     const NewtonOptions& = {});

  /// Linear matrix and load in place of K and nothing: E = a^T matrix a / 2 + steel - load^T a. For time steps with
  /// eddy currents. The vectors must live through `solve`; nullptr: K, no load.
  void set_quadratic(const std::vector<double>* matrix, const std::vector<double>* load);

  /// Energy at the solution, J: with `set_quadratic` that of the changed functional.
  double energy() const { return energy_; }

  /// Derivatives of the minimum energy at the last solution: d i_k / d psi_l of the circuits with given flux by rows,
  /// and the second one by the height of the strip, which takes one more solve.
  const std::vector<double>& flux_flux() const { return inverse_; }
  double gap_gap(const std::vector<double>& a) const;

  /// da/dpsi_k at the last solution.
  std::vector<double> flux_tangent(std::size_t k) const;

  const Cholesky& cholesky() const { return cholesky_; }

 private:
  struct Step;
  double evaluate(const std::vector<double>& a, bool hessian);
  bool direction(const std::vector<Circuit>&, const std::vector<double>& a,
                 const std::vector<double>& current, Step&);

  const FieldProblem& problem_;
  Cholesky cholesky_;
  const std::vector<double>* matrix_ = nullptr;
  const std::vector<double>* load_ = nullptr;
  std::vector<double> values_, gradient_;
  std::vector<std::size_t> bordered_;        ///< windings with given flux
  std::vector<std::vector<double>> border_;  ///< H^-1 c_k of them
  std::vector<double> inverse_;              ///< (C^T H^-1 C + R)^-1, by rows
  double energy_ = 0, quadratic_ = 0;
  int factored_version_ = -1;  ///< linear_version of the last factorisation; -1: another matrix
};

}  // namespace powbench::sim
