#pragma once

#include "sim/models/plant.h"

/// The coil on the mains with the core held: what catalogues print as inrush and holding power.

namespace powbench::sim {

/// Coil current with the core held at `separation` (core.travel = open, 0 = closed), A rms over the third mains period
/// after a switch-on that leaves no offset in a pure inductance. Coil at 20 degC; the mains' fundamental alone.
double steady_current(const Specimen&, const Mains&, double separation);

struct SteadyCurrents {
  double open = 0, closed = 0;  ///< A rms
};
/// The same with the core held open and closed, to the bit, in hardly more than the time of one.
SteadyCurrents steady_currents(const Specimen&, const Mains&);

/// Apparent power U I with the core held open, VA.
inline double inrush_power(const Specimen& s, const Mains& m) {
  return m.volts * steady_current(s, m, s.core.travel);
}
/// The same with the core closed.
inline double holding_power(const Specimen& s, const Mains& m) {
  return m.volts * steady_current(s, m, 0);
}

/// Least pull on the closed core while the offset of a switch-on at voltage zero dies out, N: over five mains periods
/// after the first half-wave. All offsets are passed through on the way, among them the one that takes the most from
/// the shaded half-waves.
double least_pull(const Specimen&, const Mains&);

/// What that pull works against: return spring and contact springs with the core closed, N.
double closed_load(const Specimen&);

}  // namespace powbench::sim
