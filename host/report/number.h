#pragma once

#include <string>
#include <string_view>

#include "core/events.h"

/// Numbers for people. What is not finite is shown as a dash, never as "nan".

namespace powbench::host {

inline constexpr std::string_view no_value = "\xE2\x80\x93";  // en dash

/// Fixed decimals (0 .. 9) with a true minus sign; a rounded zero has no sign.
std::string fixed(double value, int decimals);

/// `fixed` with the sign always shown, for differences.
std::string signed_fixed(double value, int decimals);

/// Decimals that show `u` with two significant digits; `fallback` when u is unknown or zero. Range 0 .. 4.
int decimals_for(double u, int fallback);

/// "11.842 ± 0.012", or "11.84" when the uncertainty is unknown, in units of 1/scale of SI. U = coverage u.
std::string with_uncertainty(const Measured&, double coverage, double scale, int fallback_decimals);

/// Unit people read and the factor from SI to it: s -> ms, A -> mA, m -> mm; others unchanged.
struct ReadableUnit {
  std::string_view name;
  double per_si = 1;
  int decimals = 2;
};
ReadableUnit readable_unit(std::string_view si_unit);

/// Angle in degrees with the degree sign, as many of at most two decimals as it needs.
std::string angle_text(double radians);

/// "at 60°", "at an angle not known".
std::string at_angle(double radians);

/// "5.96 to 6.03", or "5.96" where both read the same.
std::string range_of(double low, double high, int decimals);

/// First 12 characters of a hash.
std::string short_hash(const std::string&);

/// Flags in words, separated by commas; empty when none is set.
std::string flags_text(std::uint32_t flags);

}  // namespace powbench::host
