#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/channels.h"
#include "host/store/store.h"

/// Many records at once, on several threads, each with a connection of its own.

namespace powbench::python {

struct WaveformClock {
  double sample_rate = 0;  ///< Hz
  std::int64_t fire_sample = 0;
  std::size_t samples = 0;
  double fire_offset = 0;  ///< s; may differ from shot to shot
};

WaveformClock clock_of(const host::Store&, std::int64_t shot);

/// Row i of to[k] (ids.size() rows of clock.samples values) becomes channel k of shot i, SI; NaN where samples were
/// lost or the record has no such channel. clocks[i] is that of shot i. Throws BadInput when rate, length or fire
/// sample of a shot differ from `clock`, and what the store throws.
template <class Float>
void fill_waveforms(const std::string& path, std::span<const std::int64_t> ids,
                    std::span<const Channel> channels, const WaveformClock& clock, std::span<Float* const> to,
                    std::span<WaveformClock> clocks, int threads);

}  // namespace powbench::python
