#pragma once

#include <vector>

#include "sim/solid/node_forces.h"

/// What acts on solid bodies besides other bodies: forces, springs, rigid planes.

namespace powbench::sim {

/// A force spread over nodes; the shares add up to 1.
struct NodeShares {
  std::vector<int> nodes;
  std::vector<double> shares;
};

struct SolidLoad {
  NodeShares on;
  Vec3 force;  ///< N; may change from step to step
};

/// Between the means of two groups of nodes, along one axis: stretch s = (mean u_a - mean u_b) . axis, force on a
/// -(preload + rate s) axis, the opposite on b. Without b the other end stands still.
struct SolidSpring {
  NodeShares a, b;
  Vec3 axis{0, 0, 1};  ///< of unit length
  double preload = 0;  ///< N, at s = 0
  double rate = 0;     ///< N/m
};

/// A rigid plane that nodes do not pass: force k depth + c d depth/dt >= 0 along the normal while the depth is
/// positive.
struct SolidPlane {
  Vec3 point, normal{0, 0, 1};    ///< normal of unit length, out of the solid half space
  std::vector<int> nodes;         ///< that can touch
  std::vector<double> stiffness;  ///< N/m, of each
  std::vector<double> damping;    ///< N s/m, of each; empty: none
};

/// Mean of a nodal field (4 numbers a node) over a group.
Vec3 mean(const NodeShares&, const double* field);

/// Adds the forces of all, those of damping once more to `damped`; returns what springs and planes store, J.
double apply_loads(const std::vector<SolidLoad>&, const std::vector<SolidSpring>&,
                   const std::vector<SolidPlane>&, const NodeView&, NodeForces&, NodeForces& damped,
                   double* plane_force);

}  // namespace powbench::sim
