#pragma once

#include <string>

#include "core/record.h"
#include "host/gather/event_filter.h"

namespace powbench::host {

/// SVG: the force of each channel as it came and as the events were taken from it (filter and fitted vibration out),
/// in time from 1 ms before the first touch to 2 ms after the last, and its spectrum there. `title` stands above.
/// Throws BadInput without a force channel.
std::string strip_svg(const Record&, const FilteredEvents&, const std::string& title);

}  // namespace powbench::host
