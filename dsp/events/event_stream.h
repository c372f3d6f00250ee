#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

/// Events of one closing while it comes in. The same extraction as of a whole record, on what has come: contacts are
/// detected every `stream_block`; an edge that is `stream_wait` old makes the extraction run, which dates it with all
/// samples up to then.

namespace powbench::dsp {

inline constexpr double stream_block = 5e-3;  ///< s of samples from one look to the next
inline constexpr double stream_wait = 20e-3;  ///< s of samples behind an event before it is given out
/// s: no event is given out later than this behind its own time, but for those that an earlier look did not show.
inline constexpr double stream_latency = stream_wait + stream_block;
inline constexpr double stream_longest =
    1.0;  ///< s before and behind the gate edge that are kept; what is later is not looked at

struct StreamEvent {
  enum class Kind : std::uint8_t { touch, release, seat };
  Channel channel{};
  Kind kind{};
  Measured time;     ///< s after switch-on
  double known = 0;  ///< s after switch-on: the last sample that was there when it was given out
  double latency() const { return known - time.value; }
};

class EventStream {
 public:
  /// `shape`: the record without its samples (rate, fire sample, channels, conditions). Throws std::invalid_argument
  /// for bad options, no channel, a rate that is not above 0, or more than `stream_longest` before the gate edge.
  explicit EventStream(Record shape, const ExtractOptions& = {});

  /// Scans in the order of the channels, the first one being sample `first` of the record; returns what became known,
  /// in the order in which it became known. However the samples are cut into pieces, the events are the same to the
  /// last bit. Throws std::invalid_argument, and takes nothing, where `first` is not the sample that follows, or the
  /// last scan is not whole. Memory: 2 bytes a channel and sample, `stream_longest` before and behind the gate edge.
  std::vector<StreamEvent> push(std::int64_t first, std::span<const std::int16_t> scans);

  /// The record ends here: what was still waited for.
  std::vector<StreamEvent> finish();

 private:
  void look(double known, double until, bool last, std::vector<StreamEvent>& out);
  bool due(double until) const;
  double known() const;

  Record record_;
  ExtractOptions options_;
  std::array<std::vector<StreamEvent>, channel_count> given_;
  std::int64_t block_ = 0, next_ = 0, limit_ = 0;  ///< samples: of a look, of the next one, kept at most
  std::int64_t came_ = 0;
  double asked_ = -1;  ///< s: edges up to here have been extracted
};

}  // namespace powbench::dsp
