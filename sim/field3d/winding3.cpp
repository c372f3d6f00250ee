#include "sim/field3d/winding3.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {

std::function<Vec3(const Vec3&)> coil_field(const BoxCoil& coil) {
  if (!(coil.width > 0) || !(coil.high > coil.low))
    throw std::invalid_argument("coil: the section has no area (width and height, allowed above 0 m)");
  if (!(coil.radius >= 0) || !(coil.half_x >= coil.radius) || !(coil.half_y >= coil.radius))
    throw std::invalid_argument("coil: the corners' radius is larger than half of the opening");
  return [coil](const Vec3& p) -> Vec3 {
    if (p[2] < coil.low || p[2] > coil.high) return {};
    const double dx = std::fabs(p[0] - coil.x) - (coil.half_x - coil.radius);
    const double dy = std::fabs(p[1] - coil.y) - (coil.half_y - coil.radius);
    const double from_centre = dx > 0 && dy > 0 ? std::hypot(dx, dy) : std::max(dx, dy);
    const double share = std::clamp(1 - (from_centre - coil.radius) / coil.width, 0.0, 1.0);
    return {0, 0, coil.turns / (coil.high - coil.low) * share};
  };
}

}  // namespace powbench::sim
