#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/events.h"
#include "host/export/event_table.h"

namespace powbench::host {

/// A row for each closed interval of each contact: `shot`, `channel`, `contact` (from 1), touch, release, peak and
/// impulse, each with its standard uncertainty `u_...`, the probability that it is a contact of its own, and flags.
Table contact_table(const std::vector<std::pair<std::int64_t, Events>>& shots);

}  // namespace powbench::host
