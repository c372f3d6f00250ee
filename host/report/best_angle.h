#pragma once

#include "core/comparison.h"

/// Which of the measured closing angles bounces least, how sure that is, and what it is worth.

namespace powbench::host {

struct BestAngle {
  int angles = 0;     ///< with a bounce time of every closing
  int unsettled = 0;  ///< angles left out: some of their closings have no bounce time
  double angle = 0;   ///< rad: of the smallest mean bounce time
  Measured bounce;    ///< there, s
  double coverage = std::numeric_limits<double>::quiet_NaN();
  /// Probability that none of the other angles has a smaller mean, at least: 1 - sum P(other < best), each by
  /// Student's t of the difference with both uncertainties. NaN when an angle has fewer than two repeats: its scatter
  /// is not known.
  double confidence = std::numeric_limits<double>::quiet_NaN();
  double runner_up = std::numeric_limits<double>::quiet_NaN();  ///< rad: the next best angle
  Measured
      gain;  ///< s: mean over the measured angles, each equally likely, minus the bounce time at the best
  double gain_coverage =
      std::numeric_limits<double>::quiet_NaN();  ///< k of it, after Welch and Satterthwaite
  bool two_modes = false;                        ///< the repeats at the best angle fall into two groups
};

/// angles = 0 when no bounce time was measured.
BestAngle best_angle(const Comparison&);

}  // namespace powbench::host
