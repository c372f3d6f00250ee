#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host/compare/limits.h"

namespace powbench::host {

/// How often one limit was not met in a run, so that many FAIL lines are one.
struct LimitTally {
  Limit limit;
  int failed = 0, not_observed = 0;
  double worst = std::numeric_limits<double>::quiet_NaN();    ///< value furthest outside, SI
  double worst_u = std::numeric_limits<double>::quiet_NaN();  ///< of that value, where the rule is guarded
  double worst_angle_deg = std::numeric_limits<double>::quiet_NaN();  ///< commanded, where that was
};

/// One tally for each limit, nothing counted yet.
std::vector<LimitTally> tally_of(const std::vector<Limit>&);
/// Counts one shot.
void count(std::vector<LimitTally>&, const Events&, Decision, double angle_deg);
/// "t_ct_bon, allowed ≤ 9 ms: 12 FAIL, furthest 11.200 ms at 60 deg; 1 NOT OBSERVED"; "" where every shot met it.
std::string sentence(const LimitTally&);

}  // namespace powbench::host
