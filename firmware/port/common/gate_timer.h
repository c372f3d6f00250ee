#pragma once

#include <cstdint>

#include "firmware/block.h"

/// From gate edges on the sampling clock to the compare register of a free-running 16-bit timer. Arithmetic and
/// decisions only; the port writes the registers.

namespace powbench::firmware::port {

/// Sample k is triggered when the timer shows `first_trigger` + k * ticks_per_sample (modulo 2^16).
struct TimeBase {
  std::int32_t ticks_per_sample = 1700;
  std::int32_t first_trigger = 1700;

  /// Tick of an instant, counted from the start of the timer, to the nearest: half a tick of error at most.
  constexpr std::int64_t ticks(Tick at) const {
    return first_trigger + at.sample * ticks_per_sample +
           ((static_cast<std::int64_t>(at.fraction) * ticks_per_sample + 32768) >> 16);
  }
  /// The full count behind a reading of the 16-bit counter, `sample` being a sample that was triggered less than
  /// 2^16 ticks before the reading.
  constexpr std::int64_t unwrap(std::uint16_t counter, std::int64_t sample) const {
    const std::int64_t trigger = first_trigger + sample * ticks_per_sample;
    return trigger + static_cast<std::uint16_t>(counter - static_cast<std::uint16_t>(trigger));
  }
};

/// Holds the edges that the controller has given out and says what to write when. An on edge that can no longer be met
/// is dropped and counted, never made late; an off edge that can no longer be met is made at once.
class GateTimer {
 public:
  static constexpr std::int64_t margin =
      340;  ///< ticks (2 us): nearer than this is too near to set a compare
  static constexpr std::int64_t horizon =
      60'000;  ///< ticks: farther than this the 16-bit compare would be ambiguous

  enum class Write : std::uint8_t { nothing, on_at, off_at, off_now, finished };
  struct Action {
    Write write = Write::nothing;
    std::uint16_t compare = 0;
    std::int64_t off_in = 0;  ///< with on_at: ticks from now until the coil must be off whatever happens
  };

  explicit GateTimer(const TimeBase& base) : base_(base) {}

  void take(const GateEdge& edge) {
    const std::int64_t at = base_.ticks(edge.at);
    if (edge.on) {
      if (edge.off_by.sample <= edge.at.sample) {  // without an end of its own it is no edge
        ++missed_;
        return;
      }
      on_ = at, on_state_ = Edge::waiting;
      // a sample later than the off edge itself, so that the two never compete
      off_by_ = base_.ticks(edge.off_by) + base_.ticks_per_sample;
    } else {
      off_ = at, off_state_ = Edge::waiting;
      // switched off before it was on, an abort: the on edge is void
      if (on_state_ != Edge::none && on_ >= off_) on_state_ = Edge::none, off_ = 0;
    }
  }

  /// Forgets every edge; the port has taken the gate off.
  void cancel() { on_state_ = off_state_ = Edge::none; }
  /// No edge waits, and none is set.
  bool idle() const { return on_state_ == Edge::none && off_state_ == Edge::none; }

  /// What to write at tick `now`. To be called at least once a block, until it says `nothing`.
  Action poll(std::int64_t now) {
    if (on_state_ == Edge::set && now > on_) on_state_ = Edge::none;
    if (off_state_ == Edge::set && now > off_ + margin) {
      off_state_ = Edge::none;
      return {Write::finished};
    }
    if (off_state_ == Edge::waiting && off_ - now < margin) {
      off_state_ = on_state_ = Edge::none;
      return {Write::off_now};
    }
    if (on_state_ == Edge::waiting && on_ - now < margin) {
      on_state_ = Edge::none;
      ++missed_;
    }
    if (on_state_ == Edge::waiting && on_ - now < horizon) {
      on_state_ = Edge::set;
      return {Write::on_at, static_cast<std::uint16_t>(on_), off_by_ - now};
    }
    // there is one compare register: the off edge takes it over when the on edge has passed
    if (off_state_ == Edge::waiting && on_state_ == Edge::none && off_ - now < horizon) {
      off_state_ = Edge::set;
      return {Write::off_at, static_cast<std::uint16_t>(off_)};
    }
    return {};
  }

  const TimeBase& base() const { return base_; }
  std::uint32_t missed() const { return missed_; }

 private:
  enum class Edge : std::uint8_t { none, waiting, set };
  TimeBase base_;
  std::int64_t on_ = 0, off_ = 0, off_by_ = 0;
  Edge on_state_ = Edge::none, off_state_ = Edge::none;
  std::uint32_t missed_ = 0;
};

}  // namespace powbench::firmware::port
