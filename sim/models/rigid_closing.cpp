#include "sim/models/rigid_closing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/specimen/specimen_remanence.h"
#include "sim/specimen/validate.h"

namespace powbench::sim {
namespace {

/// One of two equal ends that share a contact of the specimen; `viscous` is its c where n = 1.
ContactLaw half(double stiffness, double n, double viscous, double depth, double rebound, double speed) {
  if (n == 1) return {stiffness / 2, 1, DampingForm::linear, viscous / 2, 0};
  const double lambda = hunt_crossley_approach(rebound) / speed;
  return {stiffness / 2 * std::pow(depth, 1 - n), n, DampingForm::hunt_crossley, lambda, 0};
}

/// Displacement of a free beam's bending mode k = 1, 2, 3 at a share of its length: +-1 at its ends.
double beam_shape(int k, double share) {
  constexpr double root[] = {4.730040744862704, 7.853204624095838, 10.995607838001671};
  const double b = root[k - 1], z = b * share;
  const double ratio = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
  return 0.5 * (std::cosh(z) + std::cos(z) - ratio * (std::sinh(z) + std::sin(z)));
}

/// The housing bends along the row of poles, which stand at the middles of equal shares of its length.
void add_bending(const Specimen& s, RigidParts& p) {
  constexpr double of_first[] = {1, 2.756538, 5.403918};
  for (int k = 1; k <= s.base.flex_modes; ++k) {
    BaseMode m;
    m.mass = s.base.flex_mass;
    m.hertz = s.base.flex_hertz * of_first[k - 1];
    m.damping = s.base.flex_damping;
    for (int pole = 0; pole < s.bridges.poles; ++pole)
      m.shape[pole][0] = m.shape[pole][1] = beam_shape(k, (pole + 0.5) / s.bridges.poles);
    p.modes.push_back(m);
  }
}

PlantEvent plant_event(const RigidEvent& e) {
  using Event = PlantEvent::Kind;
  const auto place = contact_place(e.contact);
  Event kind = e.closes ? Event::core_touch : Event::core_release;
  if (place.kind == ContactKind::pad && place.end == 0) kind = e.closes ? Event::touch_a : Event::release_a;
  if (place.kind == ContactKind::pad && place.end == 1) kind = e.closes ? Event::touch_b : Event::release_b;
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
    const MagneticResponse m = c.derivative(t, y, dy);
    const int n = c.dof();
    PlantSample s;
    s.time = t;
    s.mains_voltage = c.mains(t);
    s.coil_current = c.current(y, m);
    const auto& source = drive.supply.mains;
    s.coil_voltage = dy[2 * n] + (drive.resistance - source.resistance) * s.coil_current;
    s.flux_linkage = y[2 * n];
    if (source.inductance > 0) {
      s.coil_voltage -= source.inductance * c.current_rate(y, dy, m);
      s.flux_linkage = c.coil_linkage(y, m);
    }
    s.pull = m.pull;
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
  const double stop_depth = stop_rest_depth(s);
  const double seat_depth = s.bridges.preload / s.bridges.seat_stiffness;
  p.core_mass = s.core.mass;
  const bool tilts = s.core.tilt_inertia > 0;  // else nothing excites it: all bridges in the middle
  p.core_inertia = tilts ? s.core.tilt_inertia : s.core.mass * 1e-4;
  const double omega = tilts ? 2 * pi * s.core.tilt_hertz : 1e3;
  p.tilt_rate = p.core_inertia * omega * omega;
  p.tilt_damping = tilts ? 2 * s.core.tilt_damping * p.core_inertia * omega : 0;
  p.pole_arm = s.core.pole_arm;
  // the specimen counts lengths from the pressed position of rest, the parts from the untouched one
  p.travel = s.core.travel - stop_depth;
  p.return_preload = s.core.return_preload + s.core.return_rate * stop_depth;
  p.return_rate = s.core.return_rate;
  p.core_damping = 0;
  p.core_friction = s.core.friction;
  set_base(s.base, p);
  add_bending(s, p);
  const auto& b = s.bridges;
  const auto& c = s.core;
  p.pole = p.stop = half(c.stop_stiffness, c.stop_exponent, stop_damping(s), c.stop_depth, c.stop_restitution,
                         c.stop_speed);
  p.pad = half(b.contact_stiffness, b.contact_exponent, pad_damping(s), b.contact_depth,
               b.contact_restitution, b.contact_speed);
  p.seat = half(b.seat_stiffness, 1, seat_damping(s), 1, 1, 1);
  for (int pole = 0; pole < b.poles; ++pole) {
    RigidBridge r;
    r.mass = b.mass;
    if (tilts) r.position = (pole - 0.5 * (b.poles - 1)) * b.pitch;
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
  drive.ring_resistance = specimen.magnet.ring_resistance;
  drive.supply = {mains, bench.coil_switch, bench.suppression};
  drive.remanence = remanence(specimen);
  drive.pressed_gap = pressed_gap;

  Trajectory result;
  RigidOptions o;
  o.tolerance = relative_tolerance;
  o.end = duration;
  o.ledger = ledger;
  o.off = conditions.hold_time < duration ? conditions.hold_time : 1e300;
  o.sample = sample_dt;
  const double rest = -stop_rest_depth(specimen);
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
