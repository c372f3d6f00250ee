#pragma once

#include <memory>
#include <vector>

#include "sim/fields/core_mesh.h"
#include "sim/fields/newton.h"
#include "sim/fields/potential.h"

/// The rung `field2d`: a core in its air, solved by finite elements in the plane of its laminations. The depth is the
/// stack; the field at the ends of the stack is not in it.

namespace powbench::sim {

/// What the field rungs need of a magnet. SI.
struct MagnetDesign {
  MagnetShape shape;
  Steel steel = builtin_steel("lamination");
  double turns = 2000;
  double residual_gap = 36e-6;  ///< m, between all pole faces of the closed magnet; > 0
  double end_leakage = 0;       ///< H: flux of the winding's heads, in series with the field
  double ring_leakage = 0;      ///< H: the same of the ring's heads, one turn
};

/// Mesh and elements. `accuracy` is the error of psi and pull that the sizes are meant for.
struct FieldOptions {
  CoreMeshSizes sizes;
  int order = 2;
  double largest_gap = 6e-3;  ///< m: sets the layers of the strip; larger gaps are allowed
  NewtonOptions newton;
};

/// Sizes for a wanted relative error of psi and pull, 0.0002 .. 0.05; throws std::invalid_argument otherwise.
CoreMeshSizes sizes_for(double accuracy);

/// The finite elements of a design. Winding 0 is the coil, winding 1 the ring where there is one; `iron_conductivity`
/// in S/m lets eddy currents flow in solid cores (0: laminated).
FieldProblem magnet_problem(const MagnetDesign&, const FieldOptions&, double iron_conductivity = 0);

/// One solved state.
struct FieldPoint {
  MagneticResponse response;
  double stress_pull =
      0;  ///< N: Maxwell's stress in one layer of the strip; its distance to `pull` is an error estimate
  double largest_field = 0;  ///< T, in the steel
  bool beyond_data = false;  ///< `largest_field` is above Steel::data_end: part of the curve is extrapolated
  NewtonReport newton;
  std::vector<double> a;  ///< the solution, for pictures and for the next start
};

class MagnetField {
 public:
  MagnetField(const MagnetDesign&, const FieldOptions&);
  MagnetField(const MagnetField&);  ///< for another thread; shares nothing
  ~MagnetField();

  int unknowns() const;
  bool has_ring() const;
  const FieldProblem& problem() const;

  /// m, >= 0; the residual gap is added.
  void set_gap(double gap);

  /// With both flux linkages given; without a ring, and with `ring_open`, the ring carries no current and `state.ring`
  /// is not read. `start`: a solution near by, or empty.
  FieldPoint at_flux(double psi, double ring, std::vector<double> start = {}, bool ring_open = false);

  /// With both currents given. The second derivatives of the response stay zero.
  FieldPoint at_current(double current, double ring_current, std::vector<double> start = {});

  /// Flux linkages of a solution: coil (with end leakage times `current`) and ring.
  std::pair<double, double> fluxes(const FieldPoint&) const;

  /// da/dpsi and da/dring of the last `at_flux`.
  std::vector<double> tangent(std::size_t winding) const;

 private:
  FieldPoint finish(std::vector<double> a, const std::vector<double>& current, NewtonReport);

  MagnetDesign design_;
  FieldOptions options_;
  std::unique_ptr<FieldProblem> problem_;
  std::unique_ptr<Newton> newton_;
  std::vector<double> layer_;  ///< weight of the stress force: rises in the middle layer of the strip
};

}  // namespace powbench::sim
