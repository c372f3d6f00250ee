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
  bool comparator_trip = false;           ///< the overcurrent comparator has cut the gate by itself
  bool overrun = false;                   ///< a converter or the DMA has dropped something in this block
  bool brown_out = false;                 ///< the supply monitor warns
  bool clock_failed = false;              ///< the clock monitor has switched to the internal oscillator
  bool relay_in = false;                  ///< the safety relay's read-back contact says that it is closed
  bool owner_present = false;  ///< the port vouches for the owner: its time runs ahead of any heartbeat
  std::int64_t counter = -1;   ///< blocks the DMA has filled so far; -1: the port does not count
  std::int64_t late = 0;       ///< samples that have passed since the block's end

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

/// An edge for the output compare. An on edge comes with its own end: the port arms a second compare channel
/// with `off_by` at the same time, so that the coil goes off even if no code runs any more.
struct GateEdge {
  bool on = false;
  Tick at;
  Tick off_by{};
};

}  // namespace powbench::firmware
