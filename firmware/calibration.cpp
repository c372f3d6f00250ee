#include "firmware/calibration.h"

#include "core/crc32.h"

namespace powbench::firmware {
namespace {

constexpr std::uint32_t slot_mark = 0x31434250;  // "PBC1"
constexpr std::size_t head_bytes = 5 * 4 + Certificate::longest_id + 8;
constexpr std::size_t row_values = 6;
constexpr std::size_t crc_at = head_bytes + channel_count * row_values * 8;
static_assert(crc_at + 4 == slot_bytes && slot_bytes % 8 == 0);

/// Little-endian numbers, one after the other.
struct Put {
  std::uint8_t* at;
  void number(std::uint64_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) *at++ = static_cast<std::uint8_t>(value >> (8 * i) & 0xFFU);
  }
};
struct Get {
  const std::uint8_t* at;
  std::uint64_t number(std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(*at++) << (8 * i);
    return value;
  }
  std::uint32_t word() { return static_cast<std::uint32_t>(number(4)); }
  std::int64_t value() { return static_cast<std::int64_t>(number(8)); }
};

/// The row's fields in the order in which they travel.
template <class Row, class Do>
void each_value(Row& row, Do act) {
  act(row.scale_pico);
  act(row.zero_counts);
  act(row.delay_ns);
  act(row.corner_microhertz);
  act(row.film_area_pico);
  act(row.sensitivity_femto);
}

}  // namespace

bool usable_certificate(std::string_view id) {
  if (id.empty() || id.size() > Certificate::longest_id) return false;
  for (const char c : id)
    if (c <= ' ' || c > '~' || c == ':') return false;
  return true;
}

bool is_day(std::int64_t yyyymmdd) {
  const std::int64_t year = yyyymmdd / 10000, month = yyyymmdd / 100 % 100, day = yyyymmdd % 100;
  if (year < 2000 || year > 2199 || month < 1 || month > 12 || day < 1) return false;
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const std::int64_t days = month == 2                                              ? (leap ? 29 : 28)
                            : month == 4 || month == 6 || month == 9 || month == 11 ? 30
                                                                                    : 31;
  return day <= days;
}

std::uint32_t rows_crc32(const Calibrations& rows) {
  std::uint32_t crc = 0;
  for (const ChannelCalibration& row : rows) {
    std::uint8_t bytes[row_values * 8];
    Put put{bytes};
    each_value(row, [&](std::int64_t v) { put.number(static_cast<std::uint64_t>(v), 8); });
    crc = crc32(bytes, crc);
  }
  return crc;
}

void encode_slot(const StoredCalibration& c, std::uint32_t number, SlotBytes& out) {
  out.fill(0);
  Put put{out.data()};
  put.number(slot_mark, 4);
  put.number(number, 4);
  put.number(c.certificate.date, 4);
  put.number(c.certificate.expires, 4);
  put.number(c.certificate.id_size, 4);
  for (const char letter : c.certificate.id) put.number(static_cast<std::uint8_t>(letter), 1);
  put.number(static_cast<std::uint64_t>(c.switch_delay_ns), 8);
  for (const ChannelCalibration& row : c.rows)
    each_value(row, [&](std::int64_t v) { put.number(static_cast<std::uint64_t>(v), 8); });
  put.number(crc32({out.data(), crc_at}), 4);
}

std::optional<DecodedSlot> decode_slot(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != slot_bytes) return std::nullopt;
  Get get{bytes.data()};
  if (Get{bytes.data() + crc_at}.word() != crc32(bytes.first(crc_at)) || get.word() != slot_mark)
    return std::nullopt;
  std::optional<DecodedSlot> slot;
  slot.emplace();
  slot->number = get.word();
  Certificate& c = slot->calibration.certificate;
  c.date = get.word();
  c.expires = get.word();
  c.id_size = get.word();
  for (char& letter : c.id) letter = static_cast<char>(get.number(1));
  if (c.id_size > c.id.size() || !usable_certificate(c.name()) || !is_day(c.date) || !is_day(c.expires))
    return std::nullopt;
  slot->calibration.switch_delay_ns = get.value();
  for (ChannelCalibration& row : slot->calibration.rows)
    each_value(row, [&](std::int64_t& v) { v = get.value(); });
  return slot;
}

}  // namespace powbench::firmware
