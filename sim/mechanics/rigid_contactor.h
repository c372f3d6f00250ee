#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/magnetics/circuit/remanence.h"
#include "sim/magnetics/potential.h"
#include "sim/mechanics/event_solver.h"
#include "sim/mechanics/rigid_lanes.h"
#include "sim/mechanics/rigid_parts.h"
#include "sim/supply/supply_modes.h"

/// The rigid contactor as a system for `EventSolver`:
///
///   M x''      = F_m - F_r0 - k_r x - c x' - friction + sum_j (S_j - f_j) - N_L - N_R + P_L + P_R
///   I tilt''   = sum_j z_j (S_j - f_j) + a (N_L - N_R + P_R - P_L) - k_t tilt - c_t tilt'
///   M_s x_s''  = -F_m + N_L + N_R - B [+ sum pads],   B = k_b (x_s - foot) + c_b (...)'
///   m_j y''    = f_j - S_j - F_1 - F_2,   f_j = F_c0 + k_c (x + z_j tilt - y) + c_c (...)'
///   J_j theta''= r (F_1 - F_2) + l (S_1 - S_2) - k_th theta
///   base mode  = modal force of the pads and of B; foot: where the buffer stands, at rest or on the base
///
/// with pads F, seats S, pole faces N and stops P by their contact laws. The depth of pad 2 grows with theta and that
/// of pad 1 shrinks, so the torque is the difference of the forces: a level bridge does not spin.

namespace powbench::sim {

enum class ContactKind : std::uint8_t { pad, seat, pole, stop };

/// Where a contact is: `part` is the bridge (0 for pole faces and stops), `end` 0 or 1.
struct ContactPlace {
  ContactKind kind{};
  int part = 0;
  int end = 0;
};

/// A contact begins to press, or its force ends. With a law that leaves a dent the latter is before the depth is zero.
struct RigidEvent {
  int contact = 0;  ///< index as in contact_place()
  bool closes = false;
  double time = 0;   ///< s
  double speed = 0;  ///< m/s, normal; small: the time is sensitive, dt = dx / speed
};

ContactPlace contact_place(int contact);

/// Coil and magnetics of a closing: du = R i + dpsi/dt with the potential of any rung.
struct CoilDrive {
  const MagneticPotential* potential = nullptr;  ///< nullptr: the pull is the given one
  double resistance = 0;                         ///< ohm, with the source
  double ring_resistance = 0;                    ///< ohm, one turn
  Supply supply;
  Remanence remanence;
  bool pressed_gap = false;  ///< the potential is also defined for gap < 0, faces pressed together
};

/// A voltage at the coil that somebody else states, in series with the mains: u(t) = sum of c_k (t - time)^k.
struct StatedVoltage {
  double time = 0;               ///< s
  std::array<double, 6> c = {};  ///< V, V/s, V/s2, ...
  double at(double t) const {
    double u = 0;
    for (std::size_t k = c.size(); k-- > 0;) u = u * (t - time) + c[k];
    return u;
  }
};

/// Where the energy is, J. Losses and supplies are integrals since t = 0.
struct EnergyLedger {
  double kinetic = 0, springs = 0, contacts = 0;
  double magnetic = 0;  ///< with the capacitor across the coil
  double supplied = 0;  ///< by the coil, or by the given pull
  /// `coil`: R i^2, what the iron's remanence and the suppression take, and what a current that was cut leaves.
  double coil = 0, ring = 0, contact_loss = 0, friction = 0, damping = 0;
  double stored() const { return kinetic + springs + contacts + magnetic; }
  double lost() const { return coil + ring + contact_loss + friction + damping; }
};

template <class R>
class RigidContactor {
 public:
  using Real = R;
  static constexpr int guard_capacity = 48;
  static constexpr int capacity = 2 * (3 + most_base_modes + 2 * most_bridges) + 3 + 1 + 8;
  using GuardSet = Guards<Real, guard_capacity>;
  enum : int {
    gap_guard = rigid_contacts,
    release_guard,
    regain_guard,
    friction_guard,
    coil_guard,
    clock_guard,  ///< what the supply does at its time
    guards_used
  };

  /// `ledger`: energies are states too. Throws std::invalid_argument for impossible parts.
  explicit RigidContactor(const RigidParts&, const CoilDrive& = {}, bool ledger = false);

  // as EventSolver wants it
  int size() const { return size_; }
  int guard_count() const { return guards_used; }
  int smooth_guards() const { return gap_guard + 1; }
  Real scale(int i) const;
  /// Returns what the magnet answers at y, nothing where the pull is given.
  MagneticResponse derivative(Real t, const Real* y, Real* dy) const;
  void guards(Real t, const Real* y, const Real* dy, GuardSet&) const;
  void flip(Real& t, Real* y, std::uint64_t which);
  Real guard(int k, Real t, const Real* y, Real& rate) const;
  /// Share of a step with these guards at its ends where a plain guard may be negative though it is not at the ends,
  /// 2 if nowhere: a contact that pulls F = k d^n + c d' to zero and presses again within the step, a core that turns
  /// back and on.
  Real dip(int k, const GuardSet& begin, const GuardSet& end, const StepEnds<Real>&) const;
  int choose_root(const GuardSet&, const Real* y, Real step, Real& root) const;
  void follow_root(int guard) { lanes_.followed = guard; }
  void set_root(Real root) { lanes_.root = root; }
  void tried(bool taken) const {
    if (drive_.potential != nullptr) drive_.potential->tried(taken);
  }
  Real depth_rate(const Real* y) const {
    return lanes_.followed < 0 ? Real(0) : lane_rate(lanes_.followed, y);
  }
  Real root_step(int guard, const Real* y) const;

  /// Static equilibrium without pull, by Newton, with the flux that the iron remembers; writes capacity values and sets
  /// the modes. Returns the largest acceleration left, m/s2. Throws std::runtime_error if there is none,
  /// std::invalid_argument where a pad or pole face already presses in it.
  double equilibrium(Real* y);

  /// Commands the coil's switch at time t.
  void set_coil(Real t, Real* y, bool on);

  /// What feeds the coil besides the mains, from now on, and the resistance of coil and source, ohm. An integrator
  /// that has stepped ahead starts anew.
  void state_feed(const StatedVoltage& voltage, double resistance) {
    stated_ = voltage;
    drive_.resistance = resistance;
  }
  /// The coil has a path for its current.
  bool conducts() const { return supply_.conducts(); }

  /// Lets the modes follow the depths, for integrators that know no modes.
  void follow_depths(bool on) { lanes_.automatic = on; }

  int dof() const { return lanes_.dof; }
  int bridges() const { return lanes_.bridges; }
  /// Contacts and bridges have the numbers of the parts as given. Inside, bridges sit in lanes in canonical order.
  bool uses(int contact) const { return used_ >> lane_of(contact) & 1U; }
  bool is_pressing(int contact) const { return pressing_ >> lane_of(contact) & 1U; }
  Real depth_of(int contact, const Real* y) const { return lane_depth(lane_of(contact), y); }
  Real force_of(int contact, const Real* y) const;
  /// Where the travel of a bridge stands in the states; its angle follows bridges() later.
  int bridge_state(int bridge) const { return 3 + lanes_.modes + lane_of(bridge); }
  /// Number, as given, of the contact that guards() and depths() know by a lane; and back.
  int number_of(int lane_contact) const;
  int lane_of(int contact) const;
  /// Depths by lane, five groups of eight.
  void depths(const Real* y, Lanes<Real>* d) const { rigid_depths(lanes_, y, Real(1), d); }
  Real separation(const Real* y) const { return travel_ - (y[0] - y[2]); }
  Real pull(Real t, const Real* y) const;
  Real current(const Real* y) const { return electric_ < 0 ? Real(0) : current(y, field(y)); }
  // of a response at y
  Real current(const Real* y, const MagneticResponse& m) const {
    return static_cast<Real>(m.current) + offset(y);
  }
  /// Wb, without the source's inductance.
  double coil_linkage(const Real* y, const MagneticResponse& m) const {
    return static_cast<double>(y[electric_]) - supply_.mains().inductance * m.current;
  }
  /// A/s, while the coil is fed.
  double current_rate(const Real* y, const Real* dy, const MagneticResponse& m) const;
  double mains(double t) const { return supply_.voltage_at(t); }
  EnergyLedger energies(const Real* y) const;
  /// |stored + lost - supplied - stored at equilibrium| over the largest of them and of F_r0 times the travel.
  double energy_residual(const Real* y) const;
  /// To be called once at the start: what the ledger compares with.
  void mark_energy(const Real* y) { start_energy_ = energies(y).stored(); }
  /// W by which friction drives the core: 0, or its mode is wrong.
  Real friction_gain(const Real* y) const { return std::max(-lanes_.friction.loss(y[lanes_.dof]), Real(0)); }
  double least_energy() const { return least_energy_; }  ///< J, F_r0 times the travel

  std::vector<RigidEvent>& events() { return events_; }
  const std::vector<RigidEvent>& events() const { return events_; }

 private:
  const ContactLaw& law_of(int group, int lane) const {
    return laws_[group + (group == core_group && lane >= 2)];
  }
  Real lane_depth(int lane_contact, const Real* y) const;
  Real lane_rate(int lane_contact, const Real* y) const;
  void set_contact(int group, int lane, const ContactLaw&, Real mass);
  void set_bridges(const RigidParts&);
  void set_core(const RigidParts&);
  void press(int contact, bool on);
  void flip_contact(Real t, const Real* y, int contact);
  void flip_detached(Real t, const Real* y, bool release);
  Real pressing_margin(int contact, const Real* y, Real rate) const;
  void plain_guards(Real t, const Real* y, const Real* dy, GuardSet&) const;
  Real core_force(Real t, const Real* y) const;
  void flip_supply(double t, Real* y, std::uint64_t which);
  void settle_supply(Real* y, SupplyModes::Effect, double energy_before);
  void magnetise(Real* y) const;
  Real offset(const Real* y) const { return offset_ < 0 ? Real(0) : y[offset_]; }
  CoilFeed<Real> feed(Real t, const Real* y, Real current) const;
  Real open_voltage(const Real* y, const MagneticResponse&, Real ring_rate) const;
  Real open_voltage(const Real* y) const;   ///< V, at the coil without current
  double fed_current(const Real* y) const;  ///< A, zero while the coil is not fed
  void electric(const Real* y, const MagneticResponse&, Real current, const CoilFeed<Real>&, Real* dy) const;
  void book(const Real* y, const MagneticResponse&, Real pull, Real current, const CoilFeed<Real>&,
            const Real* losses, Real* dy) const;
  MagneticResponse field(const Real* y) const;
  Real gap(const Real* y) const;

  RigidLanes<Real> lanes_{};
  std::array<int, most_bridges> number_{};  ///< of the bridge in each lane
  std::array<int, most_bridges> lane_{};    ///< of each bridge
  CoilDrive drive_;
  StatedVoltage stated_;
  GivenPull given_;
  ContactLaw laws_[rigid_groups + 1];       ///< pad, pad, seat, seat, pole, stop
  Lanes<Real> sign_[rigid_groups]{};        ///< 1 pressing or detached, -1 open, 0 idle
  Real masses_[rigid_groups][rigid_lanes];  ///< effective, of each contact
  Real bodies_[3 + most_base_modes + 2 * most_bridges];
  Real travel_ = 0;
  int size_ = 0;
  int electric_ = -1;   ///< first magnetic state
  int offset_ = -1;     ///< state of the remanence, -1: none
  int capacitor_ = -1;  ///< state of the suppression, V, -1: none
  int ledger_ = -1;
  std::uint64_t used_ = 0;
  std::uint64_t rooted_ = 0;  ///< contacts whose force has a root of the depth
  std::uint64_t pressing_ = 0;
  std::uint64_t detached_ = 0;
  bool touching_ = false;  ///< pole faces overlap in the middle: the magnetic gap stays zero
  SupplyModes supply_;
  std::shared_ptr<const MagneticPotential>
      with_source_;  ///< the coil's potential with the source's inductance
  double start_energy_ = 0;
  double least_energy_ = 1;  ///< J, return preload over the travel
  std::vector<RigidEvent> events_;
};

extern template class RigidContactor<double>;
extern template class RigidContactor<long double>;

}  // namespace powbench::sim
