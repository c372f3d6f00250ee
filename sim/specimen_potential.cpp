#include "sim/specimen_potential.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {

void require_circuit(const Specimen& s) {
  if (!s.lumped)
    throw std::invalid_argument(
        "specimen '" + s.name +
        "' is a drawing without a lumped circuit: fields = table is its magnet; for the circuit "
        "[magnet] pole_area_mm2 and iron_length_mm have to be given");
}

SpecimenPotential::SpecimenPotential(const Specimen& s)
    : circuit_(s.magnet, s.core.travel), turns_(s.coil.turns), leakage_(s.coil.leakage) {
  require_circuit(s);
}

MagneticResponse SpecimenPotential::at(const MagneticState& s) const {
  const bool ring = circuit_.has_ring();
  const double share = circuit_.shaded_share();
  const double ratio = leakage_ / turns_;  // L i = ratio * mmf
  double phi = s.psi / turns_;  // beyond the answer, where the curve is steep: Newton comes down from there
  Field f;
  double stiff = 0;  // d mmf / d phi with what follows phi
  for (int pass = 0; pass < 100; ++pass) {
    const double phi2 = ring ? s.ring : share * phi;
    f = circuit_.field(phi, phi2, s.gap);
    stiff = ring ? f.mmf_phi : f.mmf_phi + share * f.mmf_phi2;
    const double change = (s.psi - turns_ * phi - ratio * f.mmf) / (turns_ + ratio * stiff);
    phi += change;
    if (std::fabs(change) <= 1e-15 * (std::fabs(phi) + 1e-12)) break;
  }
  const double phi2 = ring ? s.ring : share * phi;
  f = circuit_.field(phi, phi2, s.gap);
  const double slope = 1 / (turns_ + ratio * stiff);  // d phi / d psi
  MagneticResponse r;
  r.current = f.mmf / turns_;
  r.energy = circuit_.energy(phi, phi2, s.gap) + 0.5 * leakage_ * r.current * r.current;
  r.ring_current = ring ? f.ring_current : 0.0;
  r.pull = f.pull;
  r.current_psi = stiff * slope / turns_;
  // at constant psi: N dphi + ratio dmmf = 0, dmmf = stiff dphi + mmf_x dx
  const double keeps = 1 - ratio * stiff * slope;
  r.current_gap = f.mmf_separation * keeps / turns_;
  const double phi_gap = -ratio * f.mmf_separation * slope;
  r.pull_gap = f.pull_separation + f.mmf_separation * phi_gap;
  if (!ring) return r;
  r.current_ring = f.mmf_phi2 * keeps / turns_;
  r.ring_ring = f.ring_phi2 - ratio * f.mmf_phi2 * f.mmf_phi2 * slope;
  r.ring_gap = f.ring_separation + f.mmf_phi2 * phi_gap;
  return r;
}

}  // namespace powbench::sim
