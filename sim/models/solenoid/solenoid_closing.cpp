#include "sim/models/solenoid/solenoid_closing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/models/integrator.h"

namespace powbench::sim {

void find_current_dip(const SolenoidRun& run, double off, SolenoidTruth& t) {
  constexpr double after = 1e-3;  // s
  if (!t.seat) return;
  const double end = std::min(*t.seat + after, off);
  const SolenoidSample *peak = nullptr, *dip = nullptr;
  for (const auto& s : run.samples)
    if (s.time <= *t.seat && (peak == nullptr || s.current > peak->current)) peak = &s;
  if (peak == nullptr) return;
  for (const auto& s : run.samples)
    if (s.time > peak->time && s.time <= end && (dip == nullptr || s.current < dip->current)) dip = &s;
  if (dip == nullptr || dip->current >= peak->current) return;
  t.peak_at = peak->time;
  t.peak_current = peak->current;
  t.dip_at = dip->time;
  t.dip_current = dip->current;
}

namespace {

using Kind = SolenoidEvent::Kind;

SolenoidTruth truth_of(const SolenoidRun& run, double off) {
  SolenoidTruth t;
  bool closed = false;
  for (const auto& e : run.events) {
    if (e.kind == Kind::start && !t.start) t.start = e.time;
    if (e.kind == Kind::seat) closed = true;
    if (e.kind == Kind::unseat) closed = false;
    if (e.time < off) {
      if (e.kind == Kind::seat && !t.seat) {
        t.seat = e.time;
        t.seat_velocity = e.velocity;
      }
      if (e.kind == Kind::seat) t.settled = e.time;
      if (e.kind == Kind::unseat) t.settled.reset();
      continue;
    }
    if (e.kind == Kind::unseat) t.unseat = e.time;
    if (e.kind == Kind::seat) t.unseat.reset();
    if (e.kind == Kind::back && t.unseat && !t.back) t.back = e.time;
  }
  for (const auto& s : run.samples)
    if (s.time < off) t.last_current = s.current;
  if (closed) t.unseat.reset();
  find_current_dip(run, off, t);
  return t;
}

}  // namespace

SolenoidRun simulate_solenoid(const SolenoidSpecimen& specimen, const MagneticPotential& potential,
                              const SolenoidCase& c) {
  if (!(c.duration > 0 && c.duration <= 10 && c.sample_step > 0 && c.sample_step <= c.duration))
    throw std::invalid_argument("duration: allowed above 0, up to 10 s, and a sample step within it");
  if (!(c.tolerance >= 1e-12 && c.tolerance <= 1e-3))
    throw std::invalid_argument("tolerance: allowed 1e-12 .. 1e-3");
  constexpr double first_step = 1e-6, largest_step = 1e-3;  // s
  SolenoidModel model(specimen, potential, c.supply, c.coil_kelvin);
  EventIntegrator<SolenoidModel> integrator(model, c.tolerance, largest_step);
  SolenoidRun run;
  auto state = model.rest();
  model.set_coil(0, state.data(), true);
  integrator.restart(0, state, first_step);
  const auto count = static_cast<std::int64_t>(std::floor(c.duration / c.sample_step + 1e-9));
  run.samples.resize(static_cast<std::size_t>(count) + 1);
  model.sample(0, state.data(), run.samples.front());
  bool on = true;
  for (std::int64_t k = 1; k <= count;) {
    const double next = static_cast<double>(k) * c.sample_step;
    const double until = on ? std::min(next, c.hold) : next;
    while (integrator.end() < until)
      if (!integrator.extend())
        throw std::runtime_error(
            "solenoid: the step became too small at t = " + std::to_string(integrator.end()) + " s");
    integrator.state(until, state);
    if (on && c.hold <= next) {
      model.set_coil(until, state.data(), false);
      integrator.restart(until, state, first_step);
      on = false;
      if (until < next) continue;
    }
    model.sample(next, state.data(), run.samples[static_cast<std::size_t>(k++)]);
  }
  run.events = model.events();
  run.truth = truth_of(run, c.hold);
  run.energy_residual = model.energy_residual(state.data());
  run.supplied = model.supplied_energy(state.data());
  run.states = model.states();
  run.beyond = model.beyond();
  return run;
}

}  // namespace powbench::sim
