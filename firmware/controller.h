#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "firmware/config_guard.h"
#include "firmware/fire_control.h"
#include "firmware/handover.h"
#include "firmware/interlock_limits.h"
#include "firmware/interlocks.h"
#include "firmware/lease.h"
#include "firmware/phase_feed.h"
#include "firmware/recorder.h"
#include "firmware/zero_capture.h"

/// One bench controller: everything portable, put together. A port gives it memory, blocks and an output
/// compare.

namespace powbench::firmware {

/// What the front end of one channel is, as told to clients. Integers in decimal fractions: a board has no
/// printf.
struct ChannelCalibration {
  std::int64_t scale_pico = 0;         ///< 1e-12 of the IIO unit per count; 0: there is no such channel
  std::int64_t delay_ns = 0;           ///< the value shows the quantity this much earlier
  std::int64_t corner_microhertz = 0;  ///< low corner of the charge amplifier, 0 = down to DC
  std::int64_t film_area_pico = 0;     ///< 1e-12 m2, force channels only
  std::int64_t sensitivity_femto = 0;  ///< 1e-15 C/N, force channels only
  std::int64_t zero_counts = 0;        ///< reading at zero
};
using Calibrations = std::array<ChannelCalibration, channel_count>;

/// SI value of a count, and the zero, of each channel.
constexpr CountScales count_scales(const Calibrations& calibration) {
  CountScales scales;
  for (std::size_t i = 0; i < channel_count; ++i) {
    const ChannelCalibration& c = calibration[i];
    const double area = channel_table[i].unit == "N" ? static_cast<double>(c.film_area_pico) * 1e-12 : 1.0;
    scales[i] = {static_cast<double>(c.scale_pico) * 1e-12 * channel_table[i].si_per_iio_unit * area,
                 static_cast<std::int32_t>(c.zero_counts)};
  }
  return scales;
}

struct ControllerConfig {
  std::int64_t sample_rate = 100'000;   ///< Hz
  std::int64_t record_length = 14'000;  ///< scans
  std::int64_t pretrigger = 4'000;      ///< scans before the gate edge
  Calibrations calibration{};
  std::string_view calibration_id = "none";
  PhaseTrackerConfig phase;
  FireConfig fire;
  InterlockConfig interlocks;  ///< from `calibration` and `limits` by interlock_config()
  InterlockLimits limits;
  ZeroConfig zero;
};

static_assert(std::is_trivially_copyable_v<ControllerConfig>);

/// Which program on which board. What a port does not know reads "none"; the texts live as long as the program.
struct BuildIdentity {
  std::string_view commit = "none";  ///< of the sources, "-dirty" behind it when they were changed
  std::string_view board_id = "none";
  std::uint32_t image_crc32 = 0;  ///< of the program as linked, as the file that was flashed; 0: not known
};

/// What makes a configuration unfit to energise a coil, or empty.
std::string_view config_error(const ControllerConfig&, std::size_t storage_values);

class Controller {
 public:
  /// `storage`: at least record_length x channel_count values.
  Controller(const ControllerConfig& config, std::span<std::int16_t> storage)
      : config_(config),
        mains_(config.phase),
        interlocks_(config_.interlocks),
        recorder_(storage, config.record_length, config.pretrigger, 1'000'000'000 / config.sample_rate),
        fire_(config_.fire, interlocks_, mains_, recorder_),
        lease_(config.sample_rate > 0 ? config.sample_rate : 1),
        guard_({reinterpret_cast<const std::uint8_t*>(&config_), sizeof config_}),
        config_error_(firmware::config_error(config, storage.size())) {
    if (!config_error_.empty()) fire_.config_damaged(true);
    announce_zero();
  }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  /// What has to be done with a block before the next one comes: checks, gate, record. Its cost is a fraction of a
  /// block's time. Edges as FireControl::step().
  std::span<const GateEdge> control(const Block& block) {
    keep_latest(block);
    if (zero_.take(config_.zero, block)) store_shared(zero_ended_, true);
    if (const auto verdict = load_shared(guard_verdict_); verdict != no_verdict) {
      guard_verdict_ = no_verdict;
      fire_.config_damaged(verdict == damaged || !config_error_.empty());
    }
    // a port that vouches for the owner has a clock that runs ahead of the owner's
    if (!block.owner_present) pass_lease(block.samples());
    if (lease_.take_heard()) interlocks_.hear_host();
    return fire_.step(block);
  }

  /// Time that passed while nothing was sampled (a simulated rig between two requests), ms.
  void rest(std::int64_t ms) { pass_lease(ms * config_.sample_rate / 1000); }

  /// What may take longer: phase estimate, checksums of record and configuration. After each block, on a level that
  /// control() may interrupt anywhere; everything else that touches the controller holds both off.
  void background() {
    if (load_shared(zero_ended_)) end_zero_capture();
    mains_.work();
    recorder_.count_in();
    if (guard_.step()) store_shared(guard_verdict_, guard_.intact() ? intact : damaged);
  }

  /// Both, where there is only one level.
  std::span<const GateEdge> step(const Block& block) {
    const auto edges = control(block);
    background();
    return edges;
  }

  /// All that changes while it runs, without the samples of the recorder. To be put back into the same
  /// controller only: this is how a test explores the states.
  struct Memory {
    PhaseFeed mains;
    Interlocks interlocks;
    Recorder recorder;
    FireControl fire;
    Lease lease;
  };
  Memory save() const { return {mains_, interlocks_, recorder_, fire_, lease_}; }
  void restore(const Memory& memory) {
    mains_ = memory.mains;
    interlocks_ = memory.interlocks;
    recorder_ = memory.recorder;
    fire_ = memory.fire;
    lease_ = memory.lease;
  }

  /// Captures the zero of the coil's channels anew; refused unless the bench rests.
  Refusal capture_zero();
  ZeroCapture::State zero_state() const { return zero_.state(); }

  void identify(const BuildIdentity& build) { identity_ = build; }
  const BuildIdentity& identity() const { return identity_; }

  const ControllerConfig& config() const { return config_; }
  /// Why the configuration is refused; empty: it is not.
  std::string_view config_error() const { return config_error_; }
  FireControl& fire_control() { return fire_; }
  const FireControl& fire_control() const { return fire_; }
  Lease& lease() { return lease_; }
  const Lease& lease() const { return lease_; }
  const Recorder& recorder() const { return recorder_; }
  std::int16_t latest(Channel c) const { return latest_[index(c)]; }

 private:
  static constexpr std::uint8_t no_verdict = 0, intact = 1, damaged = 2;

  void announce_zero();
  void end_zero_capture();
  void pass_lease(std::int64_t samples) {
    if (lease_.pass(samples)) fire_.owner_gone();
  }

  void keep_latest(const Block& block) {
    const auto scan = block.scans.last(channel_count);
    __builtin_memcpy(latest_.data(), scan.data(), sizeof latest_);
  }

  ControllerConfig config_;
  PhaseFeed mains_;
  Interlocks interlocks_;
  Recorder recorder_;
  FireControl fire_;
  Lease lease_;
  ConfigGuard guard_;
  std::uint8_t guard_verdict_ = no_verdict;  ///< from the background, not yet seen
  ZeroCapture zero_{config_.zero};
  bool zero_ended_ = false;  ///< a capture has ended, the background has not yet taken it over
  std::string_view config_error_;
  BuildIdentity identity_;
  std::array<std::int16_t, channel_count> latest_{};
};

}  // namespace powbench::firmware
