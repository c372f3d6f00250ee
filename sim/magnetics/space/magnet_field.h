#pragma once

#include <memory>
#include <vector>

#include "sim/magnetics/potential.h"
#include "sim/magnetics/space/core_mesh.h"
#include "sim/magnetics/space/newton.h"

/// The field of the rung `ends`: the core with stack ends, coil heads and ring heads, by finite elements in three
/// dimensions. What the plane rung calls `end_leakage` is part of the field here; MagnetDesign::end_leakage and
/// `ring_leakage` are read only where the mesh has no ends.

namespace powbench::sim::space {

/// One solved state.
struct FieldPoint {
  /// Energy, currents, pull, inverse inductances and their derivatives by the gap; `pull_gap` stays 0.
  MagneticResponse response;
  double psi = 0, ring = 0;  ///< Wb, flux linkages
  double stress_pull =
      0;  ///< N: Maxwell's stress in one layer of the gap; its distance to `pull` is an error estimate
  std::vector<std::vector<double>> tangents;  ///< du/dI of coil and ring, the other current held
  Solution solution;
};

/// A problem with a part that stretches with the gap. Windings: the coil, then perhaps the ring. Sources T are 0 where
/// the motion varies.
struct Moving {
  Problem problem;
  std::vector<double> motion;  ///< by node: rise in m for each m of gap
  std::vector<double> layer;   ///< weight of the stress, see stress_force
  double gap = 1e-3;           ///< m, between the faces as meshed
  double residual = 0;         ///< m, between the faces when closed
};

class MagnetField {
 public:
  /// Gap at first: 1 mm. Throws std::invalid_argument that names key, value and range.
  explicit MagnetField(const MagnetDesign&, const CoreMeshSizes& = {}, const NewtonOptions& = {});
  explicit MagnetField(Moving, const NewtonOptions& = {});
  ~MagnetField();

  int unknowns() const;
  bool has_ring() const;
  const Coenergy& function() const;

  /// m, >= 0; the residual gap is added. The nodes of the strip move; cells and their numbering stay.
  void set_gap(double gap);

  /// Flux linkages given; without a ring, and with `ring_open`, the ring carries no current. `start`: a solution near
  /// by.
  FieldPoint at_flux(double psi, double ring, const State& start = {}, bool ring_open = false);

  /// Currents given.
  FieldPoint at_current(double current, double ring_current = 0, const State& start = {});

 private:
  FieldPoint finish(Solution, bool ring_bound);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::sim::space
