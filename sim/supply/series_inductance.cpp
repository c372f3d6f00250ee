#include "sim/supply/series_inductance.h"

#include <cmath>

#include "sim/supply/refuse.h"

namespace powbench::sim {

SeriesInductance::SeriesInductance(const MagneticPotential& coil, double inductance)
    : coil_(coil), inductance_(inductance) {
  require_range("series inductance", inductance, 1e-15, 1e6, "H");
}

MagneticResponse SeriesInductance::at(const MagneticState& s) const {
  const double l = inductance_;
  MagneticState coil = s;
  MagneticResponse m = coil_.at(coil);
  // psi + L i(psi) rises with psi, its slope 1 + L di/dpsi is at least 1: the miss bounds the error of psi
  double low = -HUGE_VAL;
  double high = HUGE_VAL;
  for (int pass = 0; pass < 200; ++pass) {
    const double miss = coil.psi + l * m.current - s.psi;
    (miss > 0 ? high : low) = coil.psi;
    double next = coil.psi - miss / (1 + l * m.current_psi);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (!std::isfinite(next) || next == coil.psi) break;
    const bool last = std::fabs(next - coil.psi) <= 1e-15 * std::fabs(next);
    coil.psi = next;
    m = coil_.at(coil);
    if (last) break;
  }
  const double share = 1 / (1 + l * m.current_psi);  // d psi / d lambda
  MagneticResponse r = m;
  r.energy += 0.5 * l * m.current * m.current;
  r.current_psi *= share;
  r.current_ring *= share;
  r.current_gap *= share;
  r.ring_ring -= l * share * m.current_ring * m.current_ring;
  r.ring_gap -= l * share * m.current_ring * m.current_gap;
  r.pull_gap -= l * share * m.current_gap * m.current_gap;
  return r;
}

}  // namespace powbench::sim
