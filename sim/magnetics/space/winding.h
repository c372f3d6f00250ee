#pragma once

#include <functional>

#include "sim/magnetics/space/mesh.h"

/// Source fields T of windings, for Problem.

namespace powbench::sim::space {

/// A coil round an axis along z, or x or y: rectangular in plan with rounded corners, of uniform current density
/// (turns / section). Seen from the end of the axis, a positive current runs counter-clockwise. Lengths in m. The names
/// are those of an axis along z; x, y, z stand for y, z, x round an axis along x, and for z, x, y round one along y.
struct BoxCoil {
  double x = 0, y = 0;            ///< of the axis
  double half_x = 0, half_y = 0;  ///< of the opening
  double radius = 0;              ///< of the inner corners
  double width = 0;               ///< of the section, in plan
  double low = 0, high = 0;       ///< z of the section
  double turns = 1;
  int axis = 2;  ///< 0 x, 1 y, 2 z

  /// Distance of a point in plan from the opening, less than 0 within it; the section ends at `width`.
  double from_opening(const Vec3&) const;
  double volume() const;  ///< of the section round the axis, m3
};

/// T = e_z (turns / height) f(x, y) for z between low and high: f is 1 in the opening and falls to 0 across the
/// section. Throws std::invalid_argument for an opening smaller than its corners or an empty section.
std::function<Vec3(const Vec3&)> coil_field(const BoxCoil&);

}  // namespace powbench::sim::space
