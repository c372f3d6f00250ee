#include "sim/specimen/specimen_potential.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {

std::string no_circuit(const Specimen& s) {
  if (s.lumped) return "";
  return "specimen '" + s.name +
         "' is a drawing without a lumped circuit: fields = table is its magnet; for the circuit "
         "[magnet] pole_area_mm2 and iron_length_mm have to be given (`powbench specimen circuit` finds "
         "them)";
}

void require_circuit(const Specimen& s) {
  if (const std::string why = no_circuit(s); !why.empty()) throw std::invalid_argument(why);
}

SpecimenPotential::SpecimenPotential(const Specimen& s)
    : circuit_(s.magnet, s.core.travel), turns_(s.coil.turns), leakage_(s.coil.leakage) {
  require_circuit(s);
}

MagneticResponse SpecimenPotential::at(const MagneticState& s) const {
  const bool ring = circuit_.has_ring();
  const double share = circuit_.shaded_share();
  const double per_turn = 1 / turns_, ratio = leakage_ * per_turn;  // L i = ratio * mmf
  const double phi = circuit_.flux(s.psi, turns_, ratio, s.ring, s.gap);
  const Field f = circuit_.field(phi, ring ? s.ring : share * phi, s.gap);
  const double stiff = ring ? f.mmf_phi : f.mmf_phi + share * f.mmf_phi2;  // with what follows phi
  const double slope = 1 / (turns_ + ratio * stiff);                       // d phi / d psi
  MagneticResponse r;
  r.current = f.mmf * per_turn;
  r.energy = f.energy + 0.5 * leakage_ * r.current * r.current;
  r.ring_current = ring ? f.ring_current : 0.0;
  r.pull = f.pull;
  r.current_psi = stiff * slope * per_turn;
  // at constant psi: N dphi + ratio dmmf = 0, dmmf = stiff dphi + mmf_x dx
  const double keeps = 1 - ratio * stiff * slope;
  r.current_gap = f.mmf_separation * keeps * per_turn;
  const double phi_gap = -ratio * f.mmf_separation * slope;
  r.pull_gap = f.pull_separation + f.mmf_separation * phi_gap;
  if (!ring) return r;
  r.current_ring = f.mmf_phi2 * keeps * per_turn;
  r.ring_ring = f.ring_phi2 - ratio * f.mmf_phi2 * f.mmf_phi2 * slope;
  r.ring_gap = f.ring_separation + f.mmf_phi2 * phi_gap;
  return r;
}

}  // namespace powbench::sim
