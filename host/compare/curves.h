#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

/// How far a simulated curve is from a measured one.

namespace powbench::host {

/// Value i was taken t0 + i dt after switch-on; what is not finite was not measured.
struct Curve {
  double t0 = 0, dt = 0;  ///< s
  std::span<const float> values;
};

/// Where two curves differ most, as paper A states it for coil current (i_m) and travel (x_m): both values at that
/// instant, their distance, and that over the measured one. Near a zero of the measured value that share says
/// nothing: the rms of the difference over the span of the measured curve and the delay that explains most of it
/// stand beside it.
struct CurveDeviation {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double largest = none;    ///< |simulated - measured|, unit of the curves
  double at = none;         ///< s
  double measured = none;   ///< there
  double simulated = none;  ///< there
  double rms_share = none;  ///< rms of the difference over (highest - lowest) of the measured curve
  double late =
      none;  ///< s the simulated curve comes later: least squares of the difference by the measured slope

  double share() const { return largest / (measured < 0 ? -measured : measured); }  ///< of the measured value
};

/// Both curves are averaged over this, s: the largest difference of two noisy curves would else be their noise.
inline constexpr double curve_bin = 0.1e-3;

/// Over 0 .. `end` s after switch-on, each curve counted from its mean over the 2 ms before. All unknown where the
/// curves have fewer than ten bins in common. Throws std::invalid_argument for a dt that is not above 0.
CurveDeviation curve_deviation(const Curve& measured, const Curve& simulated, double end);

/// One curve at one closing angle.
struct CurveRow {
  std::string quantity;      ///< i_m, x_m
  std::string unit;          ///< SI
  double closing_angle = 0;  ///< rad, polarity included
  int repeats = 0;
  CurveDeviation
      median;  ///< of the shot whose largest difference is the median of the repeats, the lower of two
};
CurveRow curve_row(std::string quantity, std::string unit, double closing_angle,
                   std::vector<CurveDeviation> repeats);

}  // namespace powbench::host
