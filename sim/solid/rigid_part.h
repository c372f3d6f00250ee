#pragma once

#include <array>

#include "sim/solid/node_forces.h"

/// A part that moves without deforming further, while nothing hits it. Its shape is kept as it was when it was frozen.

namespace powbench::sim {

struct RigidPart {
  int first = 0, last = 0;  ///< nodes
  bool held = false;        ///< has fixed nodes: stands still
  double mass = 0;          ///< kg
  Vec3 centre, velocity;    ///< m, m/s
  Vec3 momentum;            ///< kg m2/s, angular, about the centre
  std::array<Vec3, 3> turn{Vec3{1, 0, 0}, Vec3{0, 1, 0},
                           Vec3{0, 0, 1}};  ///< rows of the rotation since frozen
  std::array<Vec3, 3> inertia{};            ///< kg m2, when frozen
  std::vector<Vec3> arm;                    ///< m, of each node from the centre, when frozen

  double kinetic() const;  ///< J
  /// J, between this state and another half a step on either side: v m v' / 2, with which the balance of a spring
  /// closes.
  double kinetic_between(const RigidPart&) const;
  Vec3 spin() const;  ///< rad/s
};

/// Freezes nodes first .. last - 1 with their momentum and angular momentum.
RigidPart freeze(int first, int last, bool held, const NodeView&, const std::vector<double>& masses);

/// One step dt under the forces on its nodes (velocities are half a step behind the places); `drift` is the dt of the
/// place. Writes u and v of its nodes.
void advance(RigidPart&, const NodeForces&, const std::vector<Vec3>& reference, double dt, double drift,
             double* u, double* v);

}  // namespace powbench::sim
