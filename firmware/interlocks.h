#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/block.h"

/// Continuous checks that need no command: they see every block and name the first thing that is wrong.

namespace powbench::firmware {

enum class Fault : std::uint8_t {
  none,
  mains_lost,
  phase_invalid,
  coil_overcurrent,
  coil_stuck_on,
  coil_not_energising,
  samples_lost,
  emergency_stop,
};

/// One sentence: what happened and what to do.
std::string_view reason(Fault);

/// Thresholds in converter counts and samples, worked out once by the port from its front end.
struct InterlockConfig {
  std::int32_t overcurrent_counts = 0;  ///< |i| above it for two samples running trips
  std::int32_t no_current_counts = 0;   ///< |i| that proves that current flows
  std::int64_t no_current_samples = 0;  ///< time allowed after the gate until current flows
  std::int64_t stuck_on_samples = 0;    ///< time allowed after the gate opened until current has ended
  std::int32_t mains_lost_counts = 0;   ///< |mains| that proves that mains is there
  std::int64_t mains_lost_samples = 0;  ///< longest time without it (1.5 half-cycles)
};

class Interlocks {
 public:
  explicit Interlocks(const InterlockConfig& config) : config_(config) {}

  /// Start of a shot: forget the history.
  void reset(std::int64_t sample);

  /// Checks one block. `gate_on` and `gate_since`: state of the gate and the sample it last changed.
  Fault check(const Block&, bool gate_on, std::int64_t gate_since);

  /// The coil has carried no current for the stuck-on time.
  bool coil_quiet(std::int64_t sample) const { return sample - last_current_ > config_.stuck_on_samples / 4; }

 private:
  InterlockConfig config_;
  std::int64_t last_mains_ = 0;  ///< last sample at which mains was seen
  std::int64_t last_current_ = -1'000'000'000;
  std::int64_t next_sample_ = -1;
  int over_ = 0;
};

}  // namespace powbench::firmware
