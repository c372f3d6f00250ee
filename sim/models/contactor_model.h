#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/circuit/remanence.h"
#include "sim/mechanics/friction.h"
#include "sim/models/contactor_equations.h"
#include "sim/models/plant.h"

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
///   with remanence u - R (i + i_h) there, and i = -i_h with the coil open (sim/magnetics/circuit/remanence.h)
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

class ContactorModel : ContactorLayout {
 public:
  using ContactorLayout::phi, ContactorLayout::phi2, ContactorLayout::x, ContactorLayout::v,
      ContactorLayout::z, ContactorLayout::w, ContactorLayout::first_group, ContactorLayout::max_poles;
  static constexpr int capacity = 6 + 4 * max_poles + 2 + 1 + 1 + 4;
  static constexpr int guard_capacity = max_contacts + 3;
  using State = std::array<double, capacity>;

  ContactorModel(const Specimen&, const Mains&, const PlantOptions&);

  // The system, as EventIntegrator wants it.
  int size() const { return ledger + 4; }
  int guard_count() const { return contacts + 3; }
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
  double supplied_energy(const double* s) const { return s[ledger]; }
  /// |Supplied energy minus losses minus stored energy| over the largest of them and of F_r0 times the travel.
  double energy_residual(const double* s) const;
  void book_loss(double* s, double joule) const { s[ledger + 3] += joule; }

  void sample(double t, const double* s, PlantSample& out) const;

  // For models that are integrated side by side (contactor_lanes.cpp).

  /// What must be alike in all lanes; false: nothing of lanes knows this model, in the modes it is in.
  bool lane_layout(LaneLayout&) const;
  void put_numbers(LaneBlock&, int lane) const;  ///< what stays
  void put_modes(LaneBlock&, int lane) const;    ///< what `flip` changes
  std::vector<PlantEvent>& events() { return events_; }

 private:
  /// What the equations ask of this model.
  struct Alone : OneNumber {
    const ContactorModel& m;
    const ContactorLayout& layout;
    const ContactorNumbers<double>& numbers;
    explicit Alone(const ContactorModel& model) : m(model), layout(model), numbers(model.n_) {}
    POWBENCH_EQUATION bool pressed(int k) const { return m.contacts_[static_cast<std::size_t>(k)].pressed; }
    POWBENCH_EQUATION double friction_net(double driving) const { return m.friction_.net(driving); }
    POWBENCH_EQUATION double friction_loss(double speed) const { return m.friction_.loss(speed); }
    POWBENCH_EQUATION IronOf<OneNumber> iron(double b) const { return m.circuit_.iron(b); }
  };
  using Equations = ContactorEquations<Alone>;
  using Forces = Equations::Forces;

  void penetrations(const double* s, double* pen, double* rate) const;
  void forces(const double* s, Forces&) const;
  double core_force(const double* s) const;  ///< N, without friction
  Field field(const double* s) const;
  double coil_current(const double* s) const;  ///< A, as if fed
  double current_rate(const Field&, double separation_rate, const double* flux_rates) const;  ///< A/s
  /// Writes the rates of both fluxes; returns that of the flux linkage, V, which is known where there is remanence.
  double flux_rates(const Field&, const double* s, const CoilFeed<double>&, double* ds) const;
  CoilFeed<double> feed(double t, const double* s, double current) const;
  double open_voltage(const double* s) const;  ///< V, at the coil without current
  double coil_guard(double t, const double* s) const;
  void flip_contact(double t, int k, double rate);
  void flip_friction(double t, double* s);
  void settle_supply(double t, double* s, SupplyModes::Effect, double energy_before);
  void publish(PlantEvent::Kind, double t, double velocity);
  int add_contact(double stiffness, double damping);
  void add_groups();
  void set_numbers(const Mains&, double coil_kelvin);

  Specimen specimen_;
  SupplyModes supply_;
  Remanence remanence_;
  MagneticCircuit circuit_;
  double source_resistance_;
  ContactorNumbers<double> n_{};
  std::array<Unilateral, guard_capacity> contacts_{};
  std::array<double, capacity> scale_{};
  int offset_ = -1;          ///< state of the remanence, -1: none
  int capacitor_ = -1;       ///< state of the suppression, V, -1: none
  double start_energy_ = 0;  ///< J, of the remanence
  CoulombFriction<double> friction_;
  std::vector<PlantEvent> events_;
};

}  // namespace powbench::sim
