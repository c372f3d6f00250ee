#pragma once

#include <cstdint>

#include "firmware/block.h"

namespace powbench::firmware {

/// How the zero of the coil's channels is found: with the gate off and the safety relay open no current can flow, so
/// the mean of the readings is the zero. 0 samples: the front end has no offset, nothing is captured.
struct ZeroConfig {
  std::int32_t samples = 0;       ///< of a capture: whole periods of 50 and 60 Hz, 0.1 s
  std::int32_t most_counts = 0;   ///< an offset beyond it is a damaged front end
  std::int32_t quiet_counts = 0;  ///< current whose readings spread wider than this flows
};

/// Mean and spread over one capture. zero = (1 / N) sum x.
class ZeroCapture {
 public:
  enum class State : std::uint8_t {
    unwanted,  ///< nothing to capture
    capturing,
    done,
    flowing,  ///< the readings spread: current flows though nothing can be on
    far,      ///< the mean is beyond what an offset can be
  };

  explicit ZeroCapture(const ZeroConfig& c) : state_(c.samples > 0 ? State::capturing : State::unwanted) {}

  void begin(const ZeroConfig& c) { *this = ZeroCapture(c); }

  /// Takes a block; true when it has ended the capture.
  bool take(const ZeroConfig& c, const Block& block) {
    if (state_ != State::capturing) return false;
    const auto n = static_cast<std::int32_t>(block.samples());
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t current = block.at(i, Channel::coil_current);
      current_sum_ += current;
      voltage_sum_ += block.at(i, Channel::coil_voltage);
      if (current < least_) least_ = current;
      if (current > most_) most_ = current;
    }
    taken_ += n;
    if (taken_ < c.samples) return false;
    const std::int32_t current = mean(current_sum_), voltage = mean(voltage_sum_);
    const auto credible = [&](std::int32_t v) { return v <= c.most_counts && v >= -c.most_counts; };
    state_ = most_ - least_ > c.quiet_counts            ? State::flowing
             : !credible(current) || !credible(voltage) ? State::far
                                                        : State::done;
    return true;
  }

  State state() const { return state_; }
  std::int32_t current() const { return mean(current_sum_); }
  std::int32_t voltage() const { return mean(voltage_sum_); }

 private:
  std::int32_t mean(std::int64_t sum) const {
    return taken_ == 0 ? 0
                       : static_cast<std::int32_t>((2 * sum + (sum < 0 ? -taken_ : taken_)) / (2 * taken_));
  }
  State state_;
  std::int32_t taken_ = 0, least_ = 32767, most_ = -32768;
  std::int64_t current_sum_ = 0, voltage_sum_ = 0;
};

}  // namespace powbench::firmware
