#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/channels.h"

/// What the front end of each channel is, and how that is kept where it outlives the power.

namespace powbench::firmware {

/// What the front end of one channel is, as told to clients. Integers in decimal fractions: a board has no printf.
struct ChannelCalibration {
  std::int64_t scale_pico = 0;         ///< 1e-12 of the IIO unit per count; 0: there is no such channel
  std::int64_t delay_ns = 0;           ///< the value shows the quantity this much earlier
  std::int64_t corner_microhertz = 0;  ///< low corner of the charge amplifier, 0 = down to DC
  std::int64_t film_area_pico = 0;     ///< 1e-12 m2, force channels only
  std::int64_t sensitivity_femto = 0;  ///< 1e-15 C/N, force channels only
  std::int64_t zero_counts = 0;        ///< reading at zero
};
using Calibrations = std::array<ChannelCalibration, channel_count>;

/// What a calibration is called, from when until when it counts.
struct Certificate {
  static constexpr std::size_t longest_id = 32;

  std::array<char, longest_id> id{};
  std::uint32_t id_size = 0;
  std::uint32_t date = 0, expires = 0;  ///< 20301231: days as decimal numbers

  std::string_view name() const { return {id.data(), id_size}; }
};

/// A calibration as a whole.
struct StoredCalibration {
  Calibrations rows{};
  Certificate certificate;
  std::int64_t switch_delay_ns = 0;  ///< of the coil's switch, gate to voltage: the edge is advanced by it
};

/// 1 .. 32 printable characters without blank and colon.
bool usable_certificate(std::string_view id);
/// A day of the calendar from 2000 to 2199, as 20301231.
bool is_day(std::int64_t yyyymmdd);

/// Bytes of a slot: mark, number, dates, identity, rows, CRC-32 over all of it; little-endian.
inline constexpr std::size_t slot_bytes = 448;
using SlotBytes = std::array<std::uint8_t, slot_bytes>;

/// CRC-32 over the rows as they stand in a slot: what host and board compare before anything is stored.
std::uint32_t rows_crc32(const Calibrations&);

/// `number`: of the write, so that the newer of two slots is known.
void encode_slot(const StoredCalibration&, std::uint32_t number, SlotBytes& out);

struct DecodedSlot {
  StoredCalibration calibration;
  std::uint32_t number = 0;
};
/// Nothing: no slot, or one that is damaged.
std::optional<DecodedSlot> decode_slot(std::span<const std::uint8_t> bytes);

}  // namespace powbench::firmware
