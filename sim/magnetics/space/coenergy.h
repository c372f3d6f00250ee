#pragma once

#include <vector>

#include "sim/magnetics/space/cholesky.h"
#include "sim/magnetics/space/problem.h"

/// The co-energy of a problem as a convex function of potentials and currents, with its derivatives.

namespace powbench::sim::space {

class Coenergy {
 public:
  /// Throws std::invalid_argument for a mesh that contradicts the problem (unknown region, cells inside out).
  /// Keeps a reference to the problem.
  explicit Coenergy(const Problem&);

  /// After the problem's nodes have moved, or its windings changed; cells, regions and ties stay.
  void nodes_moved();

  int unknowns() const { return matrix_.size(); }
  int windings() const { return static_cast<int>(problem_.windings.size()); }
  const Problem& problem() const { return problem_; }

  /// W'(u, I) of the whole, J. Where asked: dW'/du (A-1 J) and the flux linkages dW'/dI, Wb.
  double value(const State&, std::vector<double>* gradient, std::vector<double>* flux) const;

  /// d2W'/du2, its border d2W'/du dI_k (one vector a winding) and d2W'/dI_k dI_l (row after row).
  struct Hessian {
    SymmetricMatrix uu;
    std::vector<std::vector<double>> ui;
    std::vector<double> ii;
  };
  Hessian hessian() const;  ///< with the pattern and room for the values
  void hessian(const State&, Hessian&) const;

  /// Largest flux density in the middles of cells with a steel, T; 0 without steel.
  double largest_steel_field(const State&) const;

  /// Potential of every node, fixed and tied ones included.
  std::vector<double> nodal(const State&) const;

  /// Of what fills cell `c`.
  const MediumLaw& law(int c) const {
    return laws_[static_cast<std::size_t>(problem_.mesh.region[static_cast<std::size_t>(c)])];
  }

  /// Field H at integration point `q` of cell `c`, from the potentials of nodal(); its gradients on the way.
  Vec3 field(int c, int q, const std::vector<double>& nodal, const State&) const;

 private:
  struct Iron;  // one cell of a non-linear region, with everything that does not change
  void number();
  void build_pattern();
  void assemble_linear();
  void prepare_iron();
  template <class Visit>
  void for_iron_points(const State&, const Visit&) const;
  Vec3 source(const Vec3& at, int k) const { return problem_.windings[static_cast<std::size_t>(k)](at); }

  const Problem& problem_;
  std::vector<MediumLaw> laws_;
  std::vector<int> unknown_of_;      ///< [node], -1: fixed
  std::vector<double> fixed_value_;  ///< [node]
  SymmetricMatrix matrix_;           ///< of the linear regions
  std::vector<int> slot_;            ///< [cell][pair of its nodes, a >= b] into matrix_.value; -1: none
  std::vector<std::vector<double>> linear_ui_;  ///< [winding, and last the fixed potentials as if one more]
  std::vector<double> linear_ii_;
  std::vector<int> iron_;            ///< cells of non-linear regions
  std::vector<double> iron_weight_;  ///< [iron][point]
  std::vector<Vec3> iron_gradient_;  ///< [iron][point][node]
  std::vector<Vec3> iron_source_;    ///< [iron][point][winding]
};

}  // namespace powbench::sim::space
