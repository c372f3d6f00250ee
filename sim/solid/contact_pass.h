#pragma once

#include "sim/solid/nearest_faces.h"
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
  ContactPass(const ContactPair&, const NearSurface& slave, const NearSurface& master,
              const std::vector<double>& inverse_mass);

  /// New candidates for the nodes within reach (nearest_faces.h).
  double search(const NodeView& view, bool every);
  /// Smallest gap (negative: depth) of all candidates; for the check at the start.
  double deepest(const NodeView&);
  /// `sign`: +1 where the slave is part a of the pair, else -1; `start`: depths there now are meant. `travel`: how far
  /// any two nodes of both parts may have moved against each other in all; nodes that are too far from the other part
  /// to have come to it are passed over.
  /// The damping forces are added to `forces` and, once more, to `damped`.
  void apply(const NodeView&, double dt, double sign, bool start, double travel, NodeForces& forces,
             NodeForces& damped, ContactSums&, ContactReport&);
  void add_stiffness(std::vector<double>&) const;
  void add_damping(std::vector<double>&) const;
  /// Adds the normal forces of the latest step over the areas, at the nodes of both sides, Pa.
  void add_pressure(std::vector<double>&) const;

  std::vector<Anchor> anchors;
  bool keeps_pressed = false;  ///< for add_pressure

 private:
  double stiffness(std::size_t slave, double area) const { return penalty_[slave] * area; }
  double damping(std::size_t slave, double area) const;
  double sticking(std::size_t slave, double area) const;
  void release(std::size_t slave, ContactSums&);
  Anchor fresh_anchor(const NodeView&, std::size_t slave, const Touch&, double dt, bool start) const;
  void take_in(const NodeView&, std::size_t slave, const Touch&, double dt, bool start);
  void flush(const NodeView&, double dt, double sign, NodeForces& forces, NodeForces& damped, ContactSums&,
             ContactReport&);
  void weigh(std::size_t lane);
  void press(std::size_t lane, double sign, NodeForces& forces, NodeForces& damped, ContactSums&,
             ContactReport&);

  /// A node that touches, in a lane of the block that is being filled.
  struct Entry {
    std::size_t slave = 0;
    int facet = 0;
    double depth = 0;  ///< m, beyond the one that counts as none
    bool slides = false;
  };

  struct Pressed {
    std::size_t slave = 0;
    int facet = 0;
    std::array<double, 4> weights{};
    double force = 0;
  };

  const ContactPair* pair_;
  const SolidSurface *slave_, *master_;
  const std::vector<double>* inverse_mass_;
  const ContactKernel* kernel_;
  NearestFaces faces_;
  double master_stiffness_ = 0;
  bool rubs_ = false, damps_ = false;
  std::vector<double> penalty_;  ///< Pa/m, of each slave
  std::array<Entry, contact_lanes> block_;
  PressedNodes lanes_{};  ///< the numbers of block_
  std::size_t filled_ = 0;
  std::vector<Pressed> pressed_;  ///< of the latest step
  std::vector<double> asleep_;    ///< m, of each active slave: travel before which it cannot touch
  std::vector<int> awake_;
  std::vector<std::size_t> lost_;  ///< slaves that touched when a search left them without candidates
};

}  // namespace powbench::sim
