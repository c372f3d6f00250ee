#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/magnetics/potential.h"
#include "sim/mechanics/friction.h"
#include "sim/mechanics/unilateral.h"
#include "sim/models/solenoid/solenoid_specimen.h"
#include "sim/supply/supply_modes.h"

/// The solenoid as a system with modes for `EventIntegrator`. SI, + = closing direction, gap = travel - x.
///
///   states psi | x, v (plunger) | [v_c (capacitor across the coil)] | ledger: supplied, electric loss, mechanical
///   loss modes those of the supply (sim/supply) | each stop pressed or free | friction | the tap of the windings
///
///   n psi' = emf - (R + r) i,   i = (dW/dpsi) / n        n = 1, or (N + N_hold) / N with both windings in series
///   m v'   = dW/dgap - F_0 - k x - F_load + F_open - F_closed - friction,   x' = v
///
/// psi is the linkage of the coil's own turns, whatever is fed. Without a path for the current psi follows i = 0.

namespace powbench::sim {

struct SolenoidEvent {
  enum class Kind : std::uint8_t {
    seat,      ///< plunger touches the closed stop
    unseat,    ///< and leaves it
    start,     ///< plunger leaves the open stop
    back,      ///< and touches it
    coil_off,  ///< the source is cut off, or the current is
    tap        ///< the windings change over
  };
  Kind kind{};
  double time = 0;      ///< s
  double velocity = 0;  ///< m/s, magnitude
};

struct SolenoidSample {
  double time = 0;            ///< s
  double source_voltage = 0;  ///< V, ahead of the switch
  double coil_voltage = 0;    ///< V, at the terminals
  double current = 0;         ///< A, in the coil
  double flux_linkage = 0;    ///< Wb, of the coil's own turns
  double pull = 0;            ///< N
  double travel = 0;          ///< m
  double velocity = 0;        ///< m/s
  double stop_force = 0;      ///< N, of the closed stop
};

class SolenoidModel {
 public:
  static constexpr int capacity = 7;
  static constexpr int guard_capacity = 6;
  using State = std::array<double, capacity>;
  enum : int { psi, x, v, more };
  enum : int { closed_stop, open_stop, friction_guard, current_guard, clock_guard, tap_guard };

  /// `potential` must outlive this. Throws std::invalid_argument for a specimen or supply that cannot be.
  SolenoidModel(const SolenoidSpecimen&, const MagneticPotential&, const Supply&, double coil_kelvin);

  // The system, as EventIntegrator wants it.
  int size() const { return ledger_ + 3; }
  int guard_count() const { return guard_capacity; }
  double scale(int i) const { return scale_[static_cast<std::size_t>(i)]; }
  void derivative(double t, const double* s, double* ds) const;
  void guards(double t, const double* s, double* g) const;
  void flip(double t, double* s, std::uint64_t which);

  /// Plunger at the open stop, no current; the flux is that of the permanent magnet.
  State rest() const;
  void set_coil(double t, double* s, bool on);
  void sample(double t, const double* s, SolenoidSample& out) const;

  double supplied_energy(const double* s) const { return s[ledger_]; }
  /// |Supplied energy minus losses minus stored energy| over the largest of them, and of the pull's work at 1 mJ.
  double energy_residual(const double* s) const;

  const std::vector<SolenoidEvent>& events() const { return events_; }
  std::int64_t states() const { return states_; }  ///< of the potential, asked so far
  std::int64_t beyond() const { return beyond_; }  ///< of these, outside of what it was made from

 private:
  struct Forces {
    MagneticResponse field;
    double closed = 0, open = 0;  ///< N, of the stops
    double sum = 0;               ///< N, on the plunger, without friction
  };

  MagneticResponse field(const double* s) const;
  Forces forces(const double* s) const;
  double turns_ratio() const { return tapped_ ? hold_ratio_ : 1.0; }
  double resistance() const { return tapped_ ? hold_resistance_ : resistance_; }  ///< with the source, ohm
  double current(const double* s) const;                                          ///< A, 0 without a path
  double open_rate(const MagneticResponse&, double velocity) const;  ///< V, dpsi/dt without current
  double stored_energy(const double* s) const;
  void remove_current(double* s) const;
  void settle_supply(double* s, SupplyModes::Effect);
  void publish(SolenoidEvent::Kind kind, double t, double velocity) {
    events_.push_back({kind, t, velocity});
  }

  SolenoidSpecimen specimen_;
  std::shared_ptr<const MagneticPotential> with_source_;  ///< with the source's inductance; empty: none
  const MagneticPotential* potential_;
  SupplyModes supply_;
  double source_resistance_, resistance_, hold_resistance_, hold_ratio_;
  double open_depth_;  ///< m, of the open stop under the preload
  std::array<Unilateral, 2> stops_{};
  std::array<double, capacity> scale_{};
  int capacitor_ = -1;  ///< state of the suppression, -1: none
  int ledger_ = more;
  CoulombFriction<double> friction_;
  bool tapped_ = false;
  std::vector<SolenoidEvent> events_;
  double start_energy_ = 0;  ///< J, at rest
  mutable std::int64_t states_ = 0, beyond_ = 0;
};

}  // namespace powbench::sim
