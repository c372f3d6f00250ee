#pragma once

#include <vector>

#include "core/record.h"

namespace powbench::host {

/// (samples) true where a channel has no measurement: gaps of the record and of the channel.
std::vector<bool> lost_samples(const Record&, const ChannelRecord&);

}  // namespace powbench::host
