#include "sim/solid/lumped_potential.h"

#include <cmath>

namespace powbench::sim {

LumpedPotential::LumpedPotential(const Specimen& s)
    : circuit_(s.magnet, s.core.travel), turns_(s.coil.turns), leakage_(s.coil.leakage) {}

MagneticResponse LumpedPotential::first(const MagneticState& state) const {
  // psi = N phi + L mmf(phi) / N, solved for the flux phi; the left side grows with phi, and Newton from above converges
  double phi = state.psi / turns_, phi2 = state.ring;
  for (int k = 0; k < 60; ++k) {
    if (!circuit_.has_ring()) phi2 = circuit_.shaded_share() * phi;
    const Field f = circuit_.field(phi, phi2, state.gap);
    const double slope = f.mmf_phi + (circuit_.has_ring() ? 0 : circuit_.shaded_share() * f.mmf_phi2);
    const double step =
        (turns_ * phi + leakage_ * f.mmf / turns_ - state.psi) / (turns_ + leakage_ * slope / turns_);
    phi -= step;
    if (std::fabs(step) <= 1e-15 * std::fabs(phi)) break;
  }
  if (!circuit_.has_ring()) phi2 = circuit_.shaded_share() * phi;
  const Field f = circuit_.field(phi, phi2, state.gap);
  MagneticResponse r;
  r.current = f.mmf / turns_;
  r.energy = circuit_.energy(phi, phi2, state.gap) + 0.5 * leakage_ * r.current * r.current;
  r.ring_current = circuit_.has_ring() ? f.ring_current : 0;
  r.pull = f.pull;
  return r;
}

MagneticResponse LumpedPotential::at(const MagneticState& state) const {
  MagneticResponse r = first(state);
  const auto slope = [&](double MagneticState::*by, double step, double MagneticResponse::*of) {
    MagneticState up = state, down = state;
    up.*by += step;
    down.*by -= step;
    return (first(up).*of - first(down).*of) / (2 * step);
  };
  const double psi = 1e-5 * (1 + std::fabs(state.psi)), ring = 1e-8, gap = 1e-8;
  r.current_psi = slope(&MagneticState::psi, psi, &MagneticResponse::current);
  r.current_ring = slope(&MagneticState::ring, ring, &MagneticResponse::current);
  r.ring_ring = slope(&MagneticState::ring, ring, &MagneticResponse::ring_current);
  r.current_gap = slope(&MagneticState::gap, gap, &MagneticResponse::current);
  r.ring_gap = slope(&MagneticState::gap, gap, &MagneticResponse::ring_current);
  r.pull_gap = slope(&MagneticState::gap, gap, &MagneticResponse::pull);
  return r;
}

}  // namespace powbench::sim
