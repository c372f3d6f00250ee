#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/magnetics/plane/field_transient.h"

/// The mechanics and the ledger of a closing by the implicit midpoint rule, common to all rungs. A `Rung` has
///
///   advance(voltage, gap, step) -> Middle: the fluxes one step further,   stored(gap): J,   iterations: so far.

namespace powbench::sim {

/// What a rung answers at the middle of a step.
struct Middle {
  double psi = 0;  ///< coil, at the middle
  double current = 0, ring_current = 0, pull = 0, eddy_power = 0;
};

/// Wb, of the coil at the start: that of a permanent magnet, where the rung has one.
template <class Rung>
double start_flux(const Rung& rung) {
  if constexpr (requires { rung.flux(); })
    return rung.flux();
  else
    return 0;
}

/// Throws std::invalid_argument for a bad setup.
template <class Rung>
TransientResult march(Rung& rung, const TransientSetup& s) {
  if (!(s.step > 0 && s.duration > 0 && s.mass > 0 && s.resistance >= 0 && s.start_gap >= 0 && s.voltage))
    throw std::invalid_argument(
        "transient: step, duration and mass must be above 0, resistance and gap not below, a voltage is "
        "needed");
  TransientResult out;
  const int steps = static_cast<int>(std::lround(s.duration / s.step));
  double gap = s.start_gap, velocity = 0, psi = start_flux(rung);
  const double before = rung.stored(gap);
  auto& e = out.energy;
  for (int k = 0; k < steps; ++k) {
    const double middle_time = (k + 0.5) * s.step;
    const double voltage = s.voltage(middle_time);
    const double middle_gap = s.moves ? std::clamp(gap - 0.5 * s.step * velocity, 0.0, s.start_gap) : gap;
    const Middle m = rung.advance(voltage, middle_gap, s.step);
    psi = 2 * m.psi - psi;
    const double old_gap = gap, old_velocity = velocity;
    if (s.moves) {
      const double counter = s.counter_force ? s.counter_force(middle_gap) : 0;
      velocity += s.step * (m.pull - counter) / s.mass;
      gap -= 0.5 * s.step * (old_velocity + velocity);
      if (gap <= 0 || gap >= s.start_gap) {
        if (gap <= 0 && out.closed_at < 0) {
          const double way = old_gap - gap;
          out.closed_at = (k + (way > 0 ? old_gap / way : 0)) * s.step;
        }
        gap = std::clamp(gap, 0.0, s.start_gap);
        velocity = 0;
      }
    }
    e.supplied += s.step * voltage * m.current;
    e.coil_loss += s.step * s.resistance * m.current * m.current;
    e.ring_loss += s.step * s.ring_resistance * m.ring_current * m.ring_current;
    e.eddy_loss += s.step * m.eddy_power;
    e.mechanical += m.pull * (old_gap - gap);
    out.samples.push_back({(k + 1) * s.step, psi, m.current, m.ring_current, gap, velocity, m.pull});
  }
  e.stored = rung.stored(gap) - before;
  out.iterations = rung.iterations;
  return out;
}

}  // namespace powbench::sim
