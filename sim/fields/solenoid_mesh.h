#pragma once

#include <vector>

#include "sim/fields/core_mesh.h"

/// A solenoid around an axis: a plunger slides through the bore of a flange towards a stop inside the coil. Lengths in m.
///
///   z            plunger
///   ^           |       |
///   |   +-------+ bore  +-------+  flange        r = 0: the axis
///   |   |+-----+|       |+-----+|                z = 0: face of the stop
///   |   || coil |       | coil ||  case
///   |   ||     |+-------+|     ||  --- gap ---
///   |   |+-----+| stop  |+-----+|
///   |   +-------+-------+-------+  plate
///
/// The plunger is longer than its way through the flange, so that only the gap at the stop and the end outside change.

namespace powbench::sim {

struct SolenoidShape {
  double plunger_radius = 8e-3;  ///< also of the stop
  double bore_radius = 8.3e-3;   ///< of the flange: the plunger slides in a radial gap
  double plunger_length = 37e-3;
  double stop_length = 14e-3;  ///< from the plate to the stop's face
  double window = 38e-3;       ///< from the plate to the flange
  double plate = 4e-3;         ///< thickness
  double flange = 5e-3;        ///< thickness
  double coil_inner = 9e-3;    ///< radii of the winding's section
  double coil_outer = 16e-3;
  double coil_clearance = 1e-3;  ///< of the winding to plate and flange
  double case_inner = 16.5e-3;   ///< radii of the case
  double case_outer = 20e-3;
};

/// Throws std::invalid_argument that names the first key whose value cannot be, with its range: lengths of 0.05 mm to
/// 500 mm, radii that ascend, a plunger that reaches through the flange, a gap that stays 1 mm below the winding's end.
void check_solenoid(const SolenoidShape&, double largest_gap);

struct SolenoidRegion {
  enum : int { air, fixed_iron, plunger, coil, count };
};

/// The half plane (r, z) with one topology for every gap: lines of the grid beside the plunger's faces go with it.
class SolenoidGrid {
 public:
  /// `largest_gap` sets the layers between plunger and stop. Throws by `check_solenoid`.
  SolenoidGrid(const SolenoidShape&, const CoreMeshSizes&, double largest_gap);

  const Mesh& mesh() const { return mesh_; }  ///< at the gap `reference()`
  double reference() const { return reference_; }

  /// z of every vertex at this gap, m, > 0.
  std::vector<double> heights(double gap) const;

  /// How far each vertex goes when the gap grows by one, in air alone: 1 in the plunger, 0 in what stands still, linear
  /// across the gap at the stop, across the radial gap and over the same length beyond the plunger's outer end.
  std::vector<double> motion(double gap) const;

 private:
  double moved(double z, double gap) const;

  SolenoidShape shape_;
  double reference_ = 0, far_ = 0;
  Mesh mesh_;
};

}  // namespace powbench::sim
