#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/friction.h"
#include "sim/magnetic_circuit.h"
#include "sim/plant.h"
#include "sim/remanence.h"
#include "sim/unilateral.h"

/// The contactor as a system with modes for `EventIntegrator`. One data model:
///
///   states   phi, phi2 | x, v (core) | z, w (base) | per bridge group y, y' [, tilt, tilt'] | [b, b' (static core
///            on its buffer)] | [i_h (remanence)] | [v_c (capacitor across the coil)] | ledger: 4 energies
///   modes    those of the supply (sim/supply) | each contact pressed or free | friction
///   guards   one per contact, one for friction, one for the current, one for what the supply does at its time
///
/// Equations (SI, + = closing direction, s = travel - (x - b); b = z where the static core is part of the base):
///   N phi' + L i' = u - R i,   phi2' = -R_sh i_sh                     fluxes; with the coil open i = 0
///   with u and what is beside R from the path of the current (sim/supply)
///   with remanence u - R (i + i_h) there, and i = -i_h with the coil open (sim/remanence.h)
///   instead M x''   = pull - F_r0 - k_r x - sum n (F_c0 + k_c (x - y) - F_seat) + F_open - F_stop - friction
///   M_h z'' = -pull - k_h z - c_h z' + F_stop + sum n (F_A + F_B)
///             with a buffer F_b = k_s (b - z) + c_s (b' - z') in place of F_stop - pull, and
///   M_s b'' = -pull + F_stop - F_b
///   m y''   = F_c0 + k_c (x - y) - F_seat - F_A - F_B                   one bridge
///   J tilt''= -l (F_A - F_B) - l_s (F_seat1 - F_seat2)                  only where the breaks differ
/// Equal bridges are one group that counts n times; a group whose breaks are equal has no tilt.

namespace powbench::sim {

struct LaneBlock;
struct LaneLayout;

class ContactorModel {
 public:
  static constexpr int max_poles = 8;
  static constexpr int capacity = 6 + 4 * max_poles + 2 + 1 + 1 + 4;
  static constexpr int guard_capacity = 2 + 4 * max_poles + 3;
  using State = std::array<double, capacity>;

  enum : int { phi, phi2, x, v, z, w, first_group };

  ContactorModel(const Specimen&, const Mains&, const PlantOptions&);

  // The system, as EventIntegrator wants it.
  int size() const { return ledger_ + 4; }
  int guard_count() const { return contact_count_ + 3; }
  double scale(int i) const { return scale_[static_cast<std::size_t>(i)]; }
  void derivative(double t, const double* s, double* ds) const;
  void guards(double t, const double* s, double* g) const;
  double guard(int k, double t, const double* s) const;  ///< one of them
  void flip(double t, double* s, std::uint64_t which);

  /// Static equilibrium at the start: all displacements are zero, the flux is what the iron remembers.
  State rest() const { return rest(remanence_.start()); }
  /// The same with another offset of remanence, A.
  State rest(double offset) const;
  double offset(const double* s) const { return offset_ < 0 ? 0.0 : s[offset_]; }
  /// Back to the modes of the static equilibrium; those of the supply stay.
  void reset_modes();
  bool near_rest(const State&) const;

  const SupplyModes& supply() const { return supply_; }
  void set_coil(double t, double* s, bool on);

  double current(const double* s) const;        ///< A
  double stored_energy(const double* s) const;  ///< J, zero at rest
  double supplied_energy(const double* s) const { return s[ledger_]; }
  /// |Supplied energy minus losses minus stored energy| over the largest of them and of F_r0 times the travel.
  double energy_residual(const double* s) const;
  void book_loss(double* s, double joule) const { s[ledger_ + 3] += joule; }

  void sample(double t, const double* s, PlantSample& out) const;

  // For models that are integrated side by side (contactor_lanes.cpp).

  /// What must be alike in all lanes; false: nothing of lanes knows this model, in the modes it is in.
  bool lane_layout(LaneLayout&) const;
  void put_numbers(LaneBlock&, int lane) const;  ///< what stays
  void put_modes(LaneBlock&, int lane) const;    ///< what `flip` changes
  std::vector<PlantEvent>& events() { return events_; }

 private:
  /// Bridges that move alike. Contacts from `first_contact`: seat, both breaks - or seat 1, seat 2, break A,
  /// break B.
  struct Group {
    int state = 0;
    int first_contact = 0;
    double count = 1;
    double gap_a = 0;
    bool tilts = false;
  };
  /// Forces at one state.
  struct Forces {
    Field field;
    double pen[guard_capacity];   ///< of each contact, m; left unset beyond the contacts in use
    double rate[guard_capacity];  ///< m/s
    double contact[guard_capacity];
    double core;  ///< on the core, without friction
    double base;
    double static_core;  ///< only where it floats
  };

  void penetrations(const double* s, double* pen, double* rate) const;
  void forces(const double* s, Forces&) const;
  double core_force(const double* s) const;  ///< N, without friction
  double separation(const double* s) const { return specimen_.core.travel - (s[x] - s[static_core_]); }
  bool floats() const { return static_core_ != z; }
  double coil_current(const double* s) const;  ///< A, as if fed
  double mmf_stiffness(const Field&) const;    ///< d mmf / d phi, A/Wb, of what follows phi
  double current_rate(const Field&, double separation_rate, const double* flux_rates) const;  ///< A/s
  double second_flux(const double* s) const {
    return circuit_.has_ring() ? s[phi2] : circuit_.shaded_share() * s[phi];
  }
  /// Writes the rates of both fluxes; returns that of the flux linkage, V, which is known where there is remanence.
  double flux_rates(const Field&, double offset, const CoilFeed<double>&, double separation_rate,
                    double* ds) const;
  CoilFeed<double> feed(double t, const double* s, double current) const;
  double open_voltage(const double* s) const;  ///< V, at the coil without current
  double losses(const double* s, const Forces&) const;
  double coil_guard(double t, const double* s) const;
  void flip_contact(double t, int k, double rate);
  void flip_friction(double t, double* s);
  void settle_supply(double t, double* s, SupplyModes::Effect, double energy_before);
  void publish(PlantEvent::Kind, double t, double velocity);
  int add_contact(double stiffness, double damping);
  void add_groups();

  Specimen specimen_;
  SupplyModes supply_;
  Remanence remanence_;
  MagneticCircuit circuit_;
  double resistance_;  ///< coil, warm, with the source, ohm
  double source_resistance_;
  double inductance_;          ///< in series with the core: leakage and source, H
  double base_rate_;           ///< N/m
  double base_damping_;        ///< N s/m
  double buffer_rate_ = 0;     ///< N/m
  double buffer_damping_ = 0;  ///< N s/m
  int static_core_ = z;        ///< its state: displacement, velocity next to it
  double open_stop_depth_;
  double seat_depth_;
  std::vector<Group> groups_;
  std::array<Unilateral, guard_capacity> contacts_{};
  std::array<double, capacity> scale_{};
  int contact_count_ = 0;
  int offset_ = -1;     ///< state of the remanence, -1: none
  int capacitor_ = -1;  ///< state of the suppression, V, -1: none
  int ledger_ = 0;
  double start_energy_ = 0;  ///< J, of the remanence
  CoulombFriction<double> friction_;
  std::vector<PlantEvent> events_;
};

}  // namespace powbench::sim
