#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "firmware/config_guard.h"
#include "firmware/fire_control.h"
#include "firmware/interlocks.h"
#include "firmware/phase_tracker.h"
#include "firmware/recorder.h"

/// One bench controller: everything portable, put together. A port gives it memory, blocks and an output
/// compare.

namespace powbench::firmware {

/// What the front end of one channel is, as told to clients. Integers in decimal fractions: a board has no
/// printf.
struct ChannelCalibration {
  std::int64_t scale_pico = 0;         ///< 1e-12 of the IIO unit per count
  std::int64_t delay_ns = 0;           ///< the value shows the quantity this much earlier
  std::int64_t corner_microhertz = 0;  ///< low corner of the charge amplifier, 0 = down to DC
  std::int64_t film_area_pico = 0;     ///< 1e-12 m2, force channels only
  std::int64_t sensitivity_femto = 0;  ///< 1e-15 C/N, force channels only
};

struct ControllerConfig {
  std::int64_t sample_rate = 100'000;   ///< Hz
  std::int64_t record_length = 14'000;  ///< scans
  std::int64_t pretrigger = 4'000;      ///< scans before the gate edge
  std::array<ChannelCalibration, channel_count> calibration{};
  std::string_view calibration_id = "none";
  PhaseTrackerConfig phase;
  FireConfig fire;
  InterlockConfig interlocks;
};

static_assert(std::is_trivially_copyable_v<ControllerConfig>);

/// What makes a configuration unfit to energise a coil, or empty.
std::string_view config_error(const ControllerConfig&, std::size_t storage_values);

class Controller {
 public:
  /// `storage`: at least record_length x channel_count values.
  Controller(const ControllerConfig& config, std::span<std::int16_t> storage)
      : config_(config),
        tracker_(config.phase),
        interlocks_(config_.interlocks),
        recorder_(storage, config.record_length, config.pretrigger, 1'000'000'000 / config.sample_rate),
        fire_(config_.fire, interlocks_, tracker_, recorder_),
        guard_({reinterpret_cast<const std::uint8_t*>(&config_), sizeof config_}),
        config_error_(firmware::config_error(config, storage.size())) {
    if (!config_error_.empty()) fire_.config_damaged(true);
  }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  std::span<const GateEdge> step(const Block& block) {
    for (std::size_t c = 0; c < channel_count; ++c)
      latest_[c] = block.at(block.samples() - 1, static_cast<Channel>(c));
    if (guard_.step()) fire_.config_damaged(!guard_.intact() || !config_error_.empty());
    return fire_.step(block);
  }

  /// All that changes while it runs, without the samples of the recorder. To be put back into the same
  /// controller only: this is how a test explores the states.
  struct Memory {
    PhaseTracker tracker;
    Interlocks interlocks;
    Recorder recorder;
    FireControl fire;
  };
  Memory save() const { return {tracker_, interlocks_, recorder_, fire_}; }
  void restore(const Memory& memory) {
    tracker_ = memory.tracker;
    interlocks_ = memory.interlocks;
    recorder_ = memory.recorder;
    fire_ = memory.fire;
  }

  const ControllerConfig& config() const { return config_; }
  /// Why the configuration is refused; empty: it is not.
  std::string_view config_error() const { return config_error_; }
  FireControl& fire_control() { return fire_; }
  const FireControl& fire_control() const { return fire_; }
  const Recorder& recorder() const { return recorder_; }
  std::int16_t latest(Channel c) const { return latest_[index(c)]; }

 private:
  ControllerConfig config_;
  PhaseTracker tracker_;
  Interlocks interlocks_;
  Recorder recorder_;
  FireControl fire_;
  ConfigGuard guard_;
  std::string_view config_error_;
  std::array<std::int16_t, channel_count> latest_{};
};

}  // namespace powbench::firmware
