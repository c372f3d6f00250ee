#include <algorithm>
#include <cmath>

#include "sim/models/counting_potential.h"
#include "sim/models/mechanics_kinds.h"
#include "sim/models/solid_closing.h"

namespace powbench::sim {
namespace {

/// State at a time between the samples of a closing with deforming parts.
PlantSample between(const std::vector<SolidClosingSample>& list, double t, std::size_t& at) {
  while (at + 2 < list.size() && list[at + 1].time < t) ++at;
  const auto &a = list[at], &b = list[std::min(at + 1, list.size() - 1)];
  const double share = b.time > a.time ? std::clamp((t - a.time) / (b.time - a.time), 0.0, 1.0) : 0.0;
  const auto mix = [&](double x, double y) { return x + share * (y - x); };
  PlantSample s;
  s.time = t;
  s.coil_current = mix(a.current, b.current);
  s.flux_linkage = mix(a.flux, b.flux);
  s.pull = mix(a.pull, b.pull);
  s.travel = mix(a.travel, b.travel);
  s.base = mix(a.base, b.base);
  s.core_velocity = b.time > a.time ? (b.travel - a.travel) / (b.time - a.time) : 0;
  s.force_a = s.force_b = 0.5 * mix(a.pad_force, b.pad_force);
  return s;
}

/// The deformable rung's result in the words of the others.
Trajectory trajectory(const SolidClosingResult& r, const Case& c, double duration, double sample_dt) {
  Trajectory t;
  if (r.first_touch >= 0) t.truth.touch = t.truth.touch_a = t.truth.touch_b = r.first_touch;
  if (r.last_touch >= 0) t.truth.settled = r.last_touch;
  if (r.core_seat >= 0) t.truth.core_seat = r.core_seat;
  for (const auto& [release, touch] : r.open) t.truth.openings.push_back({release, touch});
  t.evaluations = r.rigid_steps + r.deformed_steps;
  t.energy_residual = r.residual;
  std::size_t at = 0;
  for (std::size_t k = 1;
       sample_dt > 0 && static_cast<double>(k) * sample_dt <= duration && !r.samples.empty(); ++k) {
    PlantSample s = between(r.samples, static_cast<double>(k) * sample_dt, at);
    s.mains_voltage = s.coil_voltage = mains_voltage(closing_mains(c.conditions), MainsPiece{}, s.time);
    t.truth.peak_current = std::max(t.truth.peak_current, std::fabs(s.coil_current));
    t.samples.push_back(s);
  }
  return t;
}

Trajectory run_deformable(const FieldRung& fields, const Case& c, double duration, double cell_mm,
                          double sample_dt) {
  refuse_unknown(deformable_mechanics(), c);
  SolidClosingOptions o;
  o.cell = cell_mm * 1e-3;
  o.end = std::min(duration, deformable_duration);
  o.pressed_gap = fields.pressed_gap;
  const CountingPotential potential(fields.potential(c));
  return potential.told(
      trajectory(solid_closing(c.specimen, c.conditions, potential, o), c, duration, sample_dt));
}

Rung deformable_rung(const FieldRung& fields) {
  Rung r{fields.name, "deformable", fields.meaning + ", deforming parts of finite elements",
         [fields](const Case& c, double duration, double cell_mm, double sample_dt) {
           return run_deformable(fields, c, duration, cell_mm, sample_dt);
         }};
  r.setting = "cell mm";
  r.settings = {6, 4, 3};
  r.costly = true;
  return r;
}

std::string unknown_to_deformable(const Case& c) {
  if (std::string beyond = beyond_deforming_parts("deformable", c); !beyond.empty()) return beyond;
  if (c.conditions.hold_time < deformable_duration)
    return "hold_time: allowed from " + std::to_string(deformable_duration * 1e3) +
           " ms on, the rung deformable does not switch off; take plant or rigid";
  return "";
}

}  // namespace

Mechanics deformable_mechanics() {
  return {.name = "deformable",
          .detail = 2,
          .any_fields = true,
          .costly = true,
          .unknown = unknown_to_deformable,
          .rung = deformable_rung};
}

}  // namespace powbench::sim
