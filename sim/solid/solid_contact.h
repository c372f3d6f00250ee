#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "sim/solid/node_forces.h"
#include "sim/solid/solid_surface.h"

/// Contact between parts by symmetric penalty: the nodes of each part against the faces of the other, both ways, and
/// sharp edges against sharp edges. A node touches another part at most once, at the nearest point of its skin, so
/// that a corner over a shared edge is not counted twice.
///
///   normal:      F = k l + c dl/dt >= 0, l >= 0 the depth; each way with k = factor s A, s = s_a s_b / (s_a + s_b),
///                s = wave modulus / cell height, A the node's share of its part's skin; or with k = layer A / 2
///   tangential:  trial f* = f - k de; f = f* while |f*| <= F_y, else F_y f* / |f*|;  F_y = min(mu F, kappa A)
///   friction:    mu(v) = mu_d + (mu_s - mu_d) exp(-c |v|), between mu_s at rest and mu_d at speed

namespace powbench::sim {

class CellBatches;

struct ContactPair {
  int a = 0, b = 0;  ///< parts
  double friction_static = 0, friction_dynamic = 0;
  double decay = 0;                                              ///< c, s/m
  double shear_limit = std::numeric_limits<double>::infinity();  ///< kappa, Pa
  /// Of the penalty, > 0. A third puts two equal cells on the same footing as a cell on a rigid plane with 0.65, where
  /// the rebound keeps its energy best (docs/bench/solid_accuracy.txt).
  double factor = 1.0 / 3;
  double damping = 0;  ///< ratio of the critical one of node and penalty, pressing only
  /// A layer between level faces in place of the cells' penalty, the same on every mesh; 0: none.
  double layer = 0;          ///< Pa/m, stiffness over area, both ways together
  double layer_damping = 0;  ///< Pa s/m, damping over area, both ways together, pressing only
  double stick_damping = 0;  ///< the same, tangential, while sticking
};

struct ContactOptions {
  std::vector<ContactPair> pairs;
  bool edges = true;
  double allowed_overlap = 1e-9;  ///< m, at the start; more is refused
  bool pressures = false;         ///< node_pressure() will be asked
  bool exhaustive = false;  ///< every node looks at every face in every step: slow, what tests compare with
};

/// Coefficient of friction at a sliding speed, m/s.
double friction_coefficient(const ContactPair&, double speed);

/// What one pair does now.
struct ContactReport {
  Vec3 force;            ///< N, on part a
  double force_sum = 0;  ///< N, magnitudes of the normal forces
  double area = 0;       ///< m2, of the pressing nodes of a
  int touching = 0;      ///< nodes, both ways, and edge pairs
};

class SolidContact {
 public:
  /// Throws std::invalid_argument for parts that are not there, values out of range, and parts that overlap at the
  /// start (naming both and the depth).
  SolidContact(const CellBatches&, const std::vector<double>& inverse_mass, const ContactOptions&);
  ~SolidContact();

  /// Adds the forces of this step; `dt` led here (friction moves on by it).
  /// Damping forces are among `forces` and alone in `damped`; whoever moves the nodes books their work.
  void apply(const NodeView&, double dt, NodeForces& forces, NodeForces& damped);

  double stored() const;         ///< J, normal and tangential
  double friction_lost() const;  ///< J, so far
  const ContactReport& report(int pair) const;
  /// Pa, at every node of the mesh: normal force over area, latest step. Only with `pressures`, else all 0.
  std::vector<double> node_pressure() const;

  /// Penalty stiffness that can act on each node when everything touches, N/m.
  std::vector<double> stiffness() const;
  std::vector<double> damping() const;  ///< N s/m, of the same state
  long searches() const;

  /// Friction anchors, work booked; bit-equal continuation after restore.
  std::vector<double> memory() const;
  void restore_memory(const std::vector<double>&);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::sim
