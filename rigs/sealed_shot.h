#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/record.h"
#include "firmware/source_device.h"

/// The rig's own word on a shot: one line of text under a checksum, as firmware/sealed_shot.h writes it. The host's
/// half: it believes nothing that the seal does not cover.

namespace powbench::rigs {

/// The text is no sealed shot, or not the one that was sealed. One sentence.
struct SealError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct SealedShot {
  std::string text;  ///< as it came
  std::string stage, boot, model, serial, firmware, commit, board, calibration;
  std::uint32_t image_crc32 = 0;  ///< of the program; 0: not known
  std::uint32_t config_crc32 = 0;
  std::int64_t shot = 0;
  std::int64_t angle_centideg = 0, hold_ms = 0, touch_us = 0, tolerance_mdeg = 0;
  std::optional<firmware::SetPoints> source;
  std::int64_t sample_rate = 0, samples = 0;

  // with stage "complete" only
  std::int64_t fire_sample = 0, fire_offset_ns = 0, overruns = 0, marks = 0;
  std::int64_t angle_u_mdeg = 0;  ///< standard uncertainty of the mains phase at the closing angle, 0.001 deg
  std::vector<Gap> gaps;
  std::uint32_t record_crc = 0;
  std::vector<ChannelRecord> channels;  ///< without samples, in scan order, SI

  bool complete() const { return stage == "complete"; }
};

/// Checks the seal and every number behind it: whole, in range, finite. Throws SealError.
SealedShot parse_sealed_shot(std::string_view text);

/// A record with everything but samples and conditions, from a complete block.
Record to_record(const SealedShot&);

}  // namespace powbench::rigs
