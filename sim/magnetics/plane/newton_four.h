#pragma once

#include <array>
#include <vector>

#include "sim/magnetics/plane/cholesky_four.h"
#include "sim/magnetics/plane/newton.h"

/// Newton's method as in newton.h for four problems at once: one drawing with its vertices in four places, one gap in
/// each lane, all in the same circuits. All four iterate until the last has converged. Where a step was small they
/// may end without another factorisation (docs/decisions/0013-fields.md).

namespace powbench::sim {

class NewtonFour {
 public:
  using Vectors = std::array<std::vector<double>, 4>;  ///< one for each problem

  /// The problems must have the same space but for the places of its vertices, and outlive this.
  explicit NewtonFour(const std::array<const FieldProblem*, 4>&);

  /// To be called when the vertices have moved.
  void take_places();

  /// To be called when the first problem's steels are others; they count for all.
  void take_steels();

  /// As Newton::solve. Iterations are those of all four.
  std::array<NewtonReport, 4> solve(const std::vector<Circuit>&, Vectors& a, Vectors& current,
                                    const NewtonOptions& = {});

  /// Of the last solution.
  double energy(std::size_t problem) const { return energy_.of[problem]; }

  /// d i_k / d psi_l of the circuits with given flux, by rows.
  const std::vector<double>& flux_flux(std::size_t problem) const { return inverse_[problem]; }

  /// da/dpsi_k at the last solution.
  Vectors flux_tangent(std::size_t k) const;

 private:
  struct Step;
  void evaluate(bool hessian);
  bool direction(const std::vector<Circuit>&, const Vectors& current, Step&);
  void downhill(const Vectors& current, Step&) const;
  void take(const Step&, const Four& share, Vectors& current);
  void close_circuits(const std::vector<Circuit>&, const Vectors& current, Step&);
  void chord(const std::vector<Circuit>&, Vectors& current, const Four& decrement, const NewtonOptions&,
             std::array<NewtonReport, 4>&);
  void correct(Vectors& current);
  Four decrement_of(const std::vector<Circuit>&, const Vectors& current, const Step&) const;
  Four dot(const std::vector<Four>&, const std::vector<Four>&) const;

  std::array<const FieldProblem*, 4> problems_;
  CholeskyFour cholesky_;
  FourSteel steel_;
  std::vector<const Steel*> steels_;
  std::vector<int> unknowns_, positions_;
  std::vector<Four> curls_, weights_, linear_;
  std::vector<std::vector<Four>> windings_;
  std::vector<Four> a_, values_, gradient_;
  std::vector<std::size_t> bordered_;      ///< windings with given flux
  std::vector<std::vector<Four>> border_;  ///< H^-1 c_k of them
  std::array<std::vector<double>, 4> inverse_;
  Four energy_{}, quadratic_{};
  bool air_factored_ = false;  ///< the last factorisation had the vertices where they are
};

}  // namespace powbench::sim
