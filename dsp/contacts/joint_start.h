#pragma once

#include "dsp/contacts/detect_round.h"
#include "dsp/contacts/joint_fit.h"

namespace powbench::dsp {

/// Start of a joint fit: pulses as crossed, or as the fit before had them where they overlap; the last contact, where
/// it stays closed, as a rise to `settled` N. Ring and pedestal are those of `before`.
JointModel start_of(const Round&, double settled, const JointModel& before);

}  // namespace powbench::dsp
