#include "firmware/fire_control.h"

/// The part of fire control that runs once a block.

namespace powbench::firmware {

std::span<const GateEdge> FireControl::step(const Block& block) {
  const std::int64_t end = block.first_sample + block.samples();
  if (first_block_) gate_since_ = next_sample_ = block.first_sample;
  feed_mains(block);
  budget_.advance(config_->budget, end - next_sample_, gate_.on());
  next_sample_ = end;

  const Fault found = examine(block, end);
  if (found != Fault::none && state_ != State::fault) trip(found, end);
  recorder_->mark(interlocks_->marks(), end);
  recorder_->push(block);

  if (state_ == State::firing && fired_) schedule(block);
  if (state_ == State::firing && !fired_ && gate_.idle() && recorder_->complete() &&
      interlocks_->coil_quiet(end) && interlocks_->contact_open(end) &&
      end - gate_since_ > config_->quiet_samples)
    state_ = State::captured;

  first_block_ = false;
  const auto edges = gate_.edges_before(end + config_->lead_samples + block.samples());
  note_gate_change(edges);
  return edges;
}

void FireControl::feed_mains(const Block& block) {
  if (next_sample_ > 0 && block.first_sample > next_sample_)
    mains_->mark_gap(block.first_sample - next_sample_);
  mains_->push(block);
}

/// Gate and relay as the interlocks are to find them in the block that begins at `now`.
const Interlocks::GateView& FireControl::gate_view(std::int64_t now) {
  const bool relay = relay_closed();
  if (first_block_ || relay != view_.relay) view_.relay_since = now;
  view_.relay = relay;
  view_.on = gate_.on();
  view_.since = gate_since_;
  return view_;
}

/// The first thing wrong that counts in the present state.
Fault FireControl::examine(const Block& block, std::int64_t end) {
  const bool in_shot = state_ == State::armed || state_ == State::firing || gate_.on();
  const bool overdue = gate_.on() && gate_.off_at().sample < block.first_sample;
  Fault found = interlocks_->check(block, gate_view(block.first_sample));
  if (overdue) return Fault::on_time_exceeded;
  if (first_block_ && !interlocks_->coil_quiet(end)) return Fault::reset_while_energised;
  if (found == Fault::none && stored_lost_) return Fault::config_corrupt;
  // once the edge is committed, stopping makes nothing safer: the record tells the doubt
  const bool committed = state_ == State::firing && !fired_;
  if (found == Fault::sensor_implausible && committed) found = Fault::none;
  if (found == Fault::none && in_shot && !committed) {
    const std::int64_t age = end - (mains_->estimate().sample + tracker_origin_ + 1);
    if (age > config_->phase_age_samples) found = Fault::phase_stale;
  }
  if (found == Fault::none || in_shot || info(found).watch == Watch::always) return found;
  return Fault::none;
}

/// From the gate edge to what shall happen at the closing angle, 1/256 sample.
std::int64_t FireControl::lead_samples_256() const {
  return config_->gate_delay_samples_256 + touch_delay_us_ * config_->sample_rate * 256 / 1'000'000;
}

/// Chooses the crossing once, refines its instant with every estimate, and commits the edge one block ahead
/// of it.
void FireControl::schedule(const Block& block) {
  const std::int64_t end = block.first_sample + block.samples();
  if (mains_->estimate().faults != 0) return wait_for_phase(end);
  // valid all the time and still no edge: every crossing has been missed
  if (end - fired_at_ > 2 * config_->phase_timeout_samples) return trip(Fault::phase_stale, end);
  const std::int64_t now =
      end + block.late + config_->lead_samples;  // first sample at which an edge can still be made
  if (!planned_ || plan_basis_ != mains_->estimate().sample) plan_edge(block, now);
  if (plan_.sample < now) {  // deadline missed: the next crossing, never a late edge
    planned_ = false;
    ++deadlines_missed_;
    return;
  }
  if (plan_.sample >= end + config_->lead_samples + block.samples()) return;
  if (!interlocks_->switch_proven(end)) {  // not yet: the relay's own fault ends the waiting
    planned_ = false;
    return;
  }
  angle_deviation_ = target_deviation();
  if (!angle_known() || mains_->suspicious()) return wait_for_phase(end);
  commit(end);
}

/// No edge on a phase that is not known well enough where it matters: the next crossing, or the end of patience.
void FireControl::wait_for_phase(std::int64_t end) {
  planned_ = false;
  if (end - fired_at_ > config_->phase_timeout_samples) trip(Fault::phase_invalid, end);
}

/// Standard uncertainty of the phase at the planned instant of the closing angle, turns.
float FireControl::target_deviation() const {
  const PhaseEstimate& estimate = mains_->estimate();
  const std::int64_t distance = plan_target_ - estimate.sample;
  return estimate.deviation(static_cast<float>(static_cast<std::int32_t>(distance)) /
                            static_cast<float>(config_->sample_rate));
}

void FireControl::plan_edge(const Block& block, std::int64_t now) {
  const std::int64_t end = block.first_sample + block.samples();
  const PhaseEstimate& estimate = mains_->estimate();
  const auto quarter =
      static_cast<std::int32_t>(0.25F * static_cast<float>(config_->sample_rate) / estimate.frequency);
  // the prediction is for what the angle was asked for: the gate has to be earlier by the delays up to it
  const std::int64_t lead = lead_samples_256();
  const std::int64_t lead_whole = lead / 256;  // not negative: config_error() and the commands see to it
  std::int64_t earliest = now + 2 * block.samples() + lead_whole;
  if (planned_) earliest = plan_.sample + lead_whole - quarter;
  if (earliest < end) earliest = end;
  const auto instant = mains_->next_instant(closing_angle_, earliest - tracker_origin_);
  const auto lead_part = static_cast<std::int32_t>(lead % 256);
  const std::int32_t sub = static_cast<std::int32_t>(instant.fraction * 65536.0F) - lead_part * 256;
  plan_.sample = instant.sample + tracker_origin_ - lead_whole + (sub < 0 ? -1 : 0);
  plan_.fraction = static_cast<std::uint16_t>(sub < 0 ? sub + 65536 : sub);
  plan_basis_ = estimate.sample;
  plan_target_ = instant.sample;
  planned_ = true;
}

/// The one place from which the coil is energised.
void FireControl::commit(std::int64_t now) {
  const PhaseEstimate& estimate = mains_->estimate();
  const Gate::Permit permit{.armed_and_fired = fired_,
                            .phase_valid = estimate.faults == 0 && angle_known(),
                            .no_fault = fault_ == Fault::none,
                            .config_intact = !config_damaged_ && !stored_lost_,
                            .hold_samples = hold_samples(),
                            .hold_limit = hold_limit()};
  fired_ = false;
  planned_ = false;
  if (!gate_.energise(permit, plan_)) return trip(Fault::phase_invalid, now);
  budget_.note_operation(plan_.sample);
  ++operations_;
  recorder_->trigger(plan_);
  // phase of the mains at the gate edge, in samples behind the rising zero crossing
  const float cycle = static_cast<float>(config_->sample_rate) / estimate.frequency;
  float back = static_cast<float>(closing_angle_) / 36000.0F * cycle -
               static_cast<float>(touch_delay_us_) * 1e-6F * static_cast<float>(config_->sample_rate);
  while (back < 0.0F) back += cycle;
  zero_cross_sample_ = plan_.sample - static_cast<std::int32_t>(back + 0.5F);
}

void FireControl::note_gate_change(std::span<const GateEdge> edges) {
  for (const GateEdge& edge : edges) {
    gate_since_ = edge.at.sample;
    was_energised_ = was_energised_ || edge.on;
  }
  if (!edges.empty() && boot_.survivor) boot_.survivor->note_gate(edges.back().on);
}

}  // namespace powbench::firmware
