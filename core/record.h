#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/channels.h"
#include "core/conditions.h"

namespace powbench {

/// Samples that were lost: indices first .. first + count - 1 hold a fill value, not a measurement.
/// The time axis stays intact across a gap.
struct Gap {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// One sampled channel as the converter gave it. value = (raw + offset) * scale, in the SI unit of the channel table.
struct ChannelRecord {
  Channel channel{};
  std::vector<std::int16_t> raw;  ///< (samples)
  double scale = 1.0;             ///< SI unit per count; negative for a film glued upside down
  double offset = 0.0;            ///< counts
  double delay = 0.0;             ///< s: the value at time t shows the quantity at t - delay
  double corner_hertz = 0.0;      ///< low corner of the charge amplifier; 0 = coupled down to DC
  std::int16_t clip_low = std::numeric_limits<std::int16_t>::min();   ///< counts at or below: saturated
  std::int16_t clip_high = std::numeric_limits<std::int16_t>::max();  ///< counts at or above: saturated
  std::vector<Gap> gaps{};                                            ///< samples lost in this channel alone

  double value(std::size_t i) const { return (raw[i] + offset) * scale; }
};

/// What a rig gave for one closing. Filled by `rigs/`, never changed afterwards.
/// Time axis: sample i was taken (i - fire_sample) / sample_rate after the coil was switched on.
struct Record {
  Conditions conditions;                ///< as asked
  double sample_rate = 0.0;             ///< Hz, of every channel
  std::int64_t fire_sample = 0;         ///< index of the first sample at or after the gate edge
  double fire_offset = 0.0;             ///< s, [0, 1/rate): time from the gate edge to `fire_sample`
  std::vector<ChannelRecord> channels;  ///< in scan order; absent channels are left out
  std::vector<Gap> gaps;                ///< samples lost in every channel
  std::uint32_t overruns = 0;           ///< conversions lost, as counted by the rig
  std::uint32_t crc32 = 0;              ///< over the scans in wire order, as computed by the rig
  std::uint64_t shot_id = 0;            ///< the rig's own counter
  std::string rig;                      ///< hw_model, hw_serial
  std::string firmware;                 ///< fw_version
  std::string calibration;              ///< id of the calibration in force
  std::string sealed;                   ///< the rig's sealed shot as it came; empty: it came from no rig

  std::size_t samples() const { return channels.empty() ? 0 : channels.front().raw.size(); }
  double time(std::size_t i) const {
    return static_cast<double>(static_cast<std::int64_t>(i) - fire_sample) / sample_rate + fire_offset;
  }
  const ChannelRecord* find(Channel c) const {
    for (const auto& ch : channels)
      if (ch.channel == c) return &ch;
    return nullptr;
  }
};

}  // namespace powbench
