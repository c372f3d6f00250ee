#pragma once

#include <cstdint>
#include <string>

#include "core/record.h"

namespace powbench::host {

/// A record as a browser takes it: 4 bytes, length of the head (little endian, a multiple of 2); the head as JSON;
/// then the counts of each channel, 16 bit, little endian, channel behind channel. The head: shot, rate_hz, samples,
/// fire_sample, origin, and of each channel name, unit, scale, offset, clip_low, clip_high; value = (count + offset)
/// scale.
std::string record_frame(const Record&, std::int64_t shot, const std::string& origin);

}  // namespace powbench::host
