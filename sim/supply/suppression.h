#pragma once

#include <cmath>
#include <cstdint>

/// What lies across the coil and carries its current when the source does not.

namespace powbench::sim {

/// Four kinds; the numbers of the others are not read. Voltage at the coil while current i flows through it alone:
///
///   none      the current is cut, and what the flux loses is gone
///   diode     -(V_f + R_d i), i > 0; blocks the other way
///   varistor -sign(i) V_c (|i| / I_c)^e, below 1e-4 I_c as at that current; its current at the source's voltage is
///   left out rc v_c - R_c i, C dv_c/dt = -i; it also draws current while the coil is fed
struct Suppression {
  enum class Kind : std::uint8_t { none, diode, varistor, rc };
  Kind kind = Kind::none;
  double forward = 0.7;          ///< V_f, V, diode
  double resistance = 0;         ///< R_d or R_c, ohm, in series with diode or capacitor
  double capacitance = 1e-7;     ///< C, F, rc
  double clamp = 400;            ///< V_c, V, varistor
  double clamp_current = 1;      ///< I_c, A, varistor
  double clamp_exponent = 0.04;  ///< e, varistor
};

/// Magnitude of a varistor's voltage at a current >= 0, V; a smaller one counts as 1e-4 I_c.
template <class Real>
Real varistor_voltage(const Suppression& s, Real current) {
  constexpr Real floor = static_cast<Real>(1e-4);
  const Real share = current / static_cast<Real>(s.clamp_current);
  return static_cast<Real>(s.clamp) *
         std::pow(share > floor ? share : floor, static_cast<Real>(s.clamp_exponent));
}

/// Throws std::invalid_argument naming what is out of range.
void require_valid(const Suppression&);

}  // namespace powbench::sim
