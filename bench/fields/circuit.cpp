#include "bench/fields/circuit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "sim/magnetics/plane/core_mesh.h"

namespace powbench::sim {
namespace {

constexpr double vacuum = 4e-7 * pi;  // V s/(A m)
constexpr double half_cylinder = 0.26;

/// Fluxes F and -F through the shares a and 1 - a of a leg's width w become none along the leg, each wave of their
/// difference as exp(-n pi y / w). The energy is that of this length, over w, in which they stay as they are; 0.271
/// for equal halves.
double mixing_length(double a) {
  double sum = 0;
  for (int n = 1; n <= 50; ++n) {
    const double wave = std::sin(n * pi * a) / n;
    sum += wave * wave / n;
  }
  return 2 * sum / (a * (1 - a) * pi * pi * pi);
}

}  // namespace

CircuitPotential::CircuitPotential(const MagnetShape& s, const Steel& steel, double turns,
                                   double residual_gap, double end_leakage, const CircuitOptions& options)
    : steel_(steel.stacked(s.stack_factor)), turns_(turns), residual_gap_(residual_gap) {
  check_shape(s);
  if (!(residual_gap >= 0.05e-6 && residual_gap <= 1e-3))
    throw std::invalid_argument("magnet.residual_gap_um = " + std::to_string(residual_gap * 1e6) +
                                ", allowed 0.05 .. 1000");
  if (!(turns >= 1 && turns <= 1e6))
    throw std::invalid_argument("coil.turns = " + std::to_string(turns) + ", allowed 1 .. 1e6");
  if (!(end_leakage >= 0)) throw std::invalid_argument("end leakage below 0");
  const bool ring = s.ring_share > 0;
  const double tip = ring ? s.ring_depth : 0;

  // iron: the outer legs, likewise the parts of each yoke, as one path; half of the flux comes from half of the
  // centre leg
  const int sides = s.outer_legs();
  const double centre = s.centre_width * s.stack;
  const double outer = sides * s.outer_width * s.stack;
  const double yoke = sides * s.yoke * s.stack;
  const double across = s.window_width + 0.5 * s.centre_width / sides + 0.5 * s.outer_width;
  const double fixed_leg = s.fixed_window + 0.5 * s.yoke, moving_leg = s.moving_window + 0.5 * s.yoke;
  // below the slot and beyond the gap the fluxes inside and outside of the ring become one
  const double inside = (s.ring_share * (s.outer_width - s.ring_slot) + 0.5 * s.ring_slot) / s.outer_width;
  const double mixing =
      ring ? std::min({mixing_length(inside) * s.outer_width, 0.5 * (fixed_leg - tip), moving_leg}) : 0;
  path_ = {{fixed_leg, centre}, {across, yoke}, {fixed_leg - tip - mixing, outer}, {across, yoke}};
  if (s.moving_window > 0) {
    path_.push_back({moving_leg, centre});
    path_.push_back({moving_leg - mixing, outer});
  }

  // gaps; the slot of the ring takes its width from the pole face, in equal parts from both sides
  const double slot = ring ? s.ring_slot : 0;
  const bool closed = s.closed_leg != 0;
  const double face = closed ? 0 : sides * (s.outer_width - slot) * s.stack;
  const double share = ring ? s.ring_share : 0;
  const double flank = 0.5 * s.window_width;
  const double outside = 0.5 * (s.outer_width + s.yoke);
  centre_ = {centre, s.centre_gap, {{sides * s.stack, flank}}};
  if (sides == 1) centre_.edges.push_back({s.stack, 0.5 * (s.centre_width + s.yoke)});
  shaded_ = {share * face, 0, {}};
  bare_ = {(1 - share) * face, 0, {{sides * s.stack, outside}}};
  (ring ? shaded_ : bare_).edges.push_back({sides * s.stack, flank});
  if (options.stack_ends) {
    centre_.edges.push_back({2 * s.centre_width, 0.5 * s.centre_width});
    bare_.edges.push_back({2 * sides * (1 - share) * s.outer_width, 0.5 * s.outer_width});
    if (ring) shaded_.edges.push_back({2 * sides * share * s.outer_width, 0.5 * s.outer_width});
  }
  if (ring)
    for (Face* beside : {&shaded_, &bare_}) {
      beside->slot_length = sides * s.stack;
      beside->slot = slot;
    }
  if (closed) column_ = {{1, outer}};
  if (ring) {
    shaded_tips_ = {{tip, std::max(shaded_.area, 1e-3 * outer)}, {2 * mixing, inside * outer}};
    bare_tips_ = {{tip, bare_.area}, {2 * mixing, (1 - inside) * outer}};
  }

  // leakage across the windows of the fixed half: a third of the winding's height counts, all of what is above it
  const double above = s.fixed_window - s.coil_offset - s.coil_height;
  const double depth = s.stack + (options.stack_ends ? s.window_width : 0);
  const double permeance = vacuum * sides * depth * (s.coil_height / 3 + above) / s.window_width;
  leakage_ = turns * turns * permeance + end_leakage;
  stack_factor_ = s.stack_factor;
}

double CircuitPotential::sheet_resistance(double thickness, double conductivity) const {
  if (!(thickness >= 0.02e-3 && thickness <= 5e-3))
    throw std::invalid_argument("thickness of a sheet = " + std::to_string(thickness * 1e3) +
                                " mm, allowed 0.02 .. 5");
  if (!(conductivity >= 1e4 && conductivity <= 1e8))
    throw std::invalid_argument("conductivity = " + std::to_string(conductivity) +
                                " S/m, allowed 1e4 .. 1e8");
  double lengths = 0;
  for (const auto& s : path_) lengths += s.length / (s.area * stack_factor_);
  return 12 * turns_ * turns_ / (conductivity * thickness * thickness * lengths);
}

CircuitPotential::Derivatives CircuitPotential::iron(const std::vector<Section>& sections,
                                                     double flux) const {
  Derivatives d;
  for (const auto& s : sections) {
    const double b = flux / s.area;
    const SteelPoint p = steel_.at(std::fabs(b));
    d.energy += s.area * s.length * p.energy;
    d.first += s.length * std::copysign(p.h, b);
    d.second += s.length / s.area * p.dh_db;
  }
  return d;
}

/// All iron that carries phi.
CircuitPotential::Derivatives CircuitPotential::path(double flux, double gap) const {
  Derivatives d = iron(path_, flux);
  const Derivatives column = iron(column_, flux);
  const double length = gap + residual_gap_;
  d.energy += length * column.energy;
  d.first += length * column.first;
  d.second += length * column.second;
  return d;
}

CircuitPotential::Reluctance CircuitPotential::reluctance(const Face& face, double gap) const {
  if (face.area == 0) return {};
  const double g = gap + residual_gap_ + face.extra;
  double p = face.area / g;
  double p1 = -face.area / (g * g);
  double p2 = 2 * face.area / (g * g * g);
  for (const auto& e : face.edges) {
    const double a = 2 * e.flank;
    p += e.length * (half_cylinder + std::log(1 + a / g) / pi);
    p1 -= e.length / pi * a / (g * (g + a));
    p2 += e.length / pi * a * (2 * g + a) / (g * g * (g + a) * (g + a));
  }
  if (face.slot > 0) {
    const double x = face.slot / (2 * g), slope = 4 / pi * std::atan(x);
    const double gamma = x * slope - 2 / pi * std::log1p(x * x), bend = 4 / pi / (1 + x * x);
    const double half = 0.5 * face.slot_length;
    p += half * (2 * x - gamma);
    p1 -= half * (2 - slope) * x / g;
    p2 += half * ((2 - slope) * 2 * x - bend * x * x) / (g * g);
  }
  p *= vacuum;
  p1 *= vacuum;
  p2 *= vacuum;
  return {1 / p, -p1 / (p * p), (2 * p1 * p1 / p - p2) / (p * p)};
}

double CircuitPotential::core_flux(double psi, double ring, double gap) const {
  const Reluctance c = reluctance(centre_, gap);
  const Reluctance b = reluctance(bare_, gap);
  const bool shaded = has_ring();
  const double series = turns_ / leakage_;
  // convex: the slope rises everywhere, so Newton is kept between what is known to be too small and too large
  double low = -HUGE_VAL;
  double high = HUGE_VAL;
  double phi = psi / turns_;
  for (int k = 0; k < 100; ++k) {
    const Derivatives path = this->path(phi, gap);
    const double rest = shaded ? phi - ring : phi;
    const Derivatives tip = shaded ? iron(bare_tips_, rest) : Derivatives{};
    const double slope =
        path.first + tip.first + c.value * phi + b.value * rest - series * (psi - turns_ * phi);
    const double stiffness = path.second + tip.second + c.value + b.value + series * turns_;
    (slope > 0 ? high : low) = phi;
    const double step = -slope / stiffness;
    if (std::fabs(step) <= 1e-15 * (std::fabs(phi) + std::fabs(psi) / turns_)) return phi + step;
    double next = phi + step;
    const bool enclosed = std::isfinite(low) && std::isfinite(high);
    if (enclosed && !(next > low && next < high)) next = 0.5 * (low + high);
    if (next == phi) return phi;
    phi = next;
  }
  return phi;
}

MagneticResponse CircuitPotential::at(const MagneticState& state) const {
  const double gap = std::max(state.gap, 0.0);
  const bool shaded = has_ring();
  const double ring = shaded ? state.ring : 0;
  const double phi = core_flux(state.psi, ring, gap);
  const double rest = phi - ring;
  const Reluctance c = reluctance(centre_, gap);
  const Reluctance b = reluctance(bare_, gap);
  const Reluctance s = shaded ? reluctance(shaded_, gap) : Reluctance{};
  const Derivatives path = this->path(phi, gap);
  const Derivatives column = iron(column_, phi);
  const Derivatives tip_b = iron(bare_tips_, rest);
  const Derivatives tip_s = iron(shaded_tips_, ring);

  // with phi, ring and gap as independent: first and second derivatives
  const double m = path.first + tip_b.first + c.value * phi + b.value * rest;
  const double a = path.second + tip_b.second + c.value + b.value;
  const double phi_ring = -b.value - tip_b.second;
  const double ring_ring = b.value + tip_b.second + s.value + tip_s.second;
  const double phi_gap = c.slope * phi + b.slope * rest + column.first;
  const double ring_gap = s.slope * ring - b.slope * rest;
  const double gap_gap =
      0.5 * (c.curvature * phi * phi + b.curvature * rest * rest + s.curvature * ring * ring);

  // phi follows from psi: eliminate it
  const double series = turns_ / leakage_;
  const double stiffness = series * turns_ + a;
  const double link = series / stiffness;
  MagneticResponse r;
  r.current = m / turns_;
  r.energy = 0.5 * leakage_ * r.current * r.current + path.energy + tip_b.energy + tip_s.energy +
             0.5 * (c.value * phi * phi + b.value * rest * rest + s.value * ring * ring);
  r.pull = 0.5 * (c.slope * phi * phi + b.slope * rest * rest + s.slope * ring * ring) + column.energy;
  r.current_psi = a / (leakage_ * stiffness);
  r.current_gap = link * phi_gap;
  r.pull_gap = gap_gap - phi_gap * phi_gap / stiffness;
  if (!shaded) return r;
  r.ring_current = s.value * ring + tip_s.first - b.value * rest - tip_b.first;
  r.current_ring = link * phi_ring;
  r.ring_ring = ring_ring - phi_ring * phi_ring / stiffness;
  r.ring_gap = ring_gap - phi_ring * phi_gap / stiffness;
  return r;
}

}  // namespace powbench::sim
