#pragma once

#include <cstdint>
#include <span>

#include "core/channels.h"

namespace powbench::firmware {

/// One DMA block from the converters: `scans` holds channel_count interleaved int16 per sample instant, in
/// scan order.
struct Block {
  std::int64_t first_sample = 0;          ///< index on the sampling clock; a jump means lost samples
  std::span<const std::int16_t> scans{};  ///< (samples x channel_count)
  bool emergency_stop = false;            ///< the e-stop chain is open

  std::int64_t samples() const { return static_cast<std::int64_t>(scans.size() / channel_count); }
  std::int16_t at(std::int64_t i, Channel c) const {
    return scans[static_cast<std::size_t>(i) * channel_count + index(c)];
  }
};

/// Instant on the sampling clock: sample index plus fraction / 65536 of a sample period.
struct Tick {
  std::int64_t sample = 0;
  std::uint16_t fraction = 0;

  /// First sample at or after the instant.
  std::int64_t sample_at_or_after() const { return sample + (fraction != 0 ? 1 : 0); }
};

struct GateEdge {
  bool on = false;
  Tick at;
};

}  // namespace powbench::firmware
