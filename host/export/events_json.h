#pragma once

#include <string>

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

namespace powbench::host {

/// Events in the form other programs read, SI units in the keys, `null` for what is not known:
///     {"channels": {"pvdf_a": {"contacts": [{"touch_s", "u_touch_s", "release_s", "u_release_s", "peak", "impulse",
///     "flags": [], "probability"}],
///                              "settled_s", "u_settled_s", "bounce_time_s", "resolution_s"}},
///      "core": {"seat_s", "u_seat_s", "settled_s", "u_settled_s", "bounce_time_s", "impact_velocity_m_per_s",
///               "u_impact_velocity_m_per_s", "travel_m", "u_travel_m", "resolution_s", "flags": []},
///      "closing_angle_deg", "u_closing_angle_deg"}
/// Channels: those of the record that show contacts, by their names. `release_s` is null while the contact stays
/// closed. The flags of a channel and of its record stand at each of its contacts.
std::string to_events_json(const Events&, const Record&, int indent = 2, const dsp::ExtractOptions& = {});

}  // namespace powbench::host
