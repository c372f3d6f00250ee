#pragma once

#include <cstdint>

#include "firmware/block.h"
#include "firmware/faults.h"

/// Continuous checks that need no command: they see every block and name the first thing that is wrong.

namespace powbench::firmware {

/// Thresholds in converter counts and samples: see interlock_config().
struct InterlockConfig {
  std::int32_t overcurrent_counts = 0;   ///< |i| above it for two samples running trips
  std::int32_t current_zero_counts = 0;  ///< reading at no current
  std::int32_t no_current_counts = 0;    ///< |i| that proves that current flows
  std::int64_t no_current_samples = 0;   ///< time allowed without current while the gate is on
  std::int64_t stuck_on_samples = 0;     ///< time allowed after the gate opened until current has ended
  std::int32_t mains_lost_counts = 0;    ///< |mains| that proves that mains is there
  std::int64_t mains_lost_samples = 0;   ///< longest time without it (1.5 half-cycles)

  std::int64_t heartbeat_samples = 25'000;  ///< longest silence of the owner while energised, 250 ms
  std::int32_t contact_open_counts = 0;     ///< contact voltage that proves it open; 0: contact not watched
  std::int64_t contact_open_samples = 200;  ///< open for this long is proven open
  std::int64_t weld_samples = 10'000;       ///< time allowed after the gate opened until the contact is open
  std::int32_t travel_least_counts = 0;     ///< laser in range: least and most; both 0: laser not watched
  std::int32_t travel_most_counts = 0;
  std::int32_t travel_open_counts = 0;      ///< below it the contact must be open
  std::int32_t travel_closed_counts = 0;    ///< above it the contact must be closed; 0: not compared
  std::int64_t implausible_samples = 500;   ///< time that an implausible signal must last
  std::int32_t saturation_counts = 32'700;  ///< |force| beyond it is clipped
  std::int64_t relay_samples = 0;           ///< time the safety relay has to follow; 0: it is not read back
};

/// What makes a record doubtful, one bit each.
enum class Mark : std::uint8_t { laser_range, force_saturated, contact_travel };
inline constexpr std::size_t mark_count = 3;
constexpr std::uint8_t bit(Mark m) {
  return static_cast<std::uint8_t>(1U << static_cast<unsigned>(m));
}

class Interlocks {
 public:
  /// State of the gate, as fire control knows it.
  struct GateView {
    bool on = false;
    std::int64_t since = 0;        ///< sample at which it last changed
    bool relay = false;            ///< the command to the safety relay: close
    std::int64_t relay_since = 0;  ///< sample at which it was last told something else
  };

  explicit Interlocks(const InterlockConfig& config) : config_(&config) {}

  /// Start of a shot: forget the history of what is watched in shots only.
  void reset(std::int64_t sample);

  /// The owner has spoken since the block before.
  void hear_host() { host_heard_ = true; }
  /// Checks one block; Fault::none, or the first thing wrong.
  Fault check(const Block&, const GateView&);

  /// The cause of a latched fault is still there.
  bool present(Fault) const;

  /// False while the zero of the current is not known: then no current is seen, and nothing may be armed.
  void current_known(bool yes) { current_known_ = yes; }

  /// The coil has carried no current for a quarter of the stuck-on time.
  bool coil_quiet(std::int64_t sample) const {
    return sample - last_current_ > config_->stuck_on_samples / 4;
  }
  /// The contact is proven open, or not watched.
  bool contact_open(std::int64_t sample) const {
    return config_->contact_open_counts == 0 || sample - last_closed_ > config_->contact_open_samples;
  }
  /// The relay has been closed without coil current for longer than a switch that is stuck on could hide: the switch
  /// is off.
  bool switch_proven(std::int64_t sample) const {
    return config_->relay_samples == 0 ||
           sample - (relay_out_ > last_current_ ? relay_out_ : last_current_) > config_->stuck_on_samples;
  }
  /// So long after the off edge whatever has not ended by itself is a fault.
  bool waited_enough(std::int64_t since_off) const {
    return since_off > config_->weld_samples && since_off > config_->stuck_on_samples;
  }
  bool emergency_stop() const { return emergency_stop_; }
  bool brown_out() const { return brown_out_; }
  /// Marks of the last block.
  std::uint8_t marks() const { return marks_; }

 private:
  Fault check_stream(const Block&);
  void observe(const Block&);
  Fault judge_coil(const GateView&) const;
  Fault judge_relay(const Block&, const GateView&);
  void observe_current(const Block&);
  void observe_sensors(const Block&);

  const InterlockConfig* config_;
  std::int64_t last_mains_ = 0;  ///< last sample at which mains was seen
  std::int64_t last_current_ = -1'000'000'000;
  std::int64_t current_since_ = -1'000'000'000;  ///< start of the present run of current
  std::int64_t last_closed_ = -1'000'000'000;    ///< last sample at which the contact was not open
  std::int64_t last_open_ = 0;
  std::int64_t laser_good_ = 0;    ///< last sample with the laser in range
  std::int64_t contact_good_ = 0;  ///< last sample at which contact and travel agreed
  std::int64_t last_host_ = 0;
  std::int64_t relay_out_ = 0;     ///< last sample at which the relay was read back open
  std::int64_t relay_agreed_ = 0;  ///< last sample at which read-back and command agreed
  std::int64_t next_sample_ = -1;
  std::int64_t block_length_ = 0;
  std::int64_t counter_ = -1;
  std::int16_t kept_first_[channel_count]{}, kept_last_[channel_count]{};  ///< scans of the block before
  int over_ = 0;
  bool current_known_ = true;
  bool over_tripped_ = false;
  bool host_heard_ = false;
  bool emergency_stop_ = false, brown_out_ = false, clock_failed_ = false, relay_in_ = false;
  std::uint8_t marks_ = 0;
};

}  // namespace powbench::firmware
