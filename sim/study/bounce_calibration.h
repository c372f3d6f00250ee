#pragma once

#include <limits>
#include <span>
#include <vector>

/// What bounces that were measured say where touch and seat say nothing: restitution and springs of the contacts lengthen or shorten
/// all bounces of a device by much the same factor, and barely move anything else.

namespace powbench::sim {

/// Deviations are root mean squares of ln(measured / predicted); three closings or more, else NaN.
struct BounceCalibration {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double>
      factors;  ///< of each draw: median over the closings of measured / simulated; 1: none measured
  /// Of single draws, over draws and closings: predicted is simulated times the factor by the other closings. The draw has seen touch
  /// and seat of each of these closings, and its median over the draws may be nearer; a device is one draw.
  double deviation = nan;
  double median = nan;            ///< of the measured bounces, s: what is predicted without any model
  double median_deviation = nan;  ///< of each measured bounce from the median of the others
};

/// `simulated`: for each draw the bounce of each closing, s; NaN where it does not close. `measured`: of each closing, s; NaN where not
/// measured. What does not close or bounces for less than 20 us counts as 20 us: it is far off, not left out.
BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured);

/// Share of the draws in what is predicted, the rest being the plain median's: w = u^2 / (u^2 + v^2), v and u the deviations of
/// the draws and of that median, assumed to be independent. A model that is off where it can be judged weighs little. 1 where both
/// are 0, NaN where they are not known.
double weight_of_draws(const BounceCalibration&);

/// A bounce at an angle that was not seen, s, and the deviation of its logarithm that must be expected.
struct PooledBounce {
  double value = 0, deviation = 0;
};

/// `own`: median over the draws of factor x simulated at that angle, s. It is pooled with the plain median m in the logarithm,
///   ln b = w ln own + (1 - w) ln m,   deviation = sqrt(w) v,   w = weight_of_draws.
/// Where w is not known, `own` stands alone and has no deviation (NaN).
PooledBounce pooled_bounce(double own, const BounceCalibration&);

}  // namespace powbench::sim
