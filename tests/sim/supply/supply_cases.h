#pragma once

#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/models/closing.h"

/// What the tests of the supply share.

namespace powbench::sim {

/// A contactor whose core, base and bridges cannot move and whose iron is linear, without a ring: R and L alone.
inline Specimen plain_coil() {
  Specimen s;
  s.core.return_preload = 5000;
  s.core.friction = 1000;
  s.base.mass = 1000;
  s.base.hertz = 3000;
  s.base.damping = 1;
  s.magnet.shaded_share = 0;
  s.magnet.bh_power = 0;
  return s;
}

/// L of the plain coil with its core open, H.
inline double open_inductance(const Specimen& s) {
  const auto& m = s.magnet;
  const double gap = s.core.travel + m.residual_gap;
  const double r = gap / (mu0 * m.pole_area * (1 + m.fringing * gap / std::sqrt(m.pole_area)));
  return s.coil.leakage + s.coil.turns * s.coil.turns / (m.bh_linear * m.iron_length / m.pole_area + 2 * r);
}

inline Conditions at_angle(double degrees, double volts = 230) {
  Conditions c;
  c.closing_angle = radians(degrees);
  c.supply_volts = volts;
  return c;
}

}  // namespace powbench::sim
