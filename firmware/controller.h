#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "firmware/calibration_store.h"
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

/// The thresholds for a front end as calibrated (`to`): where they were in SI.
InterlockConfig calibrated(const InterlockConfig& nominal, const Calibrations& from, const Calibrations& to);
/// What makes thresholds unfit for these channels, or empty.
std::string_view interlock_error(const InterlockConfig&, const Calibrations&);
/// What makes a calibration impossible for this front end, or empty: channels that come or go, gains beyond the
/// tolerance of its parts, delays beyond 1 ms.
std::string_view calibration_error(const ControllerConfig& nominal, const StoredCalibration&);

/// What makes a configuration unfit to energise a coil, or empty.
std::string_view config_error(const ControllerConfig&, std::size_t storage_values);

class Controller {
 public:
  /// `storage`: at least record_length x channel_count values.
  Controller(const ControllerConfig& config, std::span<std::int16_t> storage)
      : nominal_(config),
        config_(config),
        mains_(config.phase),
        interlocks_(config_.interlocks),
        recorder_(storage, config.record_length, config.pretrigger, 1'000'000'000 / config.sample_rate),
        fire_(config_.fire, interlocks_, mains_, recorder_),
        lease_(config.sample_rate > 0 ? config.sample_rate : 1),
        guard_({reinterpret_cast<const std::uint8_t*>(&config_), sizeof config_}),
        config_error_(firmware::config_error(config, storage.size())) {
    if (!config_error_.empty()) fire_.config_damaged(true);
    announce();
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

  /// Takes the calibration that `memory` holds. Once, before boot(), which is told calibrations().intact().
  void use_memory(CalibrationMemory& memory);
  /// One channel of the calibration to be stored.
  Refusal draft(std::size_t channel, const ChannelCalibration& row);
  /// The draft is complete: it is stored as soon as the port finds the time, and in force from then on. Refused while a
  /// shot is armed or not over, and when it would make the bench unfit.
  Refusal propose(const Certificate&, std::int64_t switch_delay_ns);
  /// For the port's main loop, outside of its lock: writes what is due. Long.
  bool save_calibration() { return calibrations_.save(); }
  /// Then, under the lock: takes it over, or says that it was not stored.
  void take_calibration(bool saved);
  const CalibrationStore& calibrations() const { return calibrations_; }
  const Certificate& certificate() const { return certificate_; }

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

  void announce();
  void end_zero_capture();
  bool at_rest() const;
  void apply(const StoredCalibration&);
  void pass_lease(std::int64_t samples) {
    if (lease_.pass(samples)) fire_.owner_gone();
  }

  void keep_latest(const Block& block) {
    const auto scan = block.scans.last(channel_count);
    __builtin_memcpy(latest_.data(), scan.data(), sizeof latest_);
  }

  const ControllerConfig nominal_;  ///< as compiled
  ControllerConfig config_;         ///< with calibration and zero
  PhaseFeed mains_;
  Interlocks interlocks_;
  Recorder recorder_;
  FireControl fire_;
  Lease lease_;
  ConfigGuard guard_;
  std::uint8_t guard_verdict_ = no_verdict;  ///< from the background, not yet seen
  ZeroCapture zero_{config_.zero};
  bool zero_ended_ = false;  ///< a capture has ended, the background has not yet taken it over
  CalibrationStore calibrations_;
  Certificate certificate_;  ///< in force
  std::string_view config_error_;
  BuildIdentity identity_;
  std::array<std::int16_t, channel_count> latest_{};
};

}  // namespace powbench::firmware
