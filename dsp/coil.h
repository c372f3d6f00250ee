#pragma once

#include <optional>

#include "core/events.h"
#include "core/record.h"
#include "dsp/mains.h"
#include "dsp/options.h"

namespace powbench::dsp {

/// The mains ahead of the switch before switch-on: fundamental with harmonics 3, 5, .. and its frequency.
/// Nothing when the channel is absent, silent, or the pre-trigger holds less than two periods.
std::optional<HarmonicFit> supply_fit(const Record&, const ExtractOptions&);

/// Switch-on from the coil-voltage step (the most likely sample at which the coil voltage starts to follow
/// the mains, and not before the gate edge), closing angle as the phase of the fundamental at that instant,
/// supply, and coil-current peak.
CoilEvents coil_events(const Record&, const std::optional<HarmonicFit>& supply, const ExtractOptions&);

}  // namespace powbench::dsp
