#include "firmware/recorder.h"

#include <bit>
#include <cstdint>

#include "core/crc32.h"
#include "firmware/handover.h"

namespace powbench::firmware {

namespace {
constexpr std::uint32_t timestamp_bit = 1U << channel_count;
constexpr std::int64_t never = INT64_MIN;
constexpr std::uint32_t sample_bits = timestamp_bit - 1;

constexpr std::size_t count_bits(std::uint32_t mask) {
  std::size_t n = 0;
  for (; mask != 0; mask &= mask - 1) ++n;
  return n;
}
}  // namespace

Recorder::Recorder(std::span<std::int16_t> storage, std::int64_t length, std::int64_t pretrigger,
                   std::int64_t period_ns)
    : storage_(storage),
      capacity_(static_cast<std::int64_t>(storage.size() / channel_count)),
      length_(length),
      pretrigger_(pretrigger),
      period_ns_(period_ns) {}

/// Index of a sample's scan in the storage: sample modulo capacity, without a 64-bit division where the sample
/// is at most a lap away from the newest one.
std::size_t Recorder::place(std::int64_t sample) const {
  std::int64_t distance = sample - lap_;
  if (distance < 0)
    distance += capacity_;
  else if (distance >= capacity_)
    distance -= capacity_;
  if (distance < 0 || distance >= capacity_) distance = sample % capacity_;
  return static_cast<std::size_t>(distance) * channel_count;
}
std::int16_t* Recorder::slot(std::int64_t sample) {
  return &storage_[place(sample)];
}
const std::int16_t* Recorder::slot(std::int64_t sample) const {
  return &storage_[place(sample)];
}

void Recorder::arm() {
  discard();
  armed_ = true;
  ++generation_;
}

void Recorder::discard() {
  armed_ = triggered_ = complete_ = false;
  next_ = -1;
  gap_count_ = 0;
  overruns_ = 0;
  marked_.fill(never);
  ready_ = 0;
  store_shared(record_, record_ + 1);
}

void Recorder::trigger(Tick edge) {
  edge_ = edge;
  start_ = edge.sample_at_or_after() - pretrigger_;
  triggered_ = true;
}

void Recorder::mark(std::uint8_t bits, std::int64_t end) {
  if (!armed_ || bits == 0) return;
  for (std::size_t b = 0; b < marked_.size(); ++b)
    if ((bits >> b & 1U) != 0) marked_[b] = end;
}

std::uint8_t Recorder::marks() const {
  unsigned bits = 0;
  for (std::size_t b = 0; b < marked_.size(); ++b)
    if (triggered_ && marked_[b] > start_) bits |= 1U << b;
  return static_cast<std::uint8_t>(bits);
}

void Recorder::note_gap(std::int64_t first, std::int64_t count) {
  overruns_ += static_cast<std::uint32_t>(count);
  if (gap_count_ < gaps_.size())
    gaps_[gap_count_++] = {first, count};  // absolute for now, relative when finished
}

void Recorder::push(const Block& block) {
  if (!armed_ || complete_) return;
  const std::int64_t first = block.first_sample;
  std::int64_t count = block.samples();
  if (first - lap_ >= capacity_ || first < lap_) lap_ = first - first % capacity_;
  if (next_ >= 0 && first > next_) fill_gap(first);
  next_ = first + count;
  if (triggered_ && next_ > start_ + length_) count = start_ + length_ - first;
  if (count > 0) store(first, block.scans.data(), count);
  if (!triggered_) return;
  const std::int64_t there = next_ - start_;
  if (there > 0) store_shared(ready_, static_cast<std::int32_t>(there < length_ ? there : length_));
  if (counting_ == record_ && load_shared(counted_) == length_) finish();
}

/// Lost samples: hold the last value, so that the time axis stays true, and remember where.
void Recorder::fill_gap(std::int64_t until) {
  const std::int64_t lost = until - next_;
  note_gap(next_, lost);
  const std::int64_t fill = lost < capacity_ ? lost : capacity_;
  const std::int16_t* last = slot(next_ - 1);
  std::int16_t held[channel_count];
  for (std::size_t c = 0; c < channel_count; ++c) held[c] = last[c];
  for (std::int64_t s = until - fill; s < until; ++s)
    for (std::size_t c = 0; c < channel_count; ++c) slot(s)[c] = held[c];
}

/// Into the ring, in one piece or two. The size of a scan is known here, so that the copy is a few instructions.
void Recorder::store(std::int64_t first, const std::int16_t* scans, std::int64_t count) {
  const std::size_t at = place(first);
  const auto scans_left = static_cast<std::int32_t>((storage_.size() - at) / channel_count);
  auto left = static_cast<std::int32_t>(count);
  std::int32_t run = left < scans_left ? left : scans_left;
  for (std::int16_t* to = &storage_[at]; left > 0; to = storage_.data(), run = left) {
    left -= run;
    for (; run > 0; --run, to += channel_count, scans += channel_count)
      __builtin_memcpy(to, scans, channel_count * sizeof *to);
  }
}

/// In wire order, from where it stands. The record may be given up in the middle of it: what it has counted then
/// belongs to `counting_`, which is no longer the record.
void Recorder::count_in() {
  const std::uint32_t record = load_shared(record_);
  if (counting_ != record) {
    counted_ = 0;
    crc_ = 0;
    store_shared(counting_, record);
  }
  const std::int32_t there = load_shared(ready_) - counted_;
  for (std::int32_t left = there < checksum_pace ? there : checksum_pace; left > 0;) {
    const std::size_t first = place(start_ + counted_);
    const auto to_end = static_cast<std::int32_t>((storage_.size() - first) / channel_count);
    const std::int32_t run = left < to_end ? left : to_end;
    if constexpr (std::endian::native == std::endian::little) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&storage_[first]);
      crc_ = crc32({bytes, static_cast<std::size_t>(run) * channel_count * sizeof(std::int16_t)}, crc_);
    } else {
      std::uint8_t bytes[2 * channel_count];
      for (std::int32_t i = 0; i < run; ++i) {
        copy(static_cast<std::uint64_t>(counted_ + i), 1, sample_bits, bytes);
        crc_ = crc32(bytes, crc_);
      }
    }
    left -= run;
    store_shared(counted_, counted_ + run);
  }
}

void Recorder::finish() {
  complete_ = true;
  armed_ = false;
  // keep only the gaps that lie inside the record, relative to its start
  std::size_t kept = 0;
  overruns_ = 0;
  for (std::size_t g = 0; g < gap_count_; ++g) {
    std::int64_t first = gaps_[g].first - start_, end = first + gaps_[g].count;
    if (first < 0) first = 0;
    if (end > length_) end = length_;
    if (end <= first) continue;
    gaps_[kept++] = {first, end - first};
    overruns_ += static_cast<std::uint32_t>(end - first);
  }
  gap_count_ = kept;
}

std::size_t Recorder::available(std::uint64_t cursor) const {
  if (!complete_ || cursor >= static_cast<std::uint64_t>(length_)) return 0;
  return static_cast<std::size_t>(length_) - static_cast<std::size_t>(cursor);
}

bool Recorder::finished(std::uint64_t cursor) const {
  return complete_ && cursor >= static_cast<std::uint64_t>(length_);
}

std::size_t Recorder::scan_bytes(std::uint32_t mask) const {
  const std::size_t samples = 2 * count_bits(mask & sample_bits);
  if ((mask & timestamp_bit) == 0) return samples;
  return (samples + 7) / 8 * 8 + 8;  // the 64-bit time stamp is aligned to its size
}

std::span<const std::uint8_t> Recorder::in_place(std::uint64_t cursor, std::size_t scans,
                                                 std::uint32_t mask) const {
  if (mask != sample_bits || std::endian::native != std::endian::little) return {};
  const std::size_t first = place(start_ + static_cast<std::int64_t>(cursor));
  const std::size_t to_end = (storage_.size() - first) / channel_count;
  const std::size_t bytes = (scans < to_end ? scans : to_end) * channel_count * sizeof(std::int16_t);
  return {reinterpret_cast<const std::uint8_t*>(&storage_[first]), bytes};
}

void Recorder::copy(std::uint64_t cursor, std::size_t scans, std::uint32_t mask, std::uint8_t* out) const {
  const std::size_t step = scan_bytes(mask);
  for (std::size_t i = 0; i < scans; ++i, out += step) {
    const std::int64_t sample = start_ + static_cast<std::int64_t>(cursor + i);
    const std::int16_t* from = slot(sample);
    std::size_t at = 0;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if ((mask >> c & 1U) == 0) continue;
      const auto value = static_cast<std::uint16_t>(from[c]);
      out[at++] = static_cast<std::uint8_t>(value & 0xFFU);
      out[at++] = static_cast<std::uint8_t>(value >> 8);
    }
    if ((mask & timestamp_bit) == 0) continue;
    while (at % 8 != 0) out[at++] = 0;
    const auto ns = static_cast<std::uint64_t>(sample * period_ns_);
    for (int b = 0; b < 8; ++b) out[at++] = static_cast<std::uint8_t>(ns >> (8 * b));
  }
}

}  // namespace powbench::firmware
