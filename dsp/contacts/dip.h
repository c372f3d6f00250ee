#pragma once

#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// Did a contact open in a dip of its force, or did the force only come close to zero?
///
/// Near the least indentation, with x the time from the middle over the half width,
///   F = F0 max(0, w)^q + z,   w = m + x'^2 (b (1 + e sign x') + c x' + d x'^2),   x' = x - x0,   q in {1, 1.25, 1.5}.
/// m < 0: pad and bridge were apart. e: friction of the guide, which turns round where the bridge does (prior 0 +-
/// 0.15); z: error of the zero, a normal prior of the noise and of `wander`, N. The likelihood is profiled along m
/// for every q; uniform prior in m, equal weights of q.
struct Dip {
  bool known = false;   ///< one smooth indentation explains the force
  double opened = 0.5;  ///< probability that the contact opened
  double reduced_chi2 = 0;
  double noise = 0;   ///< of one row of the span used, over the larger force at its ends
  bool sure = false;  ///< what only touches zero is excluded beyond doubt
};

/// `release`, `touch`: s, first guesses of the edges. The span begins with two openings, at most `closed` s, on
/// either side, and shrinks until the model follows it; of that and the two next ones the most doubtful counts. Where
/// the model follows none of them, the one that it follows best is asked with what it leaves as the noise.
Dip look_at_dip(const Signal& force, double release, double touch, double closed, double noise,
                double wander = 0);

}  // namespace powbench::dsp
