#pragma once

#include <optional>

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"
#include "dsp/signal/mains.h"

namespace powbench::dsp {

/// The mains ahead of the switch before switch-on: fundamental with harmonics 3, 5, .. and its frequency.
/// Nothing when the channel is absent, silent, or the pre-trigger holds less than two periods.
std::optional<HarmonicFit> supply_fit(const Record&, const ExtractOptions&);

/// Switch-on from the coil-voltage step (the most likely sample at which the coil voltage starts to follow
/// the mains, and not before the gate edge), closing angle as the phase of the fundamental at that instant,
/// supply, and coil-current peak. Without a mains-voltage channel the fit is of the coil voltage itself, from 25 ms
/// behind its step to switch-off, carried back to the step: only where it is a plain sine all that time. The angle is
/// then known although `flag_no_hum_fit` is set, which tells where it is from (`angle_by_coil`). Its u contains
/// 1/sqrt(3) of the turn that the inrush makes; the supply's voltage stays unknown.
CoilEvents coil_events(const Record&, const std::optional<HarmonicFit>& supply, const ExtractOptions&);

/// The closing angle was found in the coil voltage, not ahead of the switch.
inline bool angle_by_coil(const CoilEvents& e) {
  return e.closing_angle.known() && (e.flags & flag_no_hum_fit) != 0;
}

}  // namespace powbench::dsp
