#pragma once

/// Units. Everything inside powbench is SI (seconds, metres, newtons, volts, amperes, webers, radians, kelvin);
/// other units appear only at the edges (files, command line, reports), named in the key: `gap_mm`, `angle_deg`.
/// Shared with firmware: no heap, no exceptions, no library calls.

namespace powbench {

inline constexpr double pi = 3.141592653589793238462643383279502884;
inline constexpr double zero_celsius = 273.15;  ///< K

constexpr double radians(double degrees) {
  return degrees * (pi / 180.0);
}
constexpr double degrees(double radians) {
  return radians * (180.0 / pi);
}

}  // namespace powbench
