#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channels.h"
#include "firmware/block.h"

/// From the converters' buffers to blocks in scan order, and the queue between the interrupt that collects them and the
/// one that works on them.

namespace powbench::firmware::port {

/// Where one channel of the record comes from. `shift` brings the converter's sum of samples to 16 bits. A bipolar
/// channel has its zero in the middle of the range; a unipolar one keeps 15 bits, 0 .. 32767.
struct ChannelSource {
  std::uint8_t converter = 0;  ///< index into the list of buffers
  std::uint8_t rank = 0;       ///< place in that converter's sequence
  std::uint8_t shift = 0;
  bool bipolar = true;
};
using ChannelSources = std::array<ChannelSource, channel_count>;

/// Half of a converter's circular buffer: `ranks` values per sample, in the order of conversion.
struct ConverterHalf {
  const volatile std::uint16_t* values = nullptr;
  std::uint8_t ranks = 1;
};

constexpr std::int16_t to_counts(std::uint16_t raw, const ChannelSource& source) {
  const std::int32_t full = static_cast<std::int32_t>(raw) << source.shift;
  return static_cast<std::int16_t>(source.bipolar ? full - 32768 : full >> 1);
}

/// Writes the samples of one half to `scans` (samples x channel_count).
template <std::size_t Converters>
void assemble(const std::array<ConverterHalf, Converters>& halves, const ChannelSources& sources,
              std::span<std::int16_t> scans) {
  for (std::size_t c = 0; c < channel_count; ++c) {
    const ConverterHalf& half = halves[sources[c].converter];
    const volatile std::uint16_t* from = half.values + sources[c].rank;
    for (std::size_t at = c; at < scans.size(); at += channel_count, from += half.ranks)
      scans[at] = to_counts(*from, sources[c]);
  }
}

/// Which half is due, from the flags of a circular buffer. A half that was not fetched in time is lost, and the one
/// after it is being written already: both are passed over, and the jump in the sample index says so.
class HalfOrder {
 public:
  enum class Due : std::uint8_t { nothing, first, second, lost };
  Due next(bool half_done, bool full_done) {
    if (!half_done && !full_done) return Due::nothing;
    // both flags: two halves have ended since the last call; the wrong flag alone: the other one was missed
    const bool in_order = second_ ? full_done && !half_done : half_done && !full_done;
    if (!in_order) return Due::lost;
    second_ = !second_;
    return second_ ? Due::first : Due::second;
  }
  /// Halves that `lost` stands for: the missing one and the one that revealed it.
  static constexpr std::int64_t halves_lost = 2;

 private:
  bool second_ = false;  ///< the second half is expected next
};

/// What the board found out about itself while a block was collected. Any but the last keeps the coil off.
struct Alarms {
  bool stop_open = false;   ///< the stop chain
  bool supply_low = false;  ///< the supply monitor
  bool cut_off = false;     ///< the gate's hardware cut-off has tripped, or has refused an on edge
  bool no_crystal = false;  ///< the clock is the internal oscillator
  bool relay_in = false;    ///< read back; for the interlocks to judge
  bool any() const { return stop_open || supply_low || cut_off || no_crystal; }
};

/// Blocks on their way from one interrupt to a lower one: one writer, one reader, no lock. When it is full the block is
/// dropped, and the reader sees the jump in `first_sample`.
template <std::size_t Samples, std::size_t Slots>
class BlockQueue {
 public:
  struct Slot {
    std::int64_t first_sample = 0;
    Alarms alarms;
    bool overrun = false;  ///< something was lost: the scans are not to be trusted
    std::array<std::int16_t, Samples * channel_count> scans{};

    Block block() const {
      return {.first_sample = first_sample,
              .scans = scans,
              .emergency_stop = alarms.stop_open,
              .comparator_trip = alarms.cut_off,
              .overrun = overrun,
              .brown_out = alarms.supply_low,
              .clock_failed = alarms.no_crystal,
              .relay_in = alarms.relay_in};
    }
  };

  /// The slot to fill, or nullptr when the reader is too far behind. commit() hands it over.
  Slot* free_slot() {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == Slots) {
      ++dropped_;
      return nullptr;
    }
    return &slots_[head % Slots];
  }
  void commit() { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// The oldest filled slot, or nullptr. release() gives it back.
  const Slot* front() const {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    return head_.load(std::memory_order_acquire) == tail ? nullptr : &slots_[tail % Slots];
  }
  void release() { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  std::uint32_t dropped() const { return dropped_; }

 private:
  static_assert((Slots & (Slots - 1)) == 0, "the index wraps at 2^32");
  std::array<Slot, Slots> slots_{};
  std::atomic<std::uint32_t> head_{0}, tail_{0};
  std::uint32_t dropped_ = 0;
};

}  // namespace powbench::firmware::port
