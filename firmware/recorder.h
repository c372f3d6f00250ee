#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/block.h"
#include "firmware/iiod/model.h"

/// One-shot recorder: a ring in memory that the port provides, frozen `length - pretrigger` samples after the
/// gate edge. It is also the buffer that the responder reads from.

namespace powbench::firmware {

class Recorder final : public iiod::BufferSource {
 public:
  struct Gap {
    std::int64_t first = 0;  ///< index in the record
    std::int64_t count = 0;
  };

  /// `storage` holds capacity x channel_count values; capacity must be at least `length`.
  Recorder(std::span<std::int16_t> storage, std::int64_t length, std::int64_t pretrigger,
           std::int64_t period_ns);

  /// Starts the ring anew; the old record is gone.
  void arm();
  /// The gate edge is known: the record will span [edge - pretrigger, edge - pretrigger + length).
  void trigger(Tick edge);
  /// Forgets the record in progress.
  void discard();
  void push(const Block&);
  /// Takes up to `checksum_pace` scans of the record into its checksum. Runs below the level of push() and
  /// discard(), which may interrupt it; arm() and trigger() may not.
  void count_in();
  static constexpr std::int32_t checksum_pace = 32;
  /// Doubts about the block that ends at `end`, one bit each, up to eight.
  void mark(std::uint8_t bits, std::int64_t end);

  bool complete() const { return complete_; }
  std::int64_t length() const { return length_; }
  std::int64_t pretrigger() const { return pretrigger_; }
  /// Index in the record of the first sample at or after the gate edge.
  std::int64_t fire_sample() const { return pretrigger_; }
  Tick edge() const { return edge_; }
  std::int64_t first_sample() const { return start_; }
  std::uint32_t crc() const { return counting_ == record_ ? crc_ : 0; }
  std::uint32_t overruns() const { return overruns_; }
  /// Doubts that fall into the record.
  std::uint8_t marks() const;
  std::span<const Gap> gaps() const { return {gaps_.data(), gap_count_}; }

  std::size_t available(std::uint64_t cursor) const override;
  bool finished(std::uint64_t cursor) const override;
  std::size_t scan_bytes(std::uint32_t mask) const override;
  void copy(std::uint64_t cursor, std::size_t scans, std::uint32_t mask, std::uint8_t* out) const override;
  std::span<const std::uint8_t> in_place(std::uint64_t cursor, std::size_t scans,
                                         std::uint32_t mask) const override;
  std::uint32_t generation() const override { return generation_; }

 private:
  std::size_t place(std::int64_t sample) const;
  std::int16_t* slot(std::int64_t sample);
  const std::int16_t* slot(std::int64_t sample) const;
  void note_gap(std::int64_t first, std::int64_t count);
  void fill_gap(std::int64_t until);
  void store(std::int64_t first, const std::int16_t* scans, std::int64_t count);
  void finish();

  std::span<std::int16_t> storage_;
  std::int64_t capacity_, length_, pretrigger_, period_ns_;
  std::int64_t start_ = 0;  ///< sample index of the record's first scan
  std::int64_t next_ = -1;  ///< sample index expected next; -1: nothing recorded yet
  Tick edge_{};
  bool armed_ = false, triggered_ = false, complete_ = false;
  std::uint32_t generation_ = 0, overruns_ = 0;
  std::uint32_t record_ = 0;  ///< changes with every record begun or given up
  std::int32_t ready_ = 0;    ///< scans of the record that are in the storage
  // of the lower level: the record it counts, scans in the checksum
  std::uint32_t counting_ = 0, crc_ = 0;
  std::int32_t counted_ = 0;
  std::array<std::int64_t, 8> marked_{};  ///< end of the last block with that mark
  std::array<Gap, 8> gaps_{};
  std::size_t gap_count_ = 0;
  std::int64_t lap_ = 0;  ///< a multiple of the capacity, near the newest sample
};

}  // namespace powbench::firmware
