#include "bench/supply/energy_cases.h"
#include "core/cpu_time.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "bench/fields/circuit.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/models/rigid_closing.h"

namespace powbench::bench {
namespace {

constexpr double closing_end = 0.06;  // s
constexpr double circuit_limit = 1e-6, field_limit = 1e-3;

std::string setting_of(double tolerance) {
  char text[32];
  std::snprintf(text, sizeof text, "tolerance %.0e", tolerance);
  return text;
}

Conditions at_angle(double degrees) {
  Conditions c;
  c.closing_angle = radians(degrees);
  return c;
}

/// `run` gives residual, supplied energy and whether the core arrived.
struct One {
  double residual = 0, supplied = 0;
  bool seated = false;
};
EnergyRow row(std::string method, std::string setting, double step, double limit,
              const std::function<One(const Conditions&)>& run) {
  EnergyRow r{std::move(method), std::move(setting), 0, HUGE_VAL, 0, limit, 0, 0};
  const double start = process_cpu_seconds();
  for (double degrees = 0; degrees < 180; degrees += step) {
    const One one = run(at_angle(degrees));
    ++r.closings;
    r.seated += one.seated;
    r.residual = std::max(r.residual, std::fabs(one.residual));
    r.supplied = std::min(r.supplied, one.supplied);
  }
  r.cpu_ms = 1e3 * (process_cpu_seconds() - start) / r.closings;
  return r;
}

One one_of(const sim::Trajectory& t) {
  return {t.energy_residual, t.supplied, t.truth.core_seat.has_value()};
}

sim::Supply weak() {
  sim::Supply s;
  s.mains.resistance = 10;
  s.mains.inductance = 0.05;
  s.mains.harmonics[0].share = 0.05;
  s.mains.harmonics[1] = {5, 0.03, 1.0};
  s.mains.dips[0] = {6e-3, 4e-3, 0.5, 0.5};
  return s;
}

sim::Supply relay() {
  sim::Supply s;
  s.coil_switch.kind = sim::CoilSwitch::Kind::relay;
  s.coil_switch.closing_delay = 7e-3;
  s.coil_switch.opening_delay = 4e-3;
  s.coil_switch.bounces[0] = {0.4e-3, 0.7e-3};
  s.coil_switch.bounces[1] = {8e-3, 14e-3};
  return s;
}

sim::Supply triac() {
  sim::Supply s;
  s.coil_switch.kind = sim::CoilSwitch::Kind::triac;
  s.coil_switch.latching_current = 0.03;
  s.coil_switch.holding_current = 0.02;
  s.coil_switch.gate_pulse = 0.3e-3;
  s.coil_switch.gate_period = 0.5e-3;
  return s;
}

}  // namespace

sim::MagnetDesign reference_design() {
  const sim::Specimen s;
  sim::MagnetDesign d;
  d.shape = s.shape;
  d.steel = sim::Steel::power_law(s.magnet.bh_linear, s.magnet.bh_power, s.magnet.bh_exponent);
  d.turns = s.coil.turns;
  d.residual_gap = s.magnet.residual_gap;
  return d;
}

std::vector<EnergyRow> circuit_rows(double step, double tolerance) {
  return {
      row("specimen circuit, plant", setting_of(tolerance), step, circuit_limit,
          [&](const Conditions& c) { return one_of(sim::simulate({}, c, closing_end, 0, tolerance)); }),
      row("specimen circuit, rigid", setting_of(tolerance), step, circuit_limit, [&](const Conditions& c) {
        return one_of(sim::simulate_rigid({}, c, closing_end, 0, tolerance));
      })};
}

std::vector<EnergyRow> supply_rows(double step, double tolerance) {
  sim::Specimen iron;
  iron.magnet.coercive_field = 80;
  iron.magnet.remanence = 0.7;
  struct Case {
    const char* name;
    sim::Supply supply;
    sim::Specimen specimen;
  };
  const Case cases[] = {{"weak mains with a dip", weak(), {}},
                        {"relay", relay(), {}},
                        {"triac", triac(), {}},
                        {"remanence", {}, iron}};
  std::vector<EnergyRow> rows;
  for (const auto& k : cases)
    for (const bool rigid : {false, true})
      rows.push_back(row(std::string(k.name) + (rigid ? ", rigid" : ", plant"), setting_of(tolerance), step,
                         circuit_limit, [&](Conditions c) {
                           c.hold_time = closing_end;
                           const double end = 2 * closing_end;
                           return one_of(
                               rigid ? sim::simulate_rigid(k.specimen, c, end, 0, tolerance, true, k.supply)
                                     : sim::simulate(k.specimen, c, end, 0, tolerance, k.supply));
                         }));
  return rows;
}

EnergyRow potential_row(const std::string& name, const sim::MagneticPotential& potential, double step,
                        double tolerance) {
  return row(name + ", rigid", setting_of(tolerance), step, circuit_limit, [&](const Conditions& c) {
    return one_of(sim::simulate_rigid_with(potential, {}, c, closing_end, 0, tolerance));
  });
}

std::unique_ptr<sim::MagneticPotential> shape_circuit() {
  const auto d = reference_design();
  return std::make_unique<sim::CircuitPotential>(d.shape, d.steel, d.turns, d.residual_gap);
}

std::unique_ptr<sim::MagneticPotential> coarse_table(bool ring) {
  sim::TableOptions o;
  o.accuracy = 0.05;
  o.ring = ring;
  sim::Team team(2);
  return std::make_unique<sim::TablePotential>(sim::build_table(reference_design(), o, team));
}

EnergyRow field_row(double step, double seconds, bool ring) {
  auto design = reference_design();
  if (!ring) design.shape.ring_share = 0;
  char setting[48];
  std::snprintf(setting, sizeof setting, "steps of %.0f us", seconds * 1e6);
  return row(ring ? "solved with ring" : "solved", setting, step, field_limit, [&](const Conditions& c) {
    const sim::Specimen s;
    sim::FieldOptions o;
    o.sizes = sim::sizes_for(0.02);
    o.newton.tolerance = 1e-10;
    sim::TransientSetup setup;
    setup.voltage = [&](double t) {
      return std::sqrt(2.0) * c.supply_volts * std::sin(2 * pi * c.mains_hertz * t + c.closing_angle);
    };
    setup.resistance = s.coil.resistance;
    setup.ring_resistance = s.magnet.ring_resistance;
    setup.mass = s.core.mass;
    setup.counter_force = [&](double gap) {
      return s.core.return_preload + s.core.return_rate * (s.core.travel - gap);
    };
    setup.start_gap = s.core.travel;
    setup.step = seconds;
    setup.duration = 25e-3;
    const auto r = sim::run_transient(design, o, setup);
    return One{r.energy.residual(), r.energy.supplied, r.closed_at > 0};
  });
}

}  // namespace powbench::bench
