#pragma once

#include "core/events.h"
#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// Closed and open as a laboratory may define them: by a level of force, with shortest durations. For comparison with
/// others' numbers; powbench's own times are where the force leaves and reaches zero.
struct ThresholdRule {
  double share = 0.10;      ///< of the settled force: above it the contact is closed, (0, 1)
  double min_open = 0.0;    ///< s: shorter openings count as closed
  double min_closed = 0.0;  ///< s: shorter closings count as open
};

/// Crossings of share x settled by `force` (N, vibration taken out; smoothed by a Gaussian of up to 12 us where the
/// level is below eight times the noise), interpolated linearly, with a hysteresis of four times the smoothed noise,
/// at most half the level. Uncertainty: noise over slope and a tenth of the sample interval; the level's own distance
/// from zero force is part of the rule, not of it. `noise`: N, one sample. Without a settled force, or with a level
/// below three times the smoothed noise, the train has no contacts and flag_poor_fit. Throws std::invalid_argument
/// for a rule out of range.
ContactTrain threshold_train(const Signal& force, double settled, double noise, double t_end,
                             const ThresholdRule&);

}  // namespace powbench::dsp
