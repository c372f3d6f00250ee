#include "sim/mechanics/rigid_closing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "sim/specimen_potential.h"
#include "sim/unilateral.h"
#include "sim/validate.h"

namespace powbench::sim {
namespace {

ContactLaw half(double stiffness, double ratio, double mass) {
  const double c = 2 * ratio * std::sqrt(stiffness * mass);
  return {stiffness / 2, 1, DampingForm::linear, c / 2, 0};
}

PlantEvent plant_event(const RigidEvent& e) {
  using Kind = PlantEvent::Kind;
  const auto place = contact_place(e.contact);
  Kind kind = e.closes ? Kind::core_touch : Kind::core_release;
  if (place.kind == ContactKind::pad && place.end == 0) kind = e.closes ? Kind::touch_a : Kind::release_a;
  if (place.kind == ContactKind::pad && place.end == 1) kind = e.closes ? Kind::touch_b : Kind::release_b;
  return {kind, e.time, e.closes ? e.speed : -e.speed};
}

/// Pads of the first bridge, and one pole face: without tilt both touch together.
bool is_measured(const RigidEvent& e) {
  const auto place = contact_place(e.contact);
  if (place.kind == ContactKind::pad) return place.part == 0;
  return place.kind == ContactKind::pole && place.end == 0;
}

struct Sampler {
  const Specimen& specimen;
  const CoilDrive& drive;
  double rest = 0;  ///< m, the core's place in equilibrium
  std::vector<PlantSample>& out;

  void operator()(double t, const RigidContactor<double>& c, const double* y) const {
    alignas(64) double dy[EventSolver<RigidContactor<double>>::capacity] = {};
    c.derivative(t, y, dy);
    const int n = c.dof();
    PlantSample s;
    s.time = t;
    s.mains_voltage = c.mains(t);
    s.coil_current = c.current(y);
    const auto& source = drive.supply.mains;
    s.coil_voltage = dy[2 * n] + (drive.resistance - source.resistance) * s.coil_current;
    s.flux_linkage = y[2 * n];
    if (source.inductance > 0) {
      s.coil_voltage -= source.inductance * c.current_rate(y, dy);
      s.flux_linkage = c.coil_linkage(y);
    }
    s.pull = c.pull(t, y);
    s.travel = y[0] - rest;
    s.core_velocity = y[n];
    const int base = specimen.base.core_mass > 0 ? 3 : 2;
    s.base = y[base];
    s.base_acceleration = dy[n + base];
    const int pole = core_group * rigid_lanes;
    s.core_force = c.force_of(pole, y) + c.force_of(pole + 1, y);
    s.force_a = c.force_of(0, y);
    s.force_b = c.force_of(rigid_lanes, y);
    out.push_back(s);
  }
};

}  // namespace

std::vector<RigidEvent> contact_events(std::span<const PlantEvent> events) {
  std::vector<RigidEvent> result;
  for (const auto& e : events) {
    using Kind = PlantEvent::Kind;
    if (e.kind == Kind::stall || e.kind == Kind::coil_open) continue;
    const bool core = e.kind == Kind::core_touch || e.kind == Kind::core_release;
    const bool b = e.kind == Kind::touch_b || e.kind == Kind::release_b;
    const bool closes = e.kind == Kind::touch_a || e.kind == Kind::touch_b || e.kind == Kind::core_touch;
    const int contact = core ? core_group * rigid_lanes : b ? rigid_lanes : 0;
    result.push_back({contact, closes, e.time, std::fabs(e.velocity)});
  }
  return result;
}

namespace {

/// One mass on the mounting carries static core and fixed contacts; or it is a housing, with the static core on buffer
/// springs inside: then it is the one mode of the base.
void set_base(const Base& b, RigidParts& p) {
  const bool floats = b.core_mass > 0;
  const double mass = floats ? b.core_mass : b.mass;
  const double omega = 2 * pi * (floats ? b.core_hertz : b.hertz);
  p.static_mass = mass;
  p.buffer_rate = mass * omega * omega;
  p.buffer_damping = 2 * (floats ? b.core_damping : b.damping) * mass * omega;
  p.pads_follow = floats ? 0 : 1;
  if (!floats) return;
  BaseMode housing;
  housing.mass = b.mass;
  housing.hertz = b.hertz;
  housing.damping = b.damping;
  housing.buffer = 1;
  for (auto& ends : housing.shape) ends[0] = ends[1] = 1;
  p.modes = {housing};
}

}  // namespace

RigidParts rigid_parts(const Specimen& s) {
  require_valid(s);
  RigidParts p;
  const double stop_depth = s.core.return_preload / s.core.stop_stiffness;
  const double seat_depth = s.bridges.preload / s.bridges.seat_stiffness;
  p.core_mass = s.core.mass;
  p.core_inertia = s.core.mass * 1e-4;
  p.tilt_rate = p.core_inertia * 1e6;
  p.tilt_damping = 0;
  // the specimen counts lengths from the pressed position of rest, the parts from the untouched one
  p.travel = s.core.travel - stop_depth;
  p.return_preload = s.core.return_preload + s.core.return_rate * stop_depth;
  p.return_rate = s.core.return_rate;
  p.core_damping = 0;
  p.core_friction = s.core.friction;
  set_base(s.base, p);
  p.pole = p.stop = half(s.core.stop_stiffness, damping_ratio(s.core.stop_restitution), s.core.mass);
  const auto& b = s.bridges;
  p.pad = half(b.contact_stiffness, damping_ratio(b.contact_restitution), b.mass);
  p.seat = half(b.seat_stiffness, b.seat_damping, b.mass);
  for (int pole = 0; pole < b.poles; ++pole) {
    RigidBridge r;
    r.mass = b.mass;
    r.inertia = b.inertia;
    r.pad_arm = b.half_length;
    r.seat_arm = b.seat_half_length;
    r.preload = b.preload + b.rate * seat_depth;
    r.rate = b.rate;
    r.damping = 0;
    const double shift = seat_depth - stop_depth;
    r.gap[0] = b.gap + pole * b.gap_spread + shift;
    r.gap[1] = r.gap[0] + b.tilt_gap;
    p.bridges.push_back(r);
  }
  return p;
}

namespace {

Trajectory run_closing(const MagneticPotential& potential, bool pressed_gap, const Specimen& specimen,
                       const Conditions& conditions, double duration, double sample_dt,
                       double relative_tolerance, bool ledger, const Supply& bench) {
  const Mains mains = closing_mains(conditions, bench.mains);
  if (!(sample_dt >= 0)) throw std::invalid_argument("sample_dt: allowed >= 0 s");
  const auto parts = rigid_parts(specimen);
  const auto& coil = specimen.coil;
  CoilDrive drive;
  drive.potential = &potential;
  drive.resistance =
      coil.resistance * (1 + coil.temperature_coefficient * (conditions.ambient - 293.15)) + mains.resistance;
  drive.ring_resistance = SpecimenPotential(specimen).ring_resistance();
  drive.supply = {mains, bench.coil_switch};
  drive.remanence = remanence(specimen);
  drive.pressed_gap = pressed_gap;

  Trajectory result;
  RigidOptions o;
  o.tolerance = relative_tolerance;
  o.end = duration;
  o.ledger = ledger;
  o.energy_bound = 1;
  o.off = conditions.hold_time < duration ? conditions.hold_time : 1e300;
  o.sample = sample_dt;
  const double rest = -specimen.core.return_preload / specimen.core.stop_stiffness;
  o.each = Sampler{specimen, drive, rest, result.samples};
  const auto run = run_rigid(parts, drive, o);
  if (!run.completed) throw std::runtime_error(run.dump);
  for (const auto& e : run.events)
    if (is_measured(e)) result.events.push_back(plant_event(e));
  result.truth = closing_truth(result.events, std::min(conditions.hold_time, duration));
  for (const auto& s : result.samples)
    result.truth.peak_current = std::max(result.truth.peak_current, std::fabs(s.coil_current));
  result.stages = run.stages;
  result.evaluations = run.evaluations;
  result.energy_residual = run.energy_residual;
  result.supplied = run.energies.supplied;
  return result;
}

}  // namespace

Trajectory simulate_rigid(const Specimen& specimen, const Conditions& conditions, double duration,
                          double sample_dt, double relative_tolerance, bool ledger, const Supply& bench) {
  require_valid(specimen);
  return run_closing(SpecimenPotential(specimen), true, specimen, conditions, duration, sample_dt,
                     relative_tolerance, ledger, bench);
}

Trajectory simulate_rigid_with(const MagneticPotential& potential, const Specimen& specimen,
                               const Conditions& conditions, double duration, double sample_dt,
                               double relative_tolerance, bool ledger, const Supply& bench) {
  return run_closing(potential, false, specimen, conditions, duration, sample_dt, relative_tolerance, ledger,
                     bench);
}

}  // namespace powbench::sim
