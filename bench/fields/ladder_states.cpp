#include "bench/fields/ladder_states.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/magnetics/space/magnet_field.h"

namespace powbench::bench {
namespace {

constexpr double gaps[] = {0, 0.2e-3, 1e-3, 4e-3};
constexpr double currents[] = {0.05, 0.2, 0.8};

/// Newton on the convex function W - i psi, cut until it falls.
FieldState at_current(const sim::MagneticPotential& p, FieldState s, double ring) {
  double psi = s.flux;
  const bool bound = p.has_ring();
  if (!bound) ring = 0;
  auto r = p.at({psi, ring, s.gap});
  for (int k = 0; k < 100; ++k) {
    const double f = r.current - s.current, g = r.ring_current;
    if (std::fabs(f) < 1e-12 && std::fabs(g) < 1e-9) break;
    const double det = bound ? r.current_psi * r.ring_ring - r.current_ring * r.current_ring : r.current_psi;
    const double dpsi = bound ? -(f * r.ring_ring - g * r.current_ring) / det : -f / det,
                 dring = bound ? -(r.current_psi * g - r.current_ring * f) / det : 0;
    const double here = r.energy - s.current * psi, slope = f * dpsi + g * dring;
    double t = 1;
    for (;; t *= 0.5) {
      const auto next = p.at({psi + t * dpsi, ring + t * dring, s.gap});
      if (next.energy - s.current * (psi + t * dpsi) <= here + 1e-4 * t * slope + 1e-15 * std::fabs(here)) {
        r = next;
        break;
      }
      if (t < 1e-10) throw std::runtime_error("no flux for this current");
    }
    psi += t * dpsi;
    ring += t * dring;
    if (std::fabs(dpsi) < 1e-12 * std::fabs(psi)) break;
  }
  if (!(std::fabs(r.current / s.current - 1) < 1e-6)) throw std::runtime_error("no flux for this current");
  return {s.gap, s.current, psi, r.pull};
}

/// All states by a function of (gap, current).
template <class Solve>
FieldStates all(const Solve& solve) {
  FieldStates list;
  for (const double gap : gaps)
    for (const double current : currents) {
      const auto [flux, pull] = solve(gap, current);
      list.push_back({gap, current, flux, pull});
    }
  return list;
}

}  // namespace

FieldStates states_of(const sim::MagnetDesign& design, const sim::FieldOptions& options) {
  sim::MagnetField field(design, options);
  return all([&](double gap, double current) {
    field.set_gap(gap);
    const auto p = field.at_current(current, 0);
    return std::pair(field.fluxes(p).first, p.response.pull);
  });
}

FieldStates states_of(const sim::MagnetDesign& design, const sim::space::CoreMeshSizes& sizes) {
  sim::space::MagnetField field(design, sizes);
  return all([&](double gap, double current) {
    field.set_gap(gap);
    const auto p = field.at_current(current);
    return std::pair(p.psi, p.response.pull);
  });
}

FieldStates states_of(const sim::MagneticPotential& p, const FieldStates& guess) {
  FieldStates list;
  for (const auto& s : guess) list.push_back(at_current(p, s, 0.25 * s.flux / 2000));
  return list;
}

std::pair<double, double> worst(const FieldStates& states, const FieldStates& truth) {
  double flux = 0, pull = 0;
  for (std::size_t k = 0; k < std::min(states.size(), truth.size()); ++k) {
    flux = std::max(flux, std::fabs(states[k].flux / truth[k].flux - 1));
    if (truth[k].pull > 1) pull = std::max(pull, std::fabs(states[k].pull / truth[k].pull - 1));
  }
  return {flux, pull};
}

}  // namespace powbench::bench
