#include "firmware/recorder.h"

#include <bit>
#include <cstdint>

#include "core/crc32.h"

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
  if (distance < 0) distance += capacity_;
  if (distance >= capacity_) distance -= capacity_;
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
  counted_ = 0;
  gap_count_ = 0;
  overruns_ = 0;
  crc_ = 0;
  marked_.fill(never);
}

void Recorder::trigger(Tick edge) {
  edge_ = edge;
  start_ = edge.sample_at_or_after() - pretrigger_;
  triggered_ = true;
}

void Recorder::mark(std::uint8_t bits, std::int64_t end) {
  if (!armed_) return;
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
  if (block.first_sample - lap_ >= capacity_ || block.first_sample < lap_)
    lap_ = block.first_sample - block.first_sample % capacity_;
  if (next_ >= 0 && block.first_sample > next_) {
    // lost samples: hold the last value, so that the time axis stays true, and remember where
    const std::int64_t lost = block.first_sample - next_;
    note_gap(next_, lost);
    const std::int64_t fill = lost < capacity_ ? lost : capacity_;
    const std::int16_t* last = slot(next_ - 1);
    std::int16_t held[channel_count];
    for (std::size_t c = 0; c < channel_count; ++c) held[c] = last[c];
    for (std::int64_t s = block.first_sample - fill; s < block.first_sample; ++s)
      for (std::size_t c = 0; c < channel_count; ++c) slot(s)[c] = held[c];
  }
  for (std::int64_t i = 0; i < block.samples(); ++i) {
    const std::int64_t sample = block.first_sample + i;
    if (triggered_ && sample >= start_ + length_) break;
    std::int16_t* to = slot(sample);
    for (std::size_t c = 0; c < channel_count; ++c)
      to[c] = block.scans[static_cast<std::size_t>(i) * channel_count + c];
  }
  next_ = block.first_sample + block.samples();
  if (!triggered_) return;
  // Twice the pace of the samples: the checksum catches up with the pre-trigger, and no block has to wait for the
  // whole record.
  count_in(2 * block.samples());
  if (counted_ == length_) finish();
}

/// Takes up to `scans` more of the scans that are there into the checksum, in wire order.
void Recorder::count_in(std::int64_t scans) {
  const std::int64_t there = (next_ - start_ < length_ ? next_ - start_ : length_) - counted_;
  for (std::int64_t left = scans < there ? scans : there; left > 0;) {
    const std::int64_t first = (start_ + counted_) % capacity_;
    const std::int64_t run = left < capacity_ - first ? left : capacity_ - first;
    if constexpr (std::endian::native == std::endian::little) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(slot(first));
      crc_ = crc32({bytes, static_cast<std::size_t>(run) * channel_count * sizeof(std::int16_t)}, crc_);
    } else {
      std::uint8_t bytes[2 * channel_count];
      for (std::int64_t i = 0; i < run; ++i) {
        copy(static_cast<std::uint64_t>(counted_ + i), 1, sample_bits, bytes);
        crc_ = crc32(bytes, crc_);
      }
    }
    counted_ += run;
    left -= run;
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
