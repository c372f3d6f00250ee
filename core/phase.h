#pragma once

#include <cstdint>

#include "core/units.h"

/// Phase arithmetic. The closing angle is the phase of the coil voltage at switch-on: u(t) = sqrt(2) U sin(2 pi f t +
/// theta), so 0 deg is the rising zero crossing. On the wire and in firmware an angle is an integer in hundredths of
/// a degree. Shared with firmware: no heap, no exceptions, no library calls.

namespace powbench {

/// Angle in hundredths of a degree, 0 .. 35999.
using CentiDegrees = std::int32_t;
inline constexpr CentiDegrees full_turn_centi = 36000;

/// Angle mapped to [0, 2 pi). Range: |angle| < 1e9 rad.
constexpr double wrap_turn(double angle) {
  const double turns = angle / (2 * pi);
  auto whole = static_cast<long long>(turns);
  if (static_cast<double>(whole) > turns) --whole;
  const double wrapped = angle - 2 * pi * static_cast<double>(whole);
  return wrapped >= 2 * pi ? 0.0 : (wrapped < 0 ? 0.0 : wrapped);
}

/// Angle mapped to [-pi, pi): the difference of two phases.
constexpr double wrap_half_turn(double angle) {
  return wrap_turn(angle + pi) - pi;
}

/// Nearest hundredth of a degree, 0 .. 35999.
constexpr CentiDegrees to_centi_degrees(double angle) {
  const auto centi = static_cast<CentiDegrees>(degrees(wrap_turn(angle)) * 100.0 + 0.5);
  return centi >= full_turn_centi ? centi - full_turn_centi : centi;
}

}  // namespace powbench
