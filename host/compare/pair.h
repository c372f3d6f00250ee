#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/comparison.h"

/// Two campaigns side by side: before and after a change, one device and another.

namespace powbench::host {

/// One quantity at one closing angle that either campaign has measured. SI.
struct PairRow {
  double closing_angle = 0;  ///< rad; NaN = not known
  std::string quantity, unit;
  int n[2] = {0, 0};       ///< measured values behind each mean
  Measured first, second;  ///< unknown where the campaign has none
  double k[2] = {std::numeric_limits<double>::quiet_NaN(),
                 std::numeric_limits<double>::quiet_NaN()};      ///< coverage factors of the two
  double difference = std::numeric_limits<double>::quiet_NaN();  ///< second - first
  double U = std::numeric_limits<
      double>::quiet_NaN();  ///< of the difference, 95.45 %; NaN where either u is not known

  /// |difference| / U, as ComparisonRow's.
  double over_U() const;
};

/// u of the difference is sqrt(u1^2 + u2^2): errors that both campaigns share, such as one calibration, are counted
/// twice, so U errs to the safe side. Degrees of freedom after Welch-Satterthwaite (JCGM 100:2008, G.4), k from
/// Student's t.
std::vector<PairRow> compare_pair(const Comparison& first, const Comparison& second);

}  // namespace powbench::host
