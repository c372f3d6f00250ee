#include "sim/models/solenoid/solenoid_eddy_closing.h"

#include <cmath>
#include <stdexcept>

namespace powbench::sim {

SolenoidRun simulate_solenoid_eddies(const SolenoidSpecimen& s, const FieldOptions& o,
                                     const SolenoidCase& c) {
  require_valid(s);
  const auto need = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(std::string("with eddy currents: ") + what);
  };
  need(s.conductivity > 0, "magnet.conductivity_S_per_m = 0, allowed above 0");
  need(s.coil.hold_turns == 0, "coil.hold_turns: allowed 0");
  need(c.supply.mains.kind == Mains::Kind::dc && c.supply.mains.inductance == 0,
       "supply: allowed kind = dc without inductance");
  need(c.supply.coil_switch.kind == CoilSwitch::Kind::ideal && c.supply.coil_switch.hold_period == 0,
       "switch: allowed kind = ideal, no economiser");
  need(!std::isfinite(c.hold), "the coil stays on: leave out the time of switching off");
  constexpr double step = 50e-6;  // s
  const double volts = c.supply.mains.volts;
  const auto& p = s.plunger;
  TransientSetup t;
  t.voltage = [volts](double) { return volts; };
  t.resistance = s.coil.resistance * (1 + s.coil.temperature_coefficient * (c.coil_kelvin - 293.15)) +
                 c.supply.mains.resistance;
  t.iron_conductivity = s.conductivity;
  t.mass = p.moving_mass();
  t.start_gap = s.travel();
  t.counter_force = [&](double gap) {
    return p.return_preload + p.load + p.friction + p.return_rate * (s.travel() - gap);
  };
  t.step = step;
  t.duration = c.duration;
  const auto result = run_transient(s.design, o, t);
  SolenoidRun run;
  for (const auto& q : result.samples) {
    const double rate = volts - t.resistance * q.current;
    run.samples.push_back({q.time, volts, rate + (t.resistance - c.supply.mains.resistance) * q.current,
                           q.current, q.psi, q.pull, s.travel() - q.gap, -q.velocity, 0});
    if (!run.truth.start && q.gap < s.travel()) run.truth.start = q.time;
  }
  for (auto& q : run.samples) q.velocity = std::fabs(q.velocity);
  if (result.closed_at >= 0) {
    run.truth.seat = run.truth.settled = result.closed_at;
    for (const auto& q : run.samples)
      if (q.time < result.closed_at) run.truth.seat_velocity = q.velocity;
  }
  find_current_dip(run, c.hold, run.truth);
  run.truth.last_current = run.samples.back().current;
  run.energy_residual = std::fabs(result.energy.residual());
  run.supplied = result.energy.supplied;
  return run;
}

}  // namespace powbench::sim
