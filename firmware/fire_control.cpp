#include "firmware/fire_control.h"

namespace powbench::firmware {

std::string_view name(State state) {
  switch (state) {
    case State::idle:
      return "idle";
    case State::armed:
      return "armed";
    case State::firing:
      return "firing";
    case State::captured:
      return "captured";
    case State::fault:
      return "fault";
  }
  return "fault";
}

FireControl::FireControl(const FireConfig& config, Interlocks& interlocks, PhaseFeed& mains,
                         Recorder& recorder)
    : config_(&config), interlocks_(&interlocks), mains_(&mains), recorder_(&recorder) {}

void FireControl::boot(const BootReport& report) {
  boot_ = report;
  const Survivor* kept = report.survivor;
  const bool powered = report.cause == ResetCause::power_on;  // then that memory holds nothing of ours
  if (kept && !powered && kept->has_crash())
    trip(Fault::crash_reset, next_sample_);
  else if (report.cause == ResetCause::watchdog)
    trip(Fault::watchdog_reset, next_sample_);
  else if (kept && !powered && kept->gate_was_on())
    trip(Fault::reset_while_energised, next_sample_);
  else if (report.cause == ResetCause::brown_out)
    trip(Fault::brown_out, next_sample_);
  else if (!report.stored_config_intact)
    trip(Fault::config_corrupt, next_sample_);
  stored_lost_ = !report.stored_config_intact;
  if (boot_.survivor) boot_.survivor->note_gate(false);
}

Refusal FireControl::refuse(Refusal how, std::string_view why) {
  last_error_ = why;
  return how;
}

/// Is the last shot over, and may there be another one? Empty, or why not.
std::string_view FireControl::unrested() const {
  if (!gate_.idle()) return "cannot arm while the gate is on";
  if (settling() || !interlocks_->contact_open(next_sample_))
    return "cannot arm before current has ended and the contact is proven open";
  switch (
      budget_.judge(config_->budget, next_sample_, gate_since_, hold_samples(), 60 * config_->sample_rate)) {
    case DutyBudget::Verdict::ready:
      return {};
    case DutyBudget::Verdict::pause:
      return "too soon after the last shot: wait";
    case DutyBudget::Verdict::too_many:
      return "too many shots a minute: wait";
    case DutyBudget::Verdict::too_hot:
      break;
  }
  return "coil energised too long: let it cool";
}

Refusal FireControl::refuse_unless_rested() {
  const std::string_view why = unrested();
  return why.empty() ? Refusal::accepted : refuse(Refusal::wrong_state, why);
}

std::string_view FireControl::obstacle() const {
  if (state_ == State::fault) return reason(fault_);
  if (!boot_.unfit.empty()) return boot_.unfit;
  if (!unready_.empty()) return unready_;
  if (state_ == State::firing) return "cannot arm while firing: wait, or abort";
  if (const std::string_view why = unrested(); !why.empty()) return why;
  return interlocks_->emergency_stop() ? "emergency stop is open: close it first" : std::string_view();
}

Refusal FireControl::arm() {
  if (const std::string_view why = obstacle(); !why.empty())
    return refuse(state_ == State::fault || !boot_.unfit.empty() ? Refusal::faulted : Refusal::wrong_state,
                  why);
  // everything a shot depends on starts from a known state, so that equal shots give equal records
  mains_->reset();
  tracker_origin_ = next_sample_;
  interlocks_->reset(next_sample_);
  recorder_->arm();
  token_ = true;
  fired_ = planned_ = false;
  state_ = State::armed;
  last_error_ = "no error";
  latched_ = {latched_.number + 1, closing_angle_, hold_time_ms_, touch_delay_us_, tolerance_millideg_};
  return Refusal::accepted;
}

Refusal FireControl::disarm() {
  if (state_ == State::firing)
    return refuse(Refusal::wrong_state, "cannot disarm while firing: write 1 to abort");
  if (state_ != State::armed) return Refusal::accepted;
  recorder_->discard();
  token_ = false;
  state_ = State::idle;
  return Refusal::accepted;
}

Refusal FireControl::fire() {
  if (state_ == State::fault) return refuse(Refusal::faulted, reason(fault_));
  if (state_ != State::armed || !token_)
    return refuse(Refusal::wrong_state, "not armed: write 1 to arm before firing");
  if (const Refusal tired = refuse_unless_rested(); tired != Refusal::accepted) return tired;
  token_ = false;
  fired_ = true;
  planned_ = false;
  fired_at_ = next_sample_;
  state_ = State::firing;
  return Refusal::accepted;
}

void FireControl::abort() {
  gate_.force_off(next_sample_);
  token_ = fired_ = planned_ = false;
  if (state_ != State::captured) recorder_->discard();
  if (state_ == State::fault) {
    const bool damaged = fault_ == Fault::config_corrupt && (config_damaged_ || stored_lost_);
    if (damaged || (info(fault_).clears == Clears::cause_gone && interlocks_->present(fault_))) {
      last_error_ = reason(fault_);
      return;
    }
    if (boot_.survivor) boot_.survivor->forget();
  }
  state_ = State::idle;
  fault_ = Fault::none;
  last_error_ = "no error";
}

void FireControl::stop() {
  if (state_ != State::armed && state_ != State::firing) return;
  gate_.force_off(next_sample_);
  token_ = fired_ = planned_ = false;
  recorder_->discard();
  state_ = State::idle;
  last_error_ = "stopped by a client that is not the owner";
}

void FireControl::owner_gone() {
  if (state_ == State::armed || (state_ == State::firing && fired_)) {
    token_ = fired_ = planned_ = false;
    recorder_->discard();
    state_ = State::idle;
    last_error_ = "the owner's lease has ended: disarmed";
  } else if (state_ == State::firing && !gate_.idle()) {
    trip(Fault::host_lost, next_sample_);
  }
}

/// Of a value to be set: outside its range, or at the wrong time.
Refusal FireControl::refuse_set_point(bool in_range, std::string_view range) {
  if (!in_range) return refuse(Refusal::out_of_range, range);
  if (!set_points_latched()) return Refusal::accepted;
  return refuse(Refusal::wrong_state, "set-points are latched from arm to the end of the shot: disarm");
}

Refusal FireControl::set_closing_angle(std::int64_t centi_degrees) {
  const Refusal no = refuse_set_point(centi_degrees >= 0 && centi_degrees < full_turn_centi,
                                      "closing angle outside 0 .. 35999 (0.01 deg)");
  if (no == Refusal::accepted) closing_angle_ = static_cast<CentiDegrees>(centi_degrees);
  return no;
}

Refusal FireControl::set_hold_time_ms(std::int64_t ms) {
  const Refusal no =
      refuse_set_point(ms >= 1 && ms <= config_->hold_limit_ms, "hold time outside 1 .. 10000 ms");
  if (no == Refusal::accepted) hold_time_ms_ = ms;
  return no;
}

Refusal FireControl::set_touch_delay_us(std::int64_t us) {
  const Refusal no =
      refuse_set_point(us >= 0 && us <= longest_touch_delay_us, "touch delay outside 0 .. 50000 us");
  if (no == Refusal::accepted) touch_delay_us_ = us;
  return no;
}

Refusal FireControl::set_angle_tolerance(std::int64_t millidegrees) {
  const Refusal no =
      refuse_set_point(millidegrees >= least_tolerance_millideg && millidegrees <= most_tolerance_millideg,
                       "angle tolerance outside 10 .. 90000 (0.001 deg)");
  if (no == Refusal::accepted) tolerance_millideg_ = millidegrees;
  return no;
}

void FireControl::current_at_rest() {
  if (state_ != State::fault)
    trip(was_energised_ ? Fault::coil_stuck_on : Fault::reset_while_energised, next_sample_);
}

void FireControl::forget_record() {
  recorder_->discard();
  if (state_ == State::captured) state_ = State::idle;
}

void FireControl::config_damaged(bool damaged) {
  config_damaged_ = damaged;
  if (damaged && state_ != State::fault) trip(Fault::config_corrupt, next_sample_);
}

void FireControl::trip(Fault fault, std::int64_t next_sample) {
  gate_.force_off(next_sample);
  token_ = fired_ = planned_ = false;
  if (state_ != State::captured) recorder_->discard();
  state_ = State::fault;
  fault_ = fault;
  last_error_ = reason(fault);
}

bool FireControl::settling() const {
  const bool over = interlocks_->coil_quiet(next_sample_) && interlocks_->contact_open(next_sample_);
  return was_energised_ && !over && gate_.idle() && !interlocks_->waited_enough(next_sample_ - gate_since_);
}

}  // namespace powbench::firmware
