#pragma once

#include <vector>

#include "sim/solid/solid_loads.h"
#include "sim/solid/solid_material.h"
#include "sim/solid/solid_mesh.h"

/// A flexible body reduced to few coordinates, u = sum of q_r phi_r, from its finite elements:
///
///   six rigid modes, the lowest elastic modes of K phi = omega^2 M phi, and for every place where a force acts the
///   shape (K + s M)^-1 f that it bends statically (attachment modes: without them the compliance at the place is
///   missing).
///
/// The set is then made orthogonal by a small eigenvalue problem, so modal masses are 1 and stiffnesses omega^2: an
/// explicit method needs no solution of equations. Small displacements and rotations.

namespace powbench::sim {

struct ModalBody {
  int nodes = 0;
  std::vector<double> omega;   ///< rad/s, ascending; the first six are 0
  std::vector<double> shapes;  ///< kg^-1/2, mode r at node n, axis i: shapes[(r nodes + n) 3 + i]
  double lowest_elastic = 0;   ///< rad/s

  int modes() const { return static_cast<int>(omega.size()); }
  Vec3 shape(int mode, int node) const {
    const double* p = shapes.data() + 3 * (static_cast<std::size_t>(mode) * static_cast<std::size_t>(nodes) +
                                           static_cast<std::size_t>(node));
    return {p[0], p[1], p[2]};
  }
};

/// A place and direction of a force that gets an attachment mode.
struct Attachment {
  NodeShares at;
  Vec3 direction{0, 0, 1};
};

/// Reduces a mesh of one part. `modes`: elastic ones to keep, >= 0. Throws std::invalid_argument for bad meshes and
/// materials, meshes of several parts, and more modes than the mesh has.
ModalBody reduce(const SolidMesh&, const SolidMaterial&, int modes, const std::vector<Attachment>&);

/// A reduced body in motion against rigid planes: q'' + omega^2 q = phi . f by the central difference.
class ModalMotion {
 public:
  /// `dt` in s, 0: 0.2 of the critical step of modes and planes.
  ModalMotion(const ModalBody&, const SolidMesh&, const std::vector<SolidPlane>&, double dt = 0);

  void set_velocity(const Vec3&);  ///< of the whole body
  void step();
  double time() const { return time_; }
  double dt() const { return dt_; }
  double plane_force() const { return force_; }  ///< N, of the latest step
  Vec3 displacement(int node) const;

 private:
  const ModalBody* body_;
  const SolidMesh* mesh_;
  std::vector<SolidPlane> planes_;
  std::vector<double> q_, v_;
  double time_ = 0, dt_ = 0, force_ = 0;
};

}  // namespace powbench::sim
