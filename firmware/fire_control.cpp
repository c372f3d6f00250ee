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

FireControl::FireControl(const FireConfig& config, Interlocks& interlocks, PhaseTracker& tracker,
                         Recorder& recorder)
    : config_(config), interlocks_(interlocks), tracker_(tracker), recorder_(recorder) {}

Refusal FireControl::refuse(Refusal why, std::string_view text) {
  last_error_ = text;
  return why;
}

Refusal FireControl::arm() {
  if (state_ == State::fault) return refuse(Refusal::faulted, reason(fault_));
  if (state_ == State::firing)
    return refuse(Refusal::wrong_state, "cannot arm while firing: wait for captured, or abort");
  if (!gate_.idle()) return refuse(Refusal::wrong_state, "cannot arm while the gate is on");
  // everything a shot depends on starts from a known state, so that equal shots give equal records
  tracker_.reset();
  tracker_origin_ = next_sample_;
  interlocks_.reset(next_sample_);
  recorder_.arm();
  token_ = true;
  fired_ = planned_ = false;
  state_ = State::armed;
  last_error_ = "no error";
  ++shots_armed_;
  return Refusal::accepted;
}

Refusal FireControl::disarm() {
  if (state_ == State::firing)
    return refuse(Refusal::wrong_state, "cannot disarm while firing: write 1 to abort");
  if (state_ != State::armed) return Refusal::accepted;
  recorder_.discard();
  token_ = false;
  state_ = State::idle;
  return Refusal::accepted;
}

Refusal FireControl::fire() {
  if (state_ == State::fault) return refuse(Refusal::faulted, reason(fault_));
  if (state_ != State::armed || !token_)
    return refuse(Refusal::wrong_state, "not armed: write 1 to arm before firing");
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
  if (state_ != State::captured) recorder_.discard();
  if (state_ == State::fault && fault_ == Fault::coil_stuck_on && !interlocks_.coil_quiet(next_sample_))
    return;
  state_ = State::idle;
  fault_ = Fault::none;
  last_error_ = "no error";
}

Refusal FireControl::set_closing_angle(std::int64_t centi_degrees) {
  if (centi_degrees < 0 || centi_degrees >= full_turn_centi)
    return refuse(Refusal::out_of_range, "closing angle outside 0 .. 35999 hundredths of a degree");
  if (state_ == State::firing)
    return refuse(Refusal::wrong_state, "closing angle cannot change while firing");
  closing_angle_ = static_cast<CentiDegrees>(centi_degrees);
  return Refusal::accepted;
}

Refusal FireControl::set_hold_time_ms(std::int64_t ms) {
  if (ms < 1 || ms > config_.hold_limit_ms)
    return refuse(Refusal::out_of_range, "hold time outside 1 .. 10000 ms");
  if (state_ == State::firing) return refuse(Refusal::wrong_state, "hold time cannot change while firing");
  hold_time_ms_ = ms;
  return Refusal::accepted;
}

void FireControl::trip(Fault fault, std::int64_t next_sample) {
  gate_.force_off(next_sample);
  token_ = fired_ = planned_ = false;
  recorder_.discard();
  state_ = State::fault;
  fault_ = fault;
  last_error_ = reason(fault);
}

std::span<const GateEdge> FireControl::step(const Block& block) {
  const std::int64_t end = block.first_sample + block.samples();
  if (next_sample_ > 0 && block.first_sample > next_sample_)
    tracker_.mark_gap(block.first_sample - next_sample_);
  next_sample_ = end;
  for (std::int64_t i = 0; i < block.samples(); ++i) tracker_.push(block.at(i, Channel::mains_voltage));
  recorder_.push(block);

  const Fault found = interlocks_.check(block, gate_.on(), gate_since_);
  const bool in_shot = state_ == State::armed || state_ == State::firing;
  if (found != Fault::none && (in_shot || found == Fault::coil_stuck_on) && state_ != State::fault)
    trip(found, end);

  if (state_ == State::firing && fired_) schedule(block);
  if (state_ == State::firing && !fired_ && gate_.idle() && recorder_.complete() &&
      interlocks_.coil_quiet(end) && end - gate_since_ > config_.quiet_samples)
    state_ = State::captured;

  const auto edges = gate_.edges_before(end + config_.lead_samples + block.samples());
  note_gate_change(edges);
  return edges;
}

/// Chooses the crossing once, refines its instant with every estimate, and commits the edge one block ahead
/// of it.
void FireControl::schedule(const Block& block) {
  const std::int64_t end = block.first_sample + block.samples();
  const std::int64_t soonest = end + config_.lead_samples;  // first sample at which an edge can still be made
  const PhaseEstimate& estimate = tracker_.estimate();
  if (!estimate.valid()) {
    planned_ = false;
    if (end - fired_at_ > config_.phase_timeout_samples) trip(Fault::phase_invalid, end);
    return;
  }
  const auto quarter =
      static_cast<std::int64_t>(0.25F * static_cast<float>(config_.sample_rate) / estimate.frequency);
  // the prediction is for the coil voltage: the gate has to be earlier by its own delay
  const std::int64_t delay_whole = config_.gate_delay_samples_256 / 256;
  std::int64_t earliest = soonest + 2 * block.samples() + delay_whole;
  if (planned_) earliest = plan_.sample + delay_whole - quarter;
  if (earliest < end) earliest = end;
  const auto instant = tracker_.next_instant(closing_angle_, earliest - tracker_origin_);
  const std::int64_t sub =
      static_cast<std::int64_t>(instant.fraction * 65536.0F) - (config_.gate_delay_samples_256 % 256) * 256;
  plan_.sample = instant.sample + tracker_origin_ - delay_whole + (sub < 0 ? -1 : 0);
  plan_.fraction = static_cast<std::uint16_t>(sub < 0 ? sub + 65536 : sub);
  planned_ = true;
  if (plan_.sample < soonest) {  // deadline missed: the next crossing, never a late edge
    planned_ = false;
    return;
  }
  if (plan_.sample >= soonest + block.samples()) return;

  const Gate::Permit permit{.armed_and_fired = fired_,
                            .phase_valid = estimate.valid(),
                            .no_fault = fault_ == Fault::none,
                            .hold_samples = hold_time_ms_ * config_.sample_rate / 1000,
                            .hold_limit = config_.hold_limit_ms * config_.sample_rate / 1000};
  fired_ = false;
  planned_ = false;
  if (!gate_.energise(permit, plan_)) return trip(Fault::phase_invalid, end);
  recorder_.trigger(plan_);
  const float back = static_cast<float>(closing_angle_) / 36000.0F * static_cast<float>(config_.sample_rate) /
                     estimate.frequency;
  zero_cross_sample_ = plan_.sample - static_cast<std::int64_t>(back + 0.5F);
}

void FireControl::note_gate_change(std::span<const GateEdge> edges) {
  for (const GateEdge& edge : edges) gate_since_ = edge.at.sample;
}

}  // namespace powbench::firmware
