#pragma once

#include <array>
#include <vector>

#include "sim/solid/node_forces.h"
#include "sim/solid/solid_material.h"
#include "sim/solid/solid_mesh.h"

/// Selective mass scaling: thin cells get inertia against deformation and none against rigid motion, so that they no
/// longer bound the step of the whole mesh,
///
///   M' = M + sum_e lambda_e (m_e / n) (I - R R^T),   lambda_e = (wanted step / own step)^2 - 1, where positive,
///
/// m_e the mass of cell e, R the six rigid motions of its n corners where they are now (orthonormal). Without R this is
/// the scaling of Olovsson, Simonsson and Unosson (2005), which keeps translations but brakes rotations. I - R R^T is a
/// projection and the stiffness of a cell sees no rigid motion either, so its highest frequency falls by
/// sqrt(1 + lambda_e) exactly; the inertia acts only on the differences of motion within a cell, so long waves keep
/// their speed. The momentum M' v is carried on, each with R half a step from the places:
///
///   M v(n+1/2) + p(n+1/2) = M v(n-1/2) + p(n-1/2) + dt f,   p = (M' - M) v,
///
/// so that a body that turns freely turns on as if nothing had been added: p is zero all along.

namespace powbench::sim {

/// Time a wave needs through a cell, s: a lower bound of the largest stable step of the cell alone.
double own_step(const SolidMesh&, const SolidCell&, const SolidMaterial&);

class AddedInertia {
 public:
  AddedInertia() = default;
  /// Throws std::invalid_argument for a wanted step that is not in (0, median of the own steps of the cells], s: a
  /// larger one would change more than thin cells.
  AddedInertia(const SolidMesh&, const std::vector<SolidMaterial>&, double wanted);

  bool empty() const { return cells_.empty(); }
  int cells() const { return static_cast<int>(cells_.size()); }
  double share() const { return share_; }  ///< sum of lambda_e m_e over the mass of the mesh
  /// By cell of the mesh, sqrt(1 + lambda_e).
  const std::vector<double>& gains() const { return gains_; }

  /// Sets the places for R: reference + u + ahead v; cells of parts for which `still` says so take no part.
  template <class Still>
  void aim(const std::vector<Vec3>& reference, const double* u, const double* v, double ahead, Still still);
  /// (M' - M) a at the nodes of the scaled cells, [3 k + axis] with k the place in nodes().
  std::vector<double> times(const std::vector<double>& a) const;
  /// x of (D + M' - M) x = b by conjugate gradients, to 1e-11 of b; D by node and axis, held where not positive.
  std::vector<double> solve(const std::vector<double>& diagonal, const std::vector<double>& b) const;

  const std::vector<int>& nodes() const { return nodes_; }  ///< of scaled cells, ascending
  std::vector<double> gather(const double* four_a_node) const;

  /// Makes of velocities that M alone gave those of M', with places of which `drift` v has been the last step.
  void correct(const std::vector<double>& diagonal, double drift, double* u, double* v);
  /// p of velocities as they are; of still parts zero.
  void start(const double* v) { momentum_ = before_ = times(gather(v)); }
  /// J: v(n-1/2) . p(n+1/2) / 4 + v(n+1/2) . p(n-1/2) / 4.
  double kinetic(const double* v_before, const double* v_now) const;
  /// J, v . p / 2 of nodes first .. last - 1.
  double kinetic_of(int first, int last, const double* v) const;

  /// No momentum for nodes first .. last - 1: their part is frozen.
  void rest(int first, int last);

  const std::vector<double>& momentum() const { return momentum_; }
  void set_momentum(const std::vector<double>& p) { momentum_ = p; }
  long iterations() const { return iterations_; }  ///< of all solves

 private:
  struct Cell {
    int part = 0, corners = 0;
    double inertia = 0;  ///< kg: lambda_e m_e / n
    std::array<int, 8> place{};
    bool still = false;
    std::array<Vec3, 8> arm{};
    std::array<Vec3, 3> turn{};  ///< inverse of the sum of |r|^2 I - r r^T
  };

  void aim(Cell&, const std::vector<Vec3>& at) const;

  std::vector<Cell> cells_;
  std::vector<int> nodes_;
  std::vector<double> gains_, momentum_, before_;
  double share_ = 0;
  mutable long iterations_ = 0;
};

template <class Still>
void AddedInertia::aim(const std::vector<Vec3>& reference, const double* u, const double* v, double ahead,
                       Still still) {
  const NodeView view{&reference, u, v};
  std::vector<Vec3> at;
  for (const int n : nodes_) at.push_back(view.place(n) + ahead * view.velocity(n));
  for (Cell& c : cells_)
    if (c.still = still(c.part); !c.still) aim(c, at);
}

}  // namespace powbench::sim
