#pragma once

#include <functional>

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

namespace powbench::dsp {

/// Runs two pieces of work that know nothing of each other and returns when both are done; it may run them side by
/// side.
using RunBoth = std::function<void(const std::function<void()>&, const std::function<void()>&)>;
inline void in_turn(const std::function<void()>& first, const std::function<void()>& second) {
  first(), second();
}

/// Everything that happened in one closing. Pure: equal record and options give equal events, bit for bit.
/// What a record does not show stays unknown (NaN) or not present; bad options or a record whose scale or
/// rate cannot mean anything throw std::invalid_argument.
/// No number is silent: `conclude` has been applied. The two films are given to `both`: in turn or side by side, the
/// events are the same.
Events extract_events(const Record&, const ExtractOptions& = {}, const RunBoth& both = in_turn);

/// Sets `angle_off` where the angle reached is further than `tolerance` (rad) from the commanded one, clears it
/// elsewhere; nothing is off without a tolerance (0), a commanded angle or an angle found. The only place that
/// decides it; extract_events does not.
void check_angle(Events&, const Conditions&, double tolerance);

/// What follows from the trains, the core and the coil of `record`: doubt admitted (dsp/events/doubt.h), the pole
/// by force and its disagreement with the contact-voltage, the two trains, the common flags. To be called again
/// when a train was replaced; a second call without a change changes nothing.
void conclude(Events&, const Record&, const ExtractOptions&);

}  // namespace powbench::dsp
