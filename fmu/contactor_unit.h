#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/mechanics/event_solver.h"
#include "sim/mechanics/rigid_contactor.h"
#include "sim/specimen/specimen.h"
#include "sim/specimen/specimen_potential.h"

/// A contactor that somebody else's simulation drives: rigid bodies and magnetic circuit, as the native simulation has
/// them, with a coil voltage from outside. Two ways: advance() integrates with located events, or the states, their
/// derivatives and the event indicators are handed out. SI.

namespace powbench::fmu {

inline constexpr int most_poles = sim::most_bridges;

/// Fixed before the start.
struct UnitSettings {
  sim::Specimen specimen;
  double source_volts = 0;   ///< V rms of a sine in series with the coil voltage; 0: none
  double source_hertz = 50;  ///< Hz
  double source_phase = 0;   ///< rad at t = 0
  double tolerance = 1e-8;   ///< of the integrator, per state scale
};

/// Throws std::invalid_argument naming what is out of range.
void require_valid(const UnitSettings&);

struct UnitInput {
  std::array<double, 6> volts = {};  ///< coil voltage and its first five derivatives by time, V, V/s, ...
  double kelvin = 293.15;            ///< K, of the coil
  bool closed = true;                ///< the coil circuit; opened, the current ends at its next zero
  bool operator==(const UnitInput&) const = default;
};

/// What has happened to the contacts so far. Times in s, -1 before the first one.
struct UnitFacts {
  std::array<bool, most_poles> closed = {};        ///< both breaks of the pole
  std::array<double, most_poles> touch_time = {};  ///< both breaks closed for the first time
  bool seated = false;                             ///< the core presses on the static core
  double seat_time = -1;
};

struct PoleOutput {
  double travel = 0;   ///< m, of the bridge from rest
  double force_a = 0;  ///< N, at break A
  double force_b = 0;  ///< N
};

struct UnitOutput {
  double current = 0;     ///< A
  double linkage = 0;     ///< Wb, of the coil with its leakage
  double pull = 0;        ///< N, on the moving core
  double travel = 0;      ///< m, of the core from rest
  double speed = 0;       ///< m/s
  double stop_force = 0;  ///< N, between the pole faces
  std::array<PoleOutput, most_poles> poles = {};
};

class ContactorUnit {
 public:
  /// At rest at time t, the coil without current. Throws std::invalid_argument for settings or an input that are not
  /// valid, std::runtime_error where there is no equilibrium.
  ContactorUnit(const UnitSettings&, double t, const UnitInput&);

  double now() const { return now_; }  ///< s
  int poles() const { return settings_.specimen.bridges.poles; }
  UnitOutput output() const;
  const UnitFacts& facts() const { return facts_; }

  struct Advance {
    double reached = 0;  ///< s
    bool event = false;  ///< a contact touched or parted within (before, reached]
  };
  /// Integrates to `t_end` or, with `stop`, to the first event of a contact before it. The voltage of the input
  /// counts from now(). While the input goes on as it was, where a call ends has no influence on the solution. Throws
  /// std::runtime_error where the step becomes too small.
  Advance advance(double t_end, const UnitInput&, bool stop);

  // Model exchange: the owner integrates.
  int states() const { return contactor_.size(); }
  double nominal(int state) const { return contactor_.scale(state); }
  std::span<const double> state() const { return {y_, static_cast<std::size_t>(states())}; }
  void set_time(double t) { now_ = t; }
  void set_state(std::span<const double>);
  /// The input holds from now() on. Opening or closing the coil circuit is an event.
  void set_input(const UnitInput&);
  void derivatives(std::span<double>) const;
  int indicators() const { return static_cast<int>(guards_.size()); }
  /// Above zero as long as the modes hold: per contact its depth or distance, m, then gap, forces, friction, current.
  void indicate(std::span<double>) const;
  bool mode_ended() const;
  /// Switches what has ended. True if something has: derivatives jump, perhaps states, and an integrator starts anew.
  bool switch_modes();

  /// A copy to return to, with go_back() of the same unit.
  struct Snapshot;
  std::shared_ptr<const Snapshot> snapshot() const;
  void go_back(const Snapshot&);

 private:
  using Contactor = sim::RigidContactor<double>;
  using Solver = sim::EventSolver<Contactor>;

  void take_events();
  double resistance(double kelvin) const;

  UnitSettings settings_;
  std::shared_ptr<const sim::SpecimenPotential> potential_;
  Contactor contactor_;
  Solver solver_;
  UnitInput input_;  ///< in force
  UnitFacts facts_;
  std::array<std::array<bool, 2>, most_poles> pads_ = {};
  std::array<double, most_poles> bridge_rest_ = {};  ///< m
  double core_rest_ = 0;                             ///< m
  std::vector<int> guards_;                          ///< of the contactor, in the order of the indicators
  double now_ = 0;
  alignas(64) double y_[Solver::capacity] = {};  ///< at now_
};

/// Names of the states in their order, each with its unit.
struct StateName {
  std::string name, unit, rate_unit;
};
std::vector<StateName> state_names(const sim::Specimen&);

/// Number of event indicators of a specimen.
int indicator_count(const sim::Specimen&);

}  // namespace powbench::fmu
