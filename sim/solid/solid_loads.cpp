#include "sim/solid/solid_loads.h"

#include <algorithm>

namespace powbench::sim {
namespace {

void spread(const NodeShares& on, const Vec3& force, NodeForces& forces) {
  for (std::size_t k = 0; k < on.nodes.size(); ++k) forces.add(on.nodes[k], on.shares[k] * force);
}

}  // namespace

Vec3 mean(const NodeShares& of, const double* field) {
  Vec3 sum;
  for (std::size_t k = 0; k < of.nodes.size(); ++k) {
    const double* p = field + 4 * static_cast<std::size_t>(of.nodes[k]);
    sum += of.shares[k] * Vec3{p[0], p[1], p[2]};
  }
  return sum;
}

double apply_loads(const std::vector<SolidLoad>& loads, const std::vector<SolidSpring>& springs,
                   const std::vector<SolidPlane>& planes, const NodeView& view, NodeForces& forces,
                   NodeForces& damped, double* plane_force) {
  double stored = 0;
  for (const auto& load : loads) spread(load.on, load.force, forces);
  for (const auto& spring : springs) {
    const double stretch = dot(mean(spring.a, view.u) - mean(spring.b, view.u), spring.axis);
    const double pull = spring.preload + spring.rate * stretch;
    spread(spring.a, -pull * spring.axis, forces);
    spread(spring.b, pull * spring.axis, forces);
    stored += (spring.preload + 0.5 * spring.rate * stretch) * stretch;
  }
  *plane_force = 0;
  for (const auto& plane : planes)
    for (std::size_t k = 0; k < plane.nodes.size(); ++k) {
      const double depth = dot(plane.point - view.place(plane.nodes[k]), plane.normal);
      if (depth <= 0) continue;
      const double f = plane.stiffness[k] * depth;
      double by = 0;
      if (!plane.damping.empty()) {
        by = std::max(-f, -plane.damping[k] * dot(view.velocity(plane.nodes[k]), plane.normal));
        damped.add(plane.nodes[k], by * plane.normal);
      }
      forces.add(plane.nodes[k], (f + by) * plane.normal);
      *plane_force += f + by;
      stored += 0.5 * f * depth;
    }
  return stored;
}

}  // namespace powbench::sim
