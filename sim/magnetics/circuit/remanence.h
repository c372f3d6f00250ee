#pragma once

#include <algorithm>
#include <cmath>

#include "sim/magnetics/potential.h"

/// Remanence of the iron as a coercive offset of the coil current, the same on every rung of fields:
///
///   i = dW/dpsi + i_h,   d i_h = (i_c dpsi - i_h |dpsi|) / psi_c,   |i_h| <= i_c = H_c l_fe / N,   psi_c = N A_c B_c
///
/// Where the flux rises i_h goes to +i_c, where it falls to -i_c, within B_c: without current the flux stays at
/// dW/dpsi = i_c. It does not depend on the rate, stores psi_c i_h^2 / (2 i_c) and loses |dpsi| i_h^2 / i_c, never less
/// than nothing. Leakage is counted as part of psi.

namespace powbench::sim {

struct Remanence {
  double current = 0;  ///< i_c, A; 0: the iron forgets
  double flux = 0;     ///< psi_c, Wb
  double residual =
      0;  ///< -1 .. 1: i_h at the start over -i_c, so that a positive one leaves a positive flux

  bool present() const { return current > 0; }

  /// d i_h / dpsi along a change of flux with this sign, A/Wb.
  template <class Real>
  Real stiffness(Real offset, bool rising) const {
    const Real c = static_cast<Real>(current);
    return (rising ? c - offset : c + offset) / static_cast<Real>(flux);
  }
  /// d i_h / dt, A/s.
  template <class Real>
  Real rate(Real offset, Real flux_rate) const {
    return stiffness(offset, flux_rate > 0) * flux_rate;
  }
  /// Power lost, W.
  template <class Real>
  Real loss(Real offset, Real flux_rate) const {
    return std::fabs(flux_rate) * offset * offset / static_cast<Real>(current);
  }
  /// J; zero where there is no remanence.
  double stored(double offset) const { return present() ? flux * offset * offset / (2 * current) : 0.0; }
  /// i_h after the flux has changed by `change` Wb without turning.
  double after(double offset, double change) const {
    const double limit = change > 0 ? current : -current;
    return limit + (offset - limit) * std::exp(-std::fabs(change) / flux);
  }
  double start() const { return -residual * current; }
};

/// Of a coil at one state of its flux: dW/dpsi and the flux linkage, and their slopes by that state.
struct CoilPoint {
  double current = 0, current_slope = 0;
  double linkage = 0, linkage_slope = 0;
};

/// Brings the current of a coil that was cut to zero, by Newton, with what the iron remembers of the way: moves
/// `state`, of which `at()` tells a CoilPoint, and returns i_h there, which was `offset`.
template <class Real, class At>
double remove_current(const Remanence& iron, Real& state, double offset, const At& at) {
  const double before = at().linkage;
  double now = offset;
  for (int pass = 0; pass < 100; ++pass) {
    const CoilPoint p = at();
    double miss = p.current, slope = p.current_slope;
    if (iron.present()) {
      const double gone = p.linkage - before;
      now = iron.after(offset, gone);
      miss += now;
      slope += iron.stiffness(now, gone > 0) * p.linkage_slope;
    }
    state -= static_cast<Real>(miss / slope);
    if (std::fabs(miss / slope) <= 1e-15 * std::fabs(static_cast<double>(state))) break;
  }
  return now;
}

/// The state without coil and ring current that an offset i_h leaves at a gap: dW/dpsi = -i_h, dW/dphi_s = 0. Its
/// pull is what holds a closed core when the coil is off.
MagneticState remanent_state(const MagneticPotential&, double offset, double gap);

}  // namespace powbench::sim
