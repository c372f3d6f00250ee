#pragma once

#include <array>

#include "sim/magnetics/circuit/circuit_equations.h"
#include "sim/mechanics/unilateral.h"

/// The equations of contactor_model.h, for one contactor (Of::Number = double) and for several side by side (a vector):
/// the same operations in the same order, so the same bits.

namespace powbench::sim {

/// What is a contactor's shape: alike in all lanes.
struct ContactorLayout {
  static constexpr int max_poles = 8;
  static constexpr int max_contacts = 2 + 4 * max_poles;
  enum : int { phi, phi2, x, v, z, w, first_group };
  /// Bridges that move alike. Contacts from `first_contact`: seat, both breaks - or seat 1, seat 2, break A, break B.
  struct Group {
    int state = 0, first_contact = 0;
    bool tilts = false;
    bool operator==(const Group&) const = default;
  };
  int ledger = 0, contacts = 0, groups = 0;
  int static_core = z;  ///< its state: displacement, velocity next to it
  bool has_ring = false;
  std::array<Group, max_poles> group{};
  bool operator==(const ContactorLayout&) const = default;
  bool floats() const { return static_core != z; }
};

/// Its numbers, SI, with the names of the specimen. Every member is of type N, which contactor_lanes.cpp relies on.
template <class N>
struct ContactorNumbers {
  CircuitNumbers<N> circuit;
  N turns, resistance, inductance;  ///< coil, warm, with the source; leakage and source
  N inductance_per_turn;
  N travel, return_preload, return_rate, core_mass;
  N base_mass, base_rate, base_damping, static_mass, buffer_rate, buffer_damping;
  N open_stop_depth, seat_depth, preload, rate, bridge_mass, inertia, half_length, seat_half_length, tilt_gap;
  std::array<N, ContactorLayout::max_poles> gap, count;  ///< of each group
  std::array<N, ContactorLayout::max_contacts> stiffness, damping, damping_time;
};

/// `Of` tells what OneNumber does and, of its contactors, `layout`, `numbers`, the modes `pressed(k)`,
/// `friction_net(driving)` and `friction_loss(speed)`, and the `iron(flux density)`.
template <class Of>
struct ContactorEquations : ContactorLayout {
  using T = typename Of::Number;
  using Basis = typename Of::Basis;
  struct Forces {
    FieldOf<Basis> field;
    T pen[max_contacts];   ///< of each contact, m; left unset beyond the contacts in use
    T rate[max_contacts];  ///< m/s
    T contact[max_contacts];
    T core;  ///< on the core, without friction
    T base;
    T static_core;  ///< only where it floats
  };

  static POWBENCH_EQUATION T at(const typename Of::Stored& stored) { return Of::at(stored); }

  static POWBENCH_EQUATION T separation(const Of& of, const T* s) {
    return at(of.numbers.travel) - (s[x] - s[of.layout.static_core]);
  }
  static POWBENCH_EQUATION T second_flux(const Of& of, const T* s) {
    return of.layout.has_ring ? s[phi2] : at(of.numbers.circuit.share) * s[phi];
  }

  static POWBENCH_EQUATION FieldOf<Basis> field(const Of& of, const T* s) {
    const auto& n = of.numbers.circuit;
    return circuit_field<Basis>(n, reluctance<Basis>(n, separation(of, s)), of.iron(s[phi] / at(n.area)),
                                s[phi], second_flux(of, s));
  }

  static POWBENCH_EQUATION void penetrations(const Of& of, const T* s, T* pen, T* rate) {
    const auto& n = of.numbers;
    pen[0] = -separation(of, s);
    rate[0] = s[v] - s[of.layout.static_core + 1];
    pen[1] = at(n.open_stop_depth) - s[x];
    rate[1] = -s[v];
    for (int i = 0; i < of.layout.groups; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Group& g = of.layout.group[k];
      const T* q = s + g.state;
      T* p = pen + g.first_contact;
      T* r = rate + g.first_contact;
      const T seat = at(n.seat_depth) + q[0] - s[x], seat_rate = q[1] - s[v];
      const T contact = q[0] - s[z] - at(n.gap[k]), contact_rate = q[1] - s[w];
      if (!g.tilts) {
        p[0] = seat, r[0] = seat_rate;
        p[1] = contact, r[1] = contact_rate;
        continue;
      }
      const T half = at(n.half_length), seat_half = at(n.seat_half_length);
      p[0] = seat + seat_half * q[2], r[0] = seat_rate + seat_half * q[3];
      p[1] = seat - seat_half * q[2], r[1] = seat_rate - seat_half * q[3];
      p[2] = contact + half * q[2], r[2] = contact_rate + half * q[3];
      p[3] = contact - half * q[2] - at(n.tilt_gap), r[3] = contact_rate - half * q[3];
    }
  }

  static POWBENCH_EQUATION T spring(const Of& of, const T* s, const Group& g) {
    return at(of.numbers.preload) + at(of.numbers.rate) * (s[x] - s[g.state]);
  }

  static POWBENCH_EQUATION void forces(const Of& of, const T* s, Forces& f) {
    penetrations(of, s, f.pen, f.rate);
    forces_of(of, s, f);
  }
  /// Where the penetrations are there already.
  static POWBENCH_EQUATION void forces_of(const Of& of, const T* s, Forces& f) {
    const auto& n = of.numbers;
    const int sc = of.layout.static_core;
    f.field = field(of, s);
    for (int k = 0; k < of.layout.contacts; ++k) {
      const auto j = static_cast<std::size_t>(k);
      f.contact[k] =
          contact_force<Of>(of.pressed(k), at(n.stiffness[j]), at(n.damping[j]), f.pen[k], f.rate[k]);
    }
    f.core = f.field.pull - at(n.return_preload) - at(n.return_rate) * s[x] + f.contact[1] - f.contact[0];
    const T on_static_core = f.contact[0] - f.field.pull;
    const T buffer = of.layout.floats()
                         ? at(n.buffer_rate) * (s[sc] - s[z]) + at(n.buffer_damping) * (s[sc + 1] - s[w])
                         : on_static_core;
    f.static_core = on_static_core - buffer;
    f.base = buffer - at(n.base_rate) * s[z] - at(n.base_damping) * s[w];
    for (int i = 0; i < of.layout.groups; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Group& g = of.layout.group[k];
      const T* c = f.contact + g.first_contact;
      f.core += at(n.count[k]) * ((g.tilts ? c[0] + c[1] : c[0]) - spring(of, s, g));
      f.base += at(n.count[k]) * (g.tilts ? c[2] + c[3] : c[1]);
    }
  }

  static POWBENCH_EQUATION T losses(const Of& of, const T* s, const Forces& f) {
    const auto& n = of.numbers;
    const auto lost = [&](int k) {
      return contact_loss<Of>(at(n.stiffness[static_cast<std::size_t>(k)]), f.pen[k], f.rate[k],
                              f.contact[k]);
    };
    T sum = of.friction_loss(s[v]) + at(n.base_damping) * s[w] * s[w];
    sum += lost(0) + lost(1);
    if (of.layout.floats()) {
      const T rate = s[of.layout.static_core + 1] - s[w];
      sum += at(n.buffer_damping) * rate * rate;
    }
    for (int i = 0; i < of.layout.groups; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Group& g = of.layout.group[k];
      for (int j = 0; j < (g.tilts ? 4 : 2); ++j) sum += at(n.count[k]) * lost(g.first_contact + j);
    }
    return sum;
  }

  static POWBENCH_EQUATION T ring_rate(const Of& of, const FieldOf<Basis>& f) {
    return of.layout.has_ring ? -at(of.numbers.circuit.ring_resistance) * f.ring_current : Of::all(0.0);
  }
  /// d mmf / d phi, A/Wb, of what follows phi.
  static POWBENCH_EQUATION T mmf_stiffness(const Of& of, const FieldOf<Basis>& f) {
    return of.layout.has_ring ? f.mmf_phi : f.mmf_phi + at(of.numbers.circuit.share) * f.mmf_phi2;
  }
  /// Of the mmf, A/s, but for what the main flux changes.
  static POWBENCH_EQUATION T other_rate(const Of& of, const FieldOf<Basis>& f, T second_rate, const T* s) {
    return f.mmf_phi2 * second_rate + f.mmf_separation * (s[of.layout.static_core + 1] - s[v]);
  }
  /// Of the main flux, Wb/s, of a coil that conducts.
  static POWBENCH_EQUATION T first_rate(const Of& of, const FieldOf<Basis>& f, T linkage_rate, T other) {
    const auto& n = of.numbers;
    const T ratio = at(n.inductance_per_turn);  // L di = ratio d mmf
    return (linkage_rate - ratio * other) / (at(n.turns) + ratio * mmf_stiffness(of, f));
  }

  /// Of all but the fluxes and what the coil books.
  static POWBENCH_EQUATION void rates(const Of& of, const T* s, const Forces& f, T* ds) {
    const auto& n = of.numbers;
    ds[x] = s[v];
    ds[v] = of.friction_net(f.core) / at(n.core_mass);
    ds[z] = s[w];
    ds[w] = f.base / at(n.base_mass);
    if (of.layout.floats()) {
      const int sc = of.layout.static_core;
      ds[sc] = s[sc + 1];
      ds[sc + 1] = f.static_core / at(n.static_mass);
    }
    for (int i = 0; i < of.layout.groups; ++i) {
      const Group& g = of.layout.group[static_cast<std::size_t>(i)];
      const T* q = s + g.state;
      T* dq = ds + g.state;
      const T* c = f.contact + g.first_contact;
      dq[0] = q[1];
      if (!g.tilts) {
        dq[1] = (spring(of, s, g) - c[0] - c[1]) / at(n.bridge_mass);
        continue;
      }
      dq[1] = (spring(of, s, g) - c[0] - c[1] - c[2] - c[3]) / at(n.bridge_mass);
      dq[2] = q[3];
      dq[3] = -(at(n.half_length) * (c[2] - c[3]) + at(n.seat_half_length) * (c[0] - c[1])) / at(n.inertia);
    }
    T* ledger = ds + of.layout.ledger;
    const T ring = f.field.ring_current;
    ledger[2] = of.layout.has_ring ? at(n.circuit.ring_resistance) * ring * ring : Of::all(0.0);
    ledger[3] = losses(of, s, f);
  }

  static POWBENCH_EQUATION T contact_guard_at(const Of& of, int k, T pen, T rate) {
    return contact_guard<Of>(of.pressed(k), at(of.numbers.damping_time[static_cast<std::size_t>(k)]), pen,
                             rate);
  }
};

}  // namespace powbench::sim
