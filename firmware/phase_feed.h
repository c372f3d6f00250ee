#pragma once

#include <array>
#include <cstdint>

#include "firmware/block.h"
#include "firmware/handover.h"
#include "firmware/phase_tracker.h"

/// Phase tracking on two levels: the interrupt of the samples leaves sums in a queue, a lower one takes them to the
/// tracker and publishes what it finds.

namespace powbench::firmware {

/// push(), mark_gap() and estimate() belong to the level of the samples and may interrupt work() anywhere. reset()
/// and all reading from elsewhere need both levels held off. Copied as it stands: no pointers.
class PhaseFeed {
 public:
  explicit PhaseFeed(const PhaseTrackerConfig& config)
      : rate_(config.sample_rate),
        nominal_hertz_(config.nominal_hertz),
        tracker_(config),
        decimation_(tracker_.decimation()) {
    reset();
  }

  /// Forgets everything; the next sample has index 0.
  void reset();
  void push(const Block&);
  /// `lost` samples are missing before the next one. The estimate is invalid from here on.
  void mark_gap(std::int64_t lost);

  const PhaseEstimate& estimate() const {
    const Published& newest = published_[load_shared(newest_)];
    return newest.gaps == gaps_seen_ ? newest.estimate : until_then_;
  }
  /// The newest point that the lower level has taken does not look like the mains of a cycle ago: no edge now.
  bool suspicious() const { return load_shared(suspicious_) != 0; }
  PhaseInstant next_instant(CentiDegrees target, std::int64_t earliest) const {
    return firmware::next_instant(estimate(), rate_, target, earliest);
  }

  /// The lower level: takes what has come into the tracker. Some 500 instructions a point of the history (0.1 ms),
  /// and once a millisecond the estimate.
  void work();

 private:
  struct Entry {
    std::int32_t value;  ///< sum of counts, or samples lost
    std::uint32_t gap;   ///< 0: a sum; else the number of gaps seen so far
  };
  struct Published {
    PhaseEstimate estimate;
    std::uint32_t gaps = 0;  ///< gaps the tracker had seen
  };
  static constexpr std::uint32_t slots = 32;  ///< 3.2 ms; an estimate is too old long before

  void put(Entry);
  void doubt();

  float rate_, nominal_hertz_;
  PhaseTracker tracker_;
  std::int32_t decimation_;
  std::int32_t sum_ = 0, summed_ = 0;
  std::int64_t dropped_ = 0;  ///< samples that found the queue full
  std::array<Entry, slots> queue_{};
  std::uint32_t head_ = 0, tail_ = 0;
  std::uint32_t gaps_seen_ = 0, gaps_done_ = 0;
  PhaseEstimate until_then_;  ///< what is told from a gap to the next estimate
  std::array<Published, 2> published_{};
  std::uint32_t newest_ = 0;
  std::uint32_t suspicious_ = 0;
};

}  // namespace powbench::firmware
