#pragma once

#include <array>
#include <vector>

#include "sim/mechanics/rigid_parts.h"
#include "sim/solid/modal_parts.h"

/// The bodies of the modal rung: coordinates, contacts and forces. Used by `modal_closing` alone.

namespace powbench::sim {

class ModalContactor {
 public:
  /// A contact between two places; depth = sum of its terms - clearance.
  struct Contact {
    int first = 0, count = 0;  ///< its terms
    double clearance = 0;      ///< m
    double stiffness = 0, damping = 0;
    double depth = 0, rate = 0, force = 0;  ///< of the latest forces()
  };
  enum : int { core, base, first_bridge };

  ModalContactor(const RigidParts&, const ModalParts&, double damping);

  int size() const { return static_cast<int>(mass_.size()); }
  double mass(int k) const { return mass_[static_cast<std::size_t>(k)]; }
  /// Generalised forces without friction, at coordinates `u` and rates `v`, under a pull; also sets the contacts.
  void forces(const double* u, const double* v, double pull, double* f);

  /// Coordinates at rest without pull, by Newton.
  std::vector<double> equilibrium();

  double critical_step() const;                           ///< s
  double stored(const double* u, const double* v) const;  ///< J, after forces(u, v)
  double loss(const double* v) const;                     ///< W, likewise, without friction
  const Contact& pad(int end) const { return contacts_[pad_ + static_cast<std::size_t>(end)]; }
  const Contact& pole() const { return contacts_[0]; }
  double friction() const { return parts_.core_friction; }
  double separation(const double* u) const { return parts_.travel - (u[core] - u[base]); }

 private:
  /// coordinate, weight
  struct Term {
    int coordinate;
    double weight;
  };
  struct Spring {
    int first = 0, count = 0;
    double preload = 0, rate = 0;
  };
  /// Terms of a place: rigid ones and elastic shapes, times a sign.
  void place(std::vector<Term>&, std::vector<Term> rigid, const ElasticPart&, int first, int at, double sign);
  int add_terms(const std::vector<Term>&);
  void add_contact(const std::vector<Term>&, double clearance, double stiffness, double damping);
  double sum(int first, int count, const double* u) const;
  void spread(int first, int count, double force, double* f) const;

  RigidParts parts_;
  double zeta_;
  std::vector<double> mass_, square_, drag_;  ///< by coordinate: kg or kg m2, stiffness, damping on the frame
  std::vector<Term> terms_;
  std::vector<Contact> contacts_;
  std::vector<Spring> springs_;
  std::size_t pad_ = 0;
};

}  // namespace powbench::sim
