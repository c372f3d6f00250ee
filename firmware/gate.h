#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/block.h"

/// The only door to the coil. De-energised is the default; energise() is the one function that can switch it
/// on.

namespace powbench::firmware {

class Gate {
 public:
  /// What must hold for the coil to be energised; each is established by fire control, and all are checked
  /// here.
  struct Permit {
    bool armed_and_fired = false;   ///< one-shot token: armed, then fired, not used since
    bool phase_valid = false;       ///< the mains estimate is valid now
    bool no_fault = false;          ///< no interlock has tripped
    bool config_intact = false;     ///< the configuration still has its checksum
    std::int64_t hold_samples = 0;  ///< on-time asked for
    std::int64_t hold_limit = 0;    ///< hard cap
  };

  /// Schedules the on edge at `at` and the off edge `hold_samples` later, both at once, so that no later code
  /// has to remember to switch off. False (and nothing scheduled) unless every condition of the permit holds.
  bool energise(const Permit& permit, Tick at) {
    if (!permit.armed_and_fired || !permit.phase_valid || !permit.no_fault || !permit.config_intact)
      return false;
    if (permit.hold_samples <= 0 || permit.hold_samples > permit.hold_limit) return false;
    if (on_ || pending_on_) return false;
    pending_on_ = true;
    on_at_ = at;
    off_at_ = {at.sample + permit.hold_samples, at.fraction};
    return true;
  }

  /// Off at once: at the first sample not yet converted.
  void force_off(std::int64_t next_sample) {
    pending_on_ = false;
    if (on_) off_at_ = {next_sample, 0};
  }

  /// Edges that fall before `end`, to be handed to the output compare. Called once a block.
  std::span<const GateEdge> edges_before(std::int64_t end) {
    std::size_t n = 0;
    if (pending_on_ && on_at_.sample < end) {
      edges_[n++] = {true, on_at_, off_at_};
      pending_on_ = false;
      on_ = true;
    }
    if (on_ && off_at_.sample < end) {
      edges_[n++] = {false, off_at_};
      on_ = false;
    }
    return {edges_.data(), n};
  }

  bool on() const { return on_; }
  bool idle() const { return !on_ && !pending_on_; }
  Tick on_at() const { return on_at_; }
  Tick off_at() const { return off_at_; }

 private:
  bool on_ = false;
  bool pending_on_ = false;
  Tick on_at_{};
  Tick off_at_{};
  std::array<GateEdge, 2> edges_{};
};

}  // namespace powbench::firmware
