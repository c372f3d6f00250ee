#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/magnetics/plane/core_mesh.h"

/// A solenoid around an axis: a plunger slides through the bore of a flange towards a stop inside the coil. Lengths
/// in m.
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
/// Faces that are not flat reach into the stop: z = 0 is the rim of the stop's face then. The gap is measured along
/// the axis:
///
///   conical   a truncated cone of height (R - tip radius) tan(angle), with the same angle in the stop
///   stepped   a pin of a smaller radius in a wider hole of the same depth

namespace powbench::sim {

enum class PlungerFace : std::uint8_t { flat, conical, stepped };

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
  PlungerFace face = PlungerFace::flat;
  double cone_angle = 0;      ///< rad, conical: of the face against a flat one, 5 .. 75 deg
  double tip_radius = 0;      ///< conical: of the flat end
  double step_radius = 0;     ///< stepped: of the pin
  double step_depth = 0;      ///< stepped: of pin and hole
  double step_clearance = 0;  ///< stepped: radial, between pin and hole

  double magnet_length =
      0;  ///< of a permanent magnet, the lower end of the stop, over its whole radius; 0: none

  double face_depth() const;  ///< m, by which the plunger's face reaches into the stop when closed
};

/// Throws std::invalid_argument that names the first key whose value cannot be, with its range: lengths of 0.05 mm to
/// 500 mm, radii that ascend, a plunger that reaches through the flange, a gap that stays 1 mm below the winding's
/// end, a face that stays 1 mm above the stop's lower end within the winding.
void check_solenoid(const SolenoidShape&, double largest_gap);

/// Numbers are those of CoreRegion where both have one.
struct SolenoidRegion {
  enum : int {
    air = CoreRegion::air,
    fixed_iron = CoreRegion::fixed_iron,
    plunger = CoreRegion::moving_iron,
    coil = CoreRegion::coil,
    magnet = CoreRegion::ring_inner,
    count = CoreRegion::count
  };
};

/// The half plane (r, z) with one topology for every gap: lines of the grid beside the plunger's faces go with it,
/// and lie along them where they are not flat. What stands still keeps its vertices.
class SolenoidGrid {
 public:
  /// `largest_gap` sets the layers between plunger and stop. Throws by `check_solenoid`.
  SolenoidGrid(const SolenoidShape&, const CoreMeshSizes&, double largest_gap);

  const Mesh& mesh() const { return mesh_; }  ///< at the gap `reference()`
  double reference() const { return reference_; }

  /// z of every vertex at this gap, m, > 0. The plunger's own vertices keep no place in it where it is drawn through
  /// the flange.
  std::vector<double> heights(double gap) const;

  /// How far each vertex goes when the gap grows by one, in air alone: 1 in the plunger, 0 in what stands still, linear
  /// across the gap at the stop, across the radial gap and over the same length beyond the plunger's outer end.
  /// Beside a pin it rises across the clearance.
  std::vector<double> motion(double gap) const;

 private:
  double moved(double z, double gap) const;
  double height(double r, double z, double gap) const;
  /// Four levels of a stepped face at this radius: hole, rim, pin, shoulder, as meshed and at `gap`; their weights in
  /// `motion`.
  struct Levels {
    std::array<double, 4> meshed, at, weight;
  };
  Levels levels_at(double r, double gap) const;

  SolenoidShape shape_;
  double reference_ = 0, far_ = 0;
  std::vector<double> meshed_;  ///< z of the vertices before they follow the faces, at `reference_`
  Mesh mesh_;
};

}  // namespace powbench::sim
