#pragma once

#include <cstdint>
#include <string_view>

#include "core/phase.h"
#include "firmware/duty_budget.h"
#include "firmware/gate.h"
#include "firmware/interlocks.h"
#include "firmware/phase_feed.h"
#include "firmware/recorder.h"
#include "firmware/survivor.h"

/// The state machine between a command and the coil: armed, told to fire, waiting for the angle, energised,
/// recorded.

namespace powbench::firmware {

enum class State : std::uint8_t { idle, armed, firing, captured, fault };
std::string_view name(State);

/// The set-points of a shot, as they were when it was armed.
struct LatchedShot {
  std::uint32_t number = 0;  ///< of the shot since the start; 0: none was armed
  CentiDegrees closing_angle = 0;
  std::int64_t hold_time_ms = 0, touch_delay_us = 0, tolerance_millideg = 0;
};

/// Answer to a command: accepted, or why not.
enum class Refusal : std::uint8_t { accepted, wrong_state, out_of_range, faulted };

struct FireConfig {
  std::int64_t sample_rate = 100'000;   ///< Hz
  std::int64_t hold_limit_ms = 10'000;  ///< hard cap of the on-time, as the attributes tell it
  std::int64_t gate_delay_samples_256 =
      0;                          ///< gate command to coil voltage, 1/256 sample: the edge is advanced by it
  std::int64_t lead_samples = 0;  ///< time the port needs from the end of a block until it can make an edge
  std::int64_t phase_timeout_samples = 100'000;  ///< longest wait for a valid phase after fire
  std::int64_t phase_age_samples = 200;          ///< oldest estimate to fire on
  std::int64_t quiet_samples =
      500;  ///< current must have been absent this long before the shot counts as over
  BudgetConfig budget;
};

class FireControl {
 public:
  static constexpr std::int64_t longest_touch_delay_us = 50'000;
  static constexpr std::int64_t least_tolerance_millideg = 10, most_tolerance_millideg = 90'000;

  FireControl(const FireConfig&, Interlocks&, PhaseFeed&, Recorder&);

  /// Once, before the first block: what the reset was. Anything but a clean one starts in fault.
  void boot(const BootReport&);

  /// Why arm() would be refused now, one sentence; empty: it would not.
  std::string_view obstacle() const;
  /// Sets the complete state for one shot. Refused while firing, in fault, while the last shot is not over or
  /// the contact not proven open, and when the coil has been used too often or too long.
  Refusal arm();
  /// Back to idle; refused while firing.
  Refusal disarm();
  /// Spends the token that arm() gave: the coil will be energised at the next valid instant. Returns at once.
  Refusal fire();
  /// Coil off, back to idle; clears a fault when its cause is gone.
  void abort();
  /// Coil off and disarmed; a latched fault and a captured record stay as they are.
  void stop();
  /// The lease has ended: disarmed, and if the coil may be on, off with Fault::host_lost. A record that is only being
  /// completed is completed.
  void owner_gone();
  /// A command that was none of the owner's, or that the controller refuses; a latched fault keeps its sentence.
  void note_refusal(std::string_view why) {
    if (state_ != State::fault) last_error_ = why;
  }
  /// Set-points can be set unless a shot is armed or under way.
  Refusal set_closing_angle(std::int64_t centi_degrees);
  Refusal set_hold_time_ms(std::int64_t ms);
  /// Time from the coil's voltage to the contact's touch, us. 0: the coil is switched at the closing angle;
  /// otherwise it is switched so much earlier that the contact touches there.
  Refusal set_touch_delay_us(std::int64_t us);
  /// No edge is committed unless three standard uncertainties of the phase at the closing angle are within this,
  /// 0.001 deg.
  Refusal set_angle_tolerance(std::int64_t millidegrees);

  /// Why a shot cannot begin yet, found by the controller; empty: it may. The text lives as long as the program.
  void set_unready(std::string_view why) { unready_ = why; }
  /// Current flows though gate and safety relay are open, right after a start or at a capture of the zero.
  void current_at_rest();
  /// What the last record was measured with is no longer in force: it is thrown away.
  void forget_record();
  /// Gate off, current and contact at rest.
  bool at_rest() const { return gate_.idle() && !settling(); }

  /// The configuration is not what it was at the start (the controller checks its CRC).
  void config_damaged(bool damaged);
  /// The stored calibration is lost (true), or one has been stored since.
  void stored_config_lost(bool lost) { stored_lost_ = lost; }

  /// After each block: checks, scheduling, state changes. Edges for the output compare: those before the end
  /// of the block that follows, and the port's lead before that.
  std::span<const GateEdge> step(const Block&);

  State state() const { return state_; }
  Fault fault() const { return fault_; }
  std::string_view last_error() const { return last_error_; }
  bool gate_on() const { return gate_.on(); }
  /// The gate pin must be low, whatever edges the timer still holds. A port applies it after every command
  /// and every block (timer break), so that an abort is not one block late.
  bool gate_inhibited() const { return state_ != State::firing; }
  /// The safety relay in the coil's supply shall be closed: from arm to the end of the shot, and never in a fault.
  bool relay_closed() const { return state_ == State::armed || state_ == State::firing; }
  /// The last shot is still ending by itself: current dies out, contact opens. Bounded by the weld time.
  bool settling() const;
  /// Nothing may be written to flash: the supply sags or the coil is on.
  bool flash_writes_allowed() const { return !interlocks_->brown_out() && gate_.idle(); }
  CentiDegrees closing_angle() const { return closing_angle_; }
  std::int64_t hold_time_ms() const { return hold_time_ms_; }
  std::int64_t touch_delay_us() const { return touch_delay_us_; }
  std::int64_t tolerance_millideg() const { return tolerance_millideg_; }
  std::uint32_t shots_armed() const { return latched_.number; }
  const LatchedShot& latched() const { return latched_; }
  /// A shot has its set-points, and they cannot change.
  bool set_points_latched() const { return state_ == State::armed || state_ == State::firing; }
  /// Times the coil was energised since the start.
  std::uint32_t operations() const { return operations_; }
  /// Crossings that were passed over because the edge would have been late.
  std::uint32_t deadlines_missed() const { return deadlines_missed_; }
  const Survivor* survivor() const { return boot_.survivor; }
  ResetCause reset_cause() const { return boot_.cause; }
  const PhaseEstimate& phase() const { return mains_->estimate(); }
  /// Sample index of the rising zero crossing next before the gate edge, by the estimate the edge was
  /// scheduled from.
  std::int64_t zero_cross_sample() const { return zero_cross_sample_; }
  /// Standard uncertainty of the mains phase at the closing angle, as it was known when the edge was to be committed,
  /// turns.
  float angle_deviation() const { return angle_deviation_; }

 private:
  Refusal refuse(Refusal, std::string_view why);
  Refusal refuse_unless_rested();
  std::string_view unrested() const;
  Refusal refuse_set_point(bool in_range, std::string_view range);
  void trip(Fault, std::int64_t next_sample);
  void feed_mains(const Block&);
  Fault examine(const Block&, std::int64_t end);
  const Interlocks::GateView& gate_view(std::int64_t now);
  void schedule(const Block&);
  void wait_for_phase(std::int64_t end);
  float target_deviation() const;
  bool angle_known() const {
    return PhaseEstimate::coverage_factor * angle_deviation_ <=
           static_cast<float>(tolerance_millideg_) / 360000.0F;
  }
  void plan_edge(const Block&, std::int64_t now);
  void commit(std::int64_t now);
  void note_gate_change(std::span<const GateEdge>);
  std::int64_t lead_samples_256() const;
  std::int64_t hold_samples() const { return hold_time_ms_ * config_->sample_rate / 1000; }
  std::int64_t hold_limit() const { return config_->hold_limit_ms * config_->sample_rate / 1000; }

  // pointers, not references: the state can be copied out of and back into the same controller
  const FireConfig* config_;
  Interlocks* interlocks_;
  PhaseFeed* mains_;
  Recorder* recorder_;
  Gate gate_;
  DutyBudget budget_;
  BootReport boot_{};
  State state_ = State::idle;
  Fault fault_ = Fault::none;
  std::string_view last_error_ = "no error";
  std::string_view unready_{};
  CentiDegrees closing_angle_ = 0;
  std::int64_t hold_time_ms_ = 100;
  std::int64_t touch_delay_us_ = 0;
  std::int64_t tolerance_millideg_ = 1000;
  LatchedShot latched_{};
  std::uint32_t deadlines_missed_ = 0, operations_ = 0;
  bool token_ = false;           ///< armed and not yet fired
  bool fired_ = false;           ///< the token is spent, the edge not yet committed
  bool planned_ = false;         ///< a crossing has been chosen; only its instant is refined
  Interlocks::GateView view_{};  ///< gate and relay, as of the last block
  bool config_damaged_ = false;
  bool stored_lost_ = false;    ///< a calibration was stored, and cannot be read
  bool was_energised_ = false;  ///< the gate has been on since the start
  std::int64_t fired_at_ = 0;
  Tick plan_{};                      ///< gate edge as predicted by the latest estimate
  std::int64_t plan_basis_ = 0;      ///< sample of that estimate
  std::int64_t plan_target_ = 0;     ///< sample of the tracker at the planned instant of the closing angle
  std::int64_t next_sample_ = 0;     ///< first sample not yet seen
  std::int64_t tracker_origin_ = 0;  ///< sample index of the tracker's sample 0
  std::int64_t gate_since_ = 0;
  std::int64_t zero_cross_sample_ = 0;
  float angle_deviation_ = 0;
  bool first_block_ = true;
};

}  // namespace powbench::firmware
