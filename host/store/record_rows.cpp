#include "host/store/record_rows.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/crc32.h"
#include "host/store/hash.h"
#include "host/store/packing.h"
#include "host/store/seal.h"
#include "host/store/store.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;

namespace {

constexpr std::string_view packed_name = "blocks64";

/// Scans in wire order: sample by sample, channel by channel, little endian. Their hash names the record.
std::vector<std::uint8_t> interleave(const Record& r) {
  const std::size_t step = 2 * r.channels.size();
  std::vector<std::uint8_t> bytes(step * r.samples());
  for (std::size_t k = 0; k < r.channels.size(); ++k) {
    std::size_t at = 2 * k;
    for (const std::int16_t sample : r.channels[k].raw) {
      const auto value = static_cast<std::uint16_t>(sample);
      bytes[at] = static_cast<std::uint8_t>(value & 0xFFU);
      bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
      at += step;
    }
  }
  return bytes;
}

std::vector<std::uint8_t> packed(const Record& r) {
  std::vector<Samples> channels;
  for (const ChannelRecord& c : r.channels) channels.emplace_back(c.raw);
  return pack_samples(channels);
}

/// The number of samples comes from the file: it is compared, never multiplied, before anything is made of it.
bool take_bare(std::span<const std::uint8_t> scans, std::int64_t stated, Record& r) {
  const std::size_t step = 2 * r.channels.size(), samples = step == 0 ? 0 : scans.size() / step;
  if (scans.size() != samples * step || stated != static_cast<std::int64_t>(samples)) return false;
  for (std::size_t k = 0; k < r.channels.size(); ++k) {
    auto& raw = r.channels[k].raw;
    raw.resize(samples);
    for (std::size_t i = 0; i < samples; ++i) {
      const std::size_t at = i * step + 2 * k;
      raw[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(scans[at] | scans[at + 1] << 8));
    }
  }
  return true;
}

/// A block of samples takes one byte at least, which bounds what a number in the file can ask for.
bool take_packed(std::span<const std::uint8_t> bytes, std::int64_t stated, Record& r) {
  if (stated < 0 || static_cast<std::uint64_t>(stated) / packed_block > bytes.size()) return false;
  if (r.channels.empty()) return stated == 0 && bytes.empty();
  std::vector<std::span<std::int16_t>> channels;
  for (ChannelRecord& c : r.channels) {
    c.raw.resize(static_cast<std::size_t>(stated));
    channels.emplace_back(c.raw);
  }
  return unpack_samples(bytes, channels);
}

void insert_channels(Database& db, std::int64_t record_id, const Record& record) {
  for (std::size_t i = 0; i < record.channels.size(); ++i) {
    const ChannelRecord& c = record.channels[i];
    Statement(db,
              "INSERT INTO channel (record_id, position, name, unit, scale, offset, delay, corner_hertz, "
              "clip_low, clip_high) "
              "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(record_id)
        .bind(static_cast<std::int64_t>(i))
        .bind(info(c.channel).name)
        .bind(info(c.channel).unit)
        .bind(c.scale)
        .bind(c.offset)
        .bind(c.delay)
        .bind(c.corner_hertz)
        .bind(static_cast<int>(c.clip_low))
        .bind(static_cast<int>(c.clip_high))
        .run();
  }
}

/// Of everything but the samples, which have a hash of their own.
std::string seal_of(const Record& r, const std::string& content_hash, const std::string& gaps) {
  Seal seal;
  seal.add(content_hash).add(r.sample_rate).add(r.fire_sample).add(r.fire_offset).add(gaps);
  seal.add(static_cast<std::int64_t>(r.overruns)).add(static_cast<std::int64_t>(r.crc32));
  seal.add(static_cast<std::int64_t>(r.shot_id)).add(r.rig).add(r.firmware).add(r.calibration);
  if (!r.sealed.empty()) seal.add(r.sealed);  // older rows have none
  for (const ChannelRecord& c : r.channels) {
    seal.add(info(c.channel).name).add(c.scale).add(c.offset).add(c.delay).add(c.corner_hertz);
    seal.add(static_cast<int>(c.clip_low)).add(static_cast<int>(c.clip_high));
  }
  return seal.hex();
}

Channel channel_named(const std::string& name) {
  for (std::size_t i = 0; i < channel_count; ++i)
    if (channel_table[i].name == name) return static_cast<Channel>(i);
  throw StoreError("unknown channel '" + name + "' in the store: the file is damaged");
}

/// A list of [first, count] or [first, count, channel]. The numbers may be anything.
void take_gaps(const std::string& text, Record& r, std::int64_t samples, const std::string& where) {
  const auto damaged = [&] { return StoreError(where + ": its gaps make no sense: the file is damaged"); };
  const auto list = nlohmann::json::parse(text, nullptr, false);
  if (!list.is_array()) throw damaged();
  for (const auto& gap : list) {
    if (!gap.is_array() || gap.size() < 2 || gap.size() > 3) throw damaged();
    for (const auto& number : gap)
      if (!number.is_number_integer()) throw damaged();
    const Gap g{gap[0].get<std::int64_t>(), gap[1].get<std::int64_t>()};
    if (g.first < 0 || g.count < 0 || g.first > samples || g.count > samples - g.first) throw damaged();
    if (gap.size() == 2) {
      r.gaps.push_back(g);
      continue;
    }
    const auto channel = gap[2].get<std::int64_t>();
    if (channel < 0 || channel >= static_cast<std::int64_t>(r.channels.size())) throw damaged();
    r.channels[static_cast<std::size_t>(channel)].gaps.push_back(g);
  }
}

/// What everybody divides by, or indexes with.
void check_numbers(const Record& r, const std::string& where) {
  bool usable = std::isfinite(r.sample_rate) && r.sample_rate > 0.0 && std::isfinite(r.fire_offset);
  for (const ChannelRecord& c : r.channels)
    usable = usable && std::isfinite(c.scale) && std::isfinite(c.offset) && std::isfinite(c.delay) &&
             std::isfinite(c.corner_hertz);
  if (!usable) throw StoreError(where + ": has a number that is none: the file is damaged");
}

}  // namespace

std::int64_t insert_record(Database& db, std::int64_t shot, const Record& r) {
  nlohmann::json gaps = nlohmann::json::array();
  for (const Gap& g : r.gaps) gaps.push_back({g.first, g.count});
  for (std::size_t k = 0; k < r.channels.size(); ++k)  // a third number: the one channel that lost them
    for (const Gap& g : r.channels[k].gaps) gaps.push_back({g.first, g.count, k});
  const std::string content_hash = sha256_hex(interleave(r));
  const std::vector<std::uint8_t> bytes = packed(r);
  Statement(db,
            "INSERT INTO record (shot_id, content_hash, sample_rate, samples, fire_sample, fire_offset, "
            "gaps, overruns, crc32, "
            "rig_shot_id, rig, firmware, calibration, sealed, seal, packing, scans) VALUES (?, ?, ?, ?, ?, "
            "?, ?, ?, ?, "
            "?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(shot)
      .bind(content_hash)
      .bind(r.sample_rate)
      .bind(static_cast<std::int64_t>(r.samples()))
      .bind(r.fire_sample)
      .bind(r.fire_offset)
      .bind(gaps.dump())
      .bind(static_cast<std::int64_t>(r.overruns))
      .bind(static_cast<std::int64_t>(r.crc32))
      .bind(static_cast<std::int64_t>(r.shot_id))
      .bind(r.rig)
      .bind(r.firmware)
      .bind(r.calibration)
      .bind(r.sealed)
      .bind(seal_of(r, content_hash, gaps.dump()))
      .bind(packed_name)
      .bind_blob(bytes)
      .run();
  const std::int64_t record_id = db.last_id();
  insert_channels(db, record_id, r);
  return record_id;
}

Record select_record(const Database& db, std::int64_t shot) {
  Statement s(db,
              "SELECT id, content_hash, sample_rate, samples, fire_sample, fire_offset, gaps, overruns, "
              "crc32, rig_shot_id, rig, "
              "firmware, calibration, scans, seal, sealed, packing FROM record WHERE shot_id = ?");
  s.bind(shot);
  const std::string where = db.path() + ": shot " + std::to_string(shot);
  if (!s.step()) throw StoreError(where + " has no record");
  Record r;
  r.sample_rate = s.real(2);
  r.fire_sample = s.integer(4);
  r.fire_offset = s.real(5);
  r.overruns = static_cast<std::uint32_t>(s.integer(7));
  r.crc32 = static_cast<std::uint32_t>(s.integer(8));
  r.shot_id = static_cast<std::uint64_t>(s.integer(9));
  r.rig = s.text(10);
  r.firmware = s.text(11);
  r.calibration = s.text(12);
  r.sealed = s.text(15);

  Statement c(db,
              "SELECT name, scale, offset, delay, corner_hertz, clip_low, clip_high, unit FROM channel WHERE "
              "record_id = ? ORDER BY position");
  c.bind(s.integer(0));
  while (c.step()) {
    const Channel channel = channel_named(c.text(0));
    if (c.text(7) != info(channel).unit)
      throw StoreError(where + ": " + c.text(0) + " has the unit '" + c.text(7) + "' instead of " +
                       std::string(info(channel).unit) + ": the file is damaged");
    r.channels.push_back({.channel = channel,
                          .raw = {},
                          .scale = c.real(1),
                          .offset = c.real(2),
                          .delay = c.real(3),
                          .corner_hertz = c.real(4),
                          .clip_low = static_cast<std::int16_t>(c.integer(5)),
                          .clip_high = static_cast<std::int16_t>(c.integer(6))});
  }

  if (seal_of(r, s.text(1), s.text(6)) != s.text(14))
    throw StoreError(where +
                     ": the record does not match its checksum: the file is damaged; restore it from a copy");
  const std::string packing = s.text(16);
  if (!packing.empty() && packing != packed_name)
    throw StoreError(where + ": its samples are packed as '" + packing +
                     "', which this program does not know: update it, or the file is damaged");
  const auto blob = s.blob(13);
  const bool taken = packing.empty() ? take_bare(blob, s.integer(3), r) : take_packed(blob, s.integer(3), r);
  if (!taken || sha256_hex(interleave(r)) != s.text(1))
    throw StoreError(where + ": its samples do not match their hash: the record is damaged");
  take_gaps(s.text(6), r, s.integer(3), where);
  check_numbers(r, where);
  return r;
}

bool pack_record(Database& db, std::int64_t shot) {
  Statement s(db, "SELECT packing FROM record WHERE shot_id = ?");
  if (!s.bind(shot).step() || !s.text(0).empty()) return false;
  const std::vector<std::uint8_t> bytes = packed(select_record(db, shot));
  Statement(db, "UPDATE record SET packing = ?, scans = ? WHERE shot_id = ?")
      .bind(packed_name)
      .bind_blob(bytes)
      .bind(shot)
      .run();
  return true;
}

}  // namespace powbench::host
