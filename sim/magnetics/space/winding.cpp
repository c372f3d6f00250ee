#include "sim/magnetics/space/winding.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace powbench::sim::space {

std::function<Vec3(const Vec3&)> coil_field(const BoxCoil& coil) {
  if (!(coil.width > 0) || !(coil.high > coil.low))
    throw std::invalid_argument("coil: the section has no area (width and height, allowed above 0 m)");
  if (!(coil.radius >= 0) || !(coil.half_x >= coil.radius) || !(coil.half_y >= coil.radius))
    throw std::invalid_argument("coil: the corners' radius is larger than half of the opening");
  return [coil](const Vec3& p) -> Vec3 {
    const auto along = static_cast<std::size_t>(coil.axis);
    if (p[along] < coil.low || p[along] > coil.high) return {};
    const double share = std::clamp(1 - coil.from_opening(p) / coil.width, 0.0, 1.0);
    Vec3 t{};
    t[along] = coil.turns / (coil.high - coil.low) * share;
    return t;
  };
}

double BoxCoil::from_opening(const Vec3& p) const {
  const auto first = static_cast<std::size_t>((axis + 1) % 3),
             second = static_cast<std::size_t>((axis + 2) % 3);
  const double dx = std::fabs(p[first] - x) - (half_x - radius);
  const double dy = std::fabs(p[second] - y) - (half_y - radius);
  const double from_centre = dx > 0 && dy > 0 ? std::hypot(dx, dy) : std::max(dx, dy);
  return from_centre - radius;
}

double BoxCoil::volume() const {
  const auto area = [&](double more) {
    const double r = radius + more;
    return 4 * (half_x + more) * (half_y + more) - (4 - std::numbers::pi) * r * r;
  };
  return (area(width) - area(0)) * (high - low);
}

}  // namespace powbench::sim::space
