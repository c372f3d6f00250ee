#pragma once

#include "sim/solid/contact_geometry.h"
#include "sim/solid/solid_contact.h"

/// One way of one pair: the nodes of `slave` against the faces of `master`. Private to solid_contact.cpp.

namespace powbench::sim {

/// Sums of one step and of the run.
struct ContactSums {
  double stored = 0;         ///< J, now
  double friction_lost = 0;  ///< J, so far
};

/// Of two springs one behind the other.
inline double series(double a, double b) {
  return a * b / (a + b);
}

/// What a node that touches remembers: the tangential force, and the area with which it touched first.
struct Anchor {
  Vec3 force;
  double area = 0;  ///< m2
  double zero = 0;  ///< m, depth that counts as none: a node that comes in from the side is not thrown out
  bool touching = false;
};

class ContactPass {
 public:
  ContactPass(const ContactPair&, const SolidSurface& slave, const SolidSurface& master,
              const std::vector<double>& inverse_mass);

  /// New candidates for nodes within half a face's size of it. Returns the smallest of these distances.
  double search(const NodeView&);
  /// Smallest gap (negative: depth) of all candidates; for the check at the start.
  double deepest(const NodeView&) const;
  /// Travel: how far any two nodes may have moved against each other since the start; nodes that are too far from the
  /// other part to have come to it are passed over.
  void set_travel(double travel) { travel_ = travel; }
  /// `sign`: +1 where the slave is part a of the pair, else -1; `start`: depths there now are meant.
  /// The damping forces are added to `forces` and, once more, to `damped`.
  void apply(const NodeView&, double dt, double sign, bool start, NodeForces& forces, NodeForces& damped,
             ContactSums&, ContactReport&);
  void add_stiffness(std::vector<double>&) const;
  void add_damping(std::vector<double>&) const;
  /// Adds the normal forces of the latest step over the areas, at the nodes of both sides, Pa.
  void add_pressure(std::vector<double>&) const;

  std::vector<Anchor> anchors;

 private:
  struct Touch {
    int facet = -1;
    double away = 0;  ///< m, while it does not touch: a lower bound of the distance
    double depth = 0;
    Vec3 normal;
    std::array<double, 4> weights{};
  };

  struct Pressed {
    std::size_t slave = 0;
    int facet = 0;
    std::array<double, 4> weights{};
    double force = 0;
  };

  bool flat_around(const Facet&, const std::vector<Vec3>& normals) const;
  Touch nearest(std::size_t active, const NodeView&) const;
  bool behind_all(const NodeView&, const Facet&, const Projection&) const;
  double stiffness(std::size_t slave, double area) const;
  double damping(std::size_t slave, double area) const;
  double sticking(std::size_t slave, double area) const;
  void spread(const Touch&, int node, const Vec3& force, NodeForces&) const;
  Vec3 friction(std::size_t slave, const Touch&, const Vec3& slip, double dt, double normal_force,
                ContactSums&, Vec3& damped);

  const ContactPair* pair_;
  const SolidSurface *slave_, *master_;
  const std::vector<double>* inverse_mass_;
  double master_stiffness_ = 0, depth_limit_ = 0;
  double travel_ = 0;
  std::vector<Pressed> pressed_;
  std::vector<char> flat_;      ///< faces whose neighbours lie in one plane with them
  std::vector<double> asleep_;  ///< m, of each active slave: travel before which it cannot touch
  std::vector<int> active_;     ///< slaves with candidates, by place in slave_->nodes
  std::vector<std::vector<std::pair<int, bool>>> near_;  ///< their facets; true: squarely opposite
};

}  // namespace powbench::sim
