#pragma once

#include "sim/models/rigid_run.h"

namespace powbench::sim {

/// A gapped core without iron: W = psi^2 / (2 L(g)), L = L0 + a / (g + d).
class GapInductance : public MagneticPotential {
 public:
  bool has_ring() const override { return false; }
  MagneticResponse at(const MagneticState& s) const override {
    const double wide = s.gap + residual;
    const double l = leak + area / wide;
    const double dl = -area / (wide * wide);
    MagneticResponse r;
    r.energy = s.psi * s.psi / (2 * l);
    r.current = s.psi / l;
    r.pull = -s.psi * s.psi * dl / (2 * l * l);  // positive: the energy grows with the gap at equal flux
    r.current_psi = 1 / l;
    r.current_gap = -s.psi * dl / (l * l);
    return r;
  }
  double leak = 0.25, area = 7e-4, residual = 3e-4;
};

}  // namespace powbench::sim
