#pragma once

#include <algorithm>
#include <cmath>

#include "core/units.h"

/// A contact that only presses: F = max(0, k pen + c pen'), pen > 0.
///
/// It is pressed from the instant pen reaches zero until F does; between that and pen = 0 it is free though
/// still indented (its layer relaxes by itself). Only these two modes are needed: pressed is left when F < 0,
/// free is left when both pen and F are positive.

namespace powbench::sim {

/// Damping ratio whose free oscillation returns with restitution e: zeta = -ln e / sqrt(pi^2 + ln^2 e). e = 0
/// gives 1.
inline double damping_ratio(double restitution) {
  if (restitution <= 0) return 1;
  const double log_e = std::log(restitution);
  return -log_e / std::sqrt(pi * pi + log_e * log_e);
}

/// Rebound over approach velocity of a mass on such a contact, which may not pull:
/// e = exp(-tan b (pi - 2 b)), b = asin zeta. Larger than the e that zeta came from.
inline double rebound_ratio(double zeta) {
  const double b = std::asin(zeta);
  return std::exp(-std::tan(b) * (pi - 2 * b));
}

struct Unilateral {
  double stiffness = 0;  ///< k, N/m
  double damping = 0;    ///< c, N s/m
  bool pressed = false;

  static Unilateral with_ratio(double stiffness, double zeta, double mass) {
    return {stiffness, 2 * zeta * std::sqrt(stiffness * mass), false};
  }
  double force(double pen, double rate) const { return pressed ? stiffness * pen + damping * rate : 0.0; }
  /// > 0 while the mode stays valid, m.
  double guard(double pen, double rate) const {
    const double reduced = pen + damping / stiffness * rate;
    return pressed ? reduced : -std::min(pen, reduced);
  }
  double stored(double pen) const { return pen > 0 ? 0.5 * stiffness * pen * pen : 0.0; }
  /// W lost in the layer.
  double loss(double pen, double rate, double force) const {
    return (force - stiffness * std::max(pen, 0.0)) * rate;
  }
};

}  // namespace powbench::sim
