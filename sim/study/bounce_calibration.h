#pragma once

#include <limits>
#include <span>
#include <vector>

/// What measured bounces add to touch and seat: restitution and springs of the contacts scale all bounces of a device
/// by nearly the same factor and hardly change anything else.

namespace powbench::sim {

/// Deviations are root mean squares of ln(measured / predicted); three closings or more, else NaN.
struct BounceCalibration {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double>
      factors;  ///< of each posterior sample: median over the closings of measured / simulated; 1: none measured
  /// Of single samples, over samples and closings: predicted is simulated times the factor of the other closings.
  /// Each posterior sample was conditioned on touch and seat of these closings. This is the error of a single sample;
  /// the median over samples may be more accurate.
  double deviation = nan;
  double median = nan;            ///< of the measured bounces, s: the prediction without any model
  double median_deviation = nan;  ///< of each measured bounce from the median of the others

  /// Median bounce of each measured angle; angles of the mains modulo pi, rad, ascending. Only from twelve angles on,
  /// and only where the line between the neighbours foretells a bounce better than the median does; else empty.
  struct AtAngle {
    double angle = 0, bounce = 0;  ///< rad, s
    bool operator==(const AtAngle&) const = default;
  };
  std::vector<AtAngle> line{};
  double line_deviation = nan;  ///< of each measured bounce from the line between the other angles
};

/// `simulated`: for each sample the bounce of each closing, s; NaN where it does not close. `measured`: of each
/// closing, s; NaN where not measured. What does not close or bounces for less than 20 us counts as 20 us: a large
/// error, not an omission. `angles`: of the mains at each closing, rad; empty: not known.
BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured, std::span<const double> angles = {});

/// What the measured bounces alone say of another closing: the line between the neighbouring angles where there is
/// one, linear in the angle and the logarithm, else the plain median. s, and its deviation of the logarithm.
struct PooledBounce {
  double value = 0, deviation = 0;
};
PooledBounce without_model(const BounceCalibration&, double angle);

/// Weight of the samples in the prediction; what the measured bounces alone say has the rest: w = u^2 / (u^2 + v^2), v
/// and u the deviations of samples and of without_model(), assumed to be independent. A model with large errors where
/// it can be judged has little weight. 1 if both are 0, NaN if they are not known.
double weight_of_samples(const BounceCalibration&);

/// The predicted bounce at an unknown angle of the mains, rad, in s, and the expected deviation of its logarithm.
/// `own`: median over the samples of factor x simulated at that angle, s. It is pooled with m = without_model() in the
/// logarithm,
///   ln b = w ln own + (1 - w) ln m,   deviation = sqrt(w) v,   w = weight_of_samples.
/// If w is not known the result is `own`, without a deviation (NaN).
PooledBounce pooled_bounce(double own, const BounceCalibration&, double angle);

/// ln(measured / predicted) over its deviation is Student's variable with `bounce_tail` degrees of freedom, times
/// `bounce_core`. Most bounces lie nearer than the deviation, one in ten beyond three of it: with one re-opening more
/// or less a bounce is another one. Found on 400 drawn devices of two models (posterior_calibration, seed 3).
inline constexpr double bounce_tail = 1.2, bounce_core = 0.63;

}  // namespace powbench::sim
