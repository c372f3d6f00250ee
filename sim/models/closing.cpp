#include "sim/models/closing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/commanded_phase.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/specimen/validate.h"

namespace powbench::sim {

Mains closing_mains(const Conditions& c, const Mains& bench) {
  if (!(c.supply_volts >= 0 && c.supply_volts <= 1e4))
    throw std::invalid_argument("supply_volts: allowed 0 .. 10000");
  if (!(c.mains_hertz >= 1 && c.mains_hertz <= 1000))
    throw std::invalid_argument("mains_hertz: allowed 1 .. 1000");
  if (!std::isfinite(c.closing_angle)) throw std::invalid_argument("closing_angle: allowed any finite angle");
  if (!(c.hold_time >= 0)) throw std::invalid_argument("hold_time: allowed 0 s and more");
  if (!(c.ambient >= 150 && c.ambient <= 600)) throw std::invalid_argument("ambient: allowed 150 .. 600 K");
  if (c.polarity != 1 && c.polarity != -1) throw std::invalid_argument("polarity: allowed +1, -1");
  Mains m = bench;
  m.volts = c.supply_volts;
  m.hertz = c.mains_hertz;
  m.phase = commanded_phase(c);
  return m;
}

PlantOptions closing_options(const Conditions& c, double relative_tolerance) {
  return {relative_tolerance, c.ambient};
}

ClosingTruth closing_truth(std::span<const PlantEvent> events, double off) {
  using Kind = PlantEvent::Kind;
  ClosingTruth t;
  bool a = false;
  bool b = false;
  bool closed = false;
  double release = 0;
  for (const auto& e : events) {
    if (e.kind == Kind::core_touch && e.time <= off) {
      if (!t.core_seat) t.seat_velocity = e.velocity;
      if (!t.core_seat) t.core_seat = e.time;
      t.core_settled = e.time;
    }
    if (e.kind == Kind::touch_a && !t.touch_a) t.touch_a = e.time;
    if (e.kind == Kind::touch_b && !t.touch_b) t.touch_b = e.time;
    if (e.kind == Kind::touch_a || e.kind == Kind::release_a) a = e.kind == Kind::touch_a;
    if (e.kind == Kind::touch_b || e.kind == Kind::release_b) b = e.kind == Kind::touch_b;
    const bool now_closed = a && b;
    if (now_closed == closed) continue;
    closed = now_closed;
    if (e.time <= off) t.calm = closed ? off - e.time : 0;
    if (!closed) release = e.time;
    if (!closed && e.time > off && !t.opened) t.opened = e.time;
    if (!closed || e.time > off) continue;
    if (t.touch) {
      t.openings.push_back({release, e.time});
    } else {
      t.touch = e.time;
      t.touch_velocity = e.velocity;
    }
    t.settled = e.time;
  }
  return t;
}

bool chatters(const ClosingTruth& t, double end) {
  constexpr double longer = 1.5;
  if (!t.touch || !t.settled) return false;
  double since = *t.touch, longest = 0;
  for (const Opening& o : t.openings) longest = std::max(longest, o.release - since), since = o.touch;
  return end - *t.settled < longer * longest;
}

Plant closing_plant(const Specimen& specimen, const Conditions& conditions, double relative_tolerance,
                    const Supply& bench) {
  PlantOptions options = closing_options(conditions, relative_tolerance);
  options.coil_switch = bench.coil_switch;
  options.suppression = bench.suppression;
  Plant plant(specimen, closing_mains(conditions, bench.mains), options);
  plant.gate(true);
  return plant;
}

Trajectory simulate(const Specimen& specimen, const Conditions& conditions, double duration, double sample_dt,
                    double relative_tolerance, const Supply& bench) {
  if (!(duration > 0 && duration <= 100)) throw std::invalid_argument("duration: allowed 0 .. 100 s");
  if (!(sample_dt >= 0)) throw std::invalid_argument("sample_dt: allowed >= 0 s");
  Plant plant = closing_plant(specimen, conditions, relative_tolerance, bench);
  Trajectory result;
  std::vector<double> times;
  if (sample_dt > 0)
    for (std::size_t k = 1; static_cast<double>(k) * sample_dt <= duration; ++k)
      times.push_back(static_cast<double>(k) * sample_dt);
  result.samples.resize(times.size());

  const double off = std::min(conditions.hold_time, duration);
  const auto held =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), off) - times.begin());
  const std::span<const double> all(times);
  const std::span<PlantSample> out(result.samples);
  plant.advance(off, all.first(held), out.first(held));
  if (duration > off) {
    plant.gate(false);
    plant.advance(duration, all.subspan(held), out.subspan(held));
  }

  result.events.assign(plant.events().begin(), plant.events().end());
  result.truth = closing_truth(result.events, off);
  for (const auto& s : result.samples)
    result.truth.peak_current = std::max(result.truth.peak_current, std::fabs(s.coil_current));
  result.evaluations = plant.evaluations();
  result.energy_residual = plant.energy_residual();
  result.supplied = plant.supplied_energy();
  return result;
}

ClosingTruth tried_closing(const Specimen& specimen, const Conditions& conditions, double duration,
                           double relative_tolerance) {
  if (!validate(specimen).empty() || !rigid_only(specimen).empty()) return {};
  try {
    return simulate(specimen, conditions, duration, 0, relative_tolerance).truth;
  } catch (const std::runtime_error&) {  // a step became too small
    return {};
  }
}

}  // namespace powbench::sim
