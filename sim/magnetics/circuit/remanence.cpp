#include "sim/magnetics/circuit/remanence.h"

namespace powbench::sim {

MagneticState remanent_state(const MagneticPotential& potential, double offset, double gap) {
  const bool ring = potential.has_ring();
  MagneticState s{0, 0, gap};
  for (int pass = 0; pass < 100; ++pass) {
    const MagneticResponse m = potential.at(s);
    const double miss = m.current + offset;
    const double cross = ring ? m.current_ring : 0;
    const double own = ring ? m.ring_ring : 1;
    const double det = m.current_psi * own - cross * cross;
    const double change = (own * miss - cross * m.ring_current) / det;
    s.psi -= change;
    if (ring) s.ring -= (m.current_psi * m.ring_current - cross * miss) / det;
    if (std::fabs(change) <= 1e-15 * std::fabs(s.psi)) break;
  }
  return s;
}

}  // namespace powbench::sim
