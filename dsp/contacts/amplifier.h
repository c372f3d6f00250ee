#pragma once

#include <array>
#include <cstddef>

/// What the low-pass of a charge amplifier makes of the start and the end of a force.
///
/// The amplifier is taken for a maximally flat low-pass of second order, H(s) = 1 / (1 + sqrt(2) s / w + (s / w)^2),
/// whose group delay at low frequency is D = sqrt(2) / w: the delay that the calibration of the channel states, and
/// that is already taken out of the time axis. A power of time then shows as
///   touch:    G+(x) = integral h(s) max(0, x + 1 - s)^p ds,
///   release:  G-(x) = integral h(s) max(0, x - 1 + s)^p ds,
/// with x the time into the contact in units of D. Far inside both are x^p: the second cumulant of h is zero.

namespace powbench::dsp {

inline constexpr std::size_t quarter_powers = 17;  ///< p = 0, 0.25 .. 4
using QuarterPowers = std::array<double, quarter_powers>;

/// x in units of D between which G differs from x^p by more than a thousandth: touches start at -1.
inline constexpr double smoothed_from_touch = -1, smoothed_from_release = -4.5, smoothed_to = 4;

/// G(x) of all p for `side` +1 (touch) or -1 (release); x within the range above, from a table of 1/64 by straight
/// lines: error below 1e-3.
void smoothed_powers(double x, int side, QuarterPowers&);

/// Standard uncertainty that the amplifier leaves on an edge dated with its response: its corner is known to a tenth.
inline constexpr double amplifier_share = 0.1;  ///< of D

}  // namespace powbench::dsp
