#pragma once

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "sim/magnetics/circuit/one_number.h"

/// A contact that only presses: F = max(0, k pen + c pen'), pen > 0.
///
/// It is pressed from the instant pen reaches zero until F does; between that and pen = 0 it is free though
/// still indented (its layer relaxes by itself). Only these two modes are needed: pressed is left when F < 0,
/// free is left when both pen and F are positive.

namespace powbench::sim {

/// Rebound over approach velocity of a mass on such a contact, with zeta = c / (2 sqrt(k m)):
/// e = exp(-2 zeta acos(zeta) / sqrt(1 - zeta^2)); beyond zeta = 1, where it is exp(-2), with acosh and zeta^2 - 1.
inline double rebound_ratio(double zeta) {
  const double side = 1 - zeta * zeta;
  if (std::fabs(side) < 1e-8) return std::exp(-2.0 - 4.0 / 3.0 * (zeta - 1));
  const double angle = side > 0 ? std::acos(zeta) : std::acosh(zeta);
  return std::exp(-2 * zeta * angle / std::sqrt(std::fabs(side)));
}

/// The damping ratio of a rebound 0 < e <= 1: the inverse of `rebound_ratio`, by Newton. -ln e is a concave function of
/// zeta with slope pi at 0, so that each step stays below the root.
inline double rebound_damping_ratio(double rebound) {
  const double wanted = -std::log(rebound);
  if (wanted <= 0) return 0;
  double zeta = wanted / pi;
  for (int i = 0; i < 60; ++i) {
    const double side = 1 - zeta * zeta, here = -std::log(rebound_ratio(zeta));
    const double g = here / (2 * zeta);
    const double slope = std::fabs(side) < 1e-6 ? 4.0 / 3 : 2 * g + 2 * zeta * (zeta * g - 1) / side;
    const double step = (wanted - here) / slope;
    zeta += step;
    if (std::fabs(step) <= 1e-15 * zeta) break;
  }
  return zeta;
}

template <class Of, class T>
POWBENCH_EQUATION T contact_force(typename Of::Mask pressed, T stiffness, T damping, T pen, T rate) {
  return Of::choose(
      pressed, [&] { return stiffness * pen + damping * rate; }, [&] { return Of::all(0.0); });
}
/// > 0 while the mode stays valid, m. `damping_time` = damping / stiffness.
template <class Of, class T>
POWBENCH_EQUATION T contact_guard(typename Of::Mask pressed, T damping_time, T pen, T rate) {
  const T reduced = pen + damping_time * rate;
  return Of::choose(
      pressed, [&] { return reduced; },
      [&] {
        return -Of::choose(
            reduced < pen, [&] { return reduced; }, [&] { return pen; });
      });
}
/// W lost in the layer.
template <class Of, class T>
POWBENCH_EQUATION T contact_loss(T stiffness, T pen, T rate, T force) {
  const T pressing = Of::choose(
      pen < 0.0, [&] { return Of::all(0.0); }, [&] { return pen; });
  return (force - stiffness * pressing) * rate;
}

struct Unilateral {
  double stiffness = 0;  ///< k, N/m
  double damping = 0;    ///< c, N s/m
  bool pressed = false;

  static Unilateral with_ratio(double stiffness, double zeta, double mass) {
    return {stiffness, 2 * zeta * std::sqrt(stiffness * mass), false};
  }
  double force(double pen, double rate) const {
    return contact_force<OneNumber>(pressed, stiffness, damping, pen, rate);
  }
  /// > 0 while the mode stays valid, m.
  double guard(double pen, double rate) const {
    return contact_guard<OneNumber>(pressed, damping / stiffness, pen, rate);
  }
  double stored(double pen) const { return pen > 0 ? 0.5 * stiffness * pen * pen : 0.0; }
  /// W lost in the layer.
  double loss(double pen, double rate, double force) const {
    return contact_loss<OneNumber>(stiffness, pen, rate, force);
  }
};

}  // namespace powbench::sim
