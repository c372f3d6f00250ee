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

Refusal FireControl::refuse(const Obstacle& o) {
  if (o.refusal != Refusal::accepted) last_error_ = o.why;
  return o.refusal;
}

/// Is the last shot over, and may there be another one?
Obstacle FireControl::unrested() const {
  const auto wait = [](std::string_view why) { return Obstacle{Refusal::wrong_state, why}; };
  if (!gate_.idle()) return wait("cannot arm while the gate is on");
  if (settling() || !interlocks_->contact_open(next_sample_))
    return wait("cannot arm before current has ended and the contact is proven open");
  switch (
      budget_.judge(config_->budget, next_sample_, gate_since_, hold_samples(), 60 * config_->sample_rate)) {
    case DutyBudget::Verdict::ready:
      return {};
    case DutyBudget::Verdict::pause:
      return wait("too soon after the last shot: wait for the pause between shots");
    case DutyBudget::Verdict::too_many:
      return wait("too many shots within a minute: wait");
    case DutyBudget::Verdict::too_hot:
      break;
  }
  return wait("coil energised for too long: let it cool, or ask for less hold time");
}

Obstacle FireControl::obstacle() const {
  if (state_ == State::fault) return {Refusal::faulted, reason(fault_)};
  if (!boot_.unfit.empty()) return {Refusal::faulted, boot_.unfit};
  if (!unready_.empty()) return {Refusal::wrong_state, unready_};
  if (state_ == State::firing)
    return {Refusal::wrong_state, "cannot arm while firing: wait for captured, or abort"};
  if (const Obstacle tired = unrested(); tired.refusal != Refusal::accepted) return tired;
  if (interlocks_->emergency_stop())
    return {Refusal::wrong_state, "emergency stop is open: close it before arming"};
  return {};
}

Refusal FireControl::arm() {
  if (const Refusal no = refuse(obstacle()); no != Refusal::accepted) return no;
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
    return refuse({Refusal::wrong_state, "cannot disarm while firing: write 1 to abort"});
  if (state_ != State::armed) return Refusal::accepted;
  recorder_->discard();
  token_ = false;
  state_ = State::idle;
  return Refusal::accepted;
}

Refusal FireControl::fire() {
  if (state_ == State::fault) return refuse({Refusal::faulted, reason(fault_)});
  if (state_ != State::armed || !token_)
    return refuse({Refusal::wrong_state, "not armed: write 1 to arm before firing"});
  if (const Refusal tired = refuse(unrested()); tired != Refusal::accepted) return tired;
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

Refusal FireControl::refuse_latched() {
  if (!set_points_latched()) return Refusal::accepted;
  return refuse(
      {Refusal::wrong_state, "set-points are latched from arm until the shot is over: disarm first"});
}

Refusal FireControl::set_closing_angle(std::int64_t centi_degrees) {
  if (centi_degrees < 0 || centi_degrees >= full_turn_centi)
    return refuse({Refusal::out_of_range, "closing angle outside 0 .. 35999 hundredths of a degree"});
  if (const Refusal latched = refuse_latched(); latched != Refusal::accepted) return latched;
  closing_angle_ = static_cast<CentiDegrees>(centi_degrees);
  return Refusal::accepted;
}

Refusal FireControl::set_hold_time_ms(std::int64_t ms) {
  if (ms < 1 || ms > config_->hold_limit_ms)
    return refuse({Refusal::out_of_range, "hold time outside 1 .. 10000 ms"});
  if (const Refusal latched = refuse_latched(); latched != Refusal::accepted) return latched;
  hold_time_ms_ = ms;
  return Refusal::accepted;
}

Refusal FireControl::set_touch_delay_us(std::int64_t us) {
  if (us < 0 || us > longest_touch_delay_us)
    return refuse({Refusal::out_of_range, "touch delay outside 0 .. 50000 us"});
  if (const Refusal latched = refuse_latched(); latched != Refusal::accepted) return latched;
  touch_delay_us_ = us;
  return Refusal::accepted;
}

Refusal FireControl::set_angle_tolerance(std::int64_t millidegrees) {
  if (millidegrees < least_tolerance_millideg || millidegrees > most_tolerance_millideg)
    return refuse({Refusal::out_of_range, "angle tolerance outside 10 .. 90000 thousandths of a degree"});
  if (const Refusal latched = refuse_latched(); latched != Refusal::accepted) return latched;
  tolerance_millideg_ = millidegrees;
  return Refusal::accepted;
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
