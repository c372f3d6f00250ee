#pragma once

#include <limits>
#include <span>
#include <vector>

/// What bounces that were measured say where touch and seat say nothing: restitution and springs of the contacts lengthen or shorten
/// all bounces of a device by much the same factor, and barely move anything else.

namespace powbench::sim {

/// Deviations are root mean squares of ln(measured / predicted), each closing predicted from the others alone. NaN: not known.
struct BounceCalibration {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double>
      factors;             ///< of each draw: median over the closings of measured / simulated; 1: not told
  double deviation = nan;  ///< of factor x simulated, over draws and closings; three of those or more
  double median = nan;     ///< of the measured bounces, s: what is predicted without any model
  double median_deviation = nan;  ///< of that
};

/// `simulated`: for each draw the bounce of each closing, s; NaN where it does not close. `measured`: of each closing; NaN where not
/// measured.
BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured);

/// A bounce at an angle that was not seen, s, and the relative deviation that must be expected.
struct PooledBounce {
  double value = 0, deviation = 0;
};

/// `own`: median over the draws of factor x simulated at that angle, s. It is pooled with the plain median m in the logarithm,
///   ln b = w ln own + (1 - w) ln m,   w = u^2 / (u^2 + v^2),   deviation = u v / sqrt(u^2 + v^2),
/// v and u the deviations of the draws and of m, as independent ones: a model that is off where it can be judged weighs little.
/// Where they are not known, `own` stands alone and has no deviation.
PooledBounce pooled_bounce(double own, const BounceCalibration&);

}  // namespace powbench::sim
