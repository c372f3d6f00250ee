#include "firmware/controller.h"

namespace powbench::firmware {

/// What a capture means for current checks and for arming; a calibration on its way to the memory keeps the bench at
/// rest.
void Controller::announce() {
  using Zero = ZeroCapture::State;
  const Zero state = zero_.state();
  interlocks_.current_known(state == Zero::unwanted || state == Zero::done);
  if (calibrations_.due()) return fire_.set_unready("a calibration is being stored: wait 0.1 s");
  switch (state) {
    case Zero::unwanted:
    case Zero::done:
      return fire_.set_unready({});
    case Zero::capturing:
      return fire_.set_unready("the zero of the coil's current is being captured: wait 0.1 s");
    case Zero::flowing:
      return fire_.set_unready(
          "coil current with gate and relay open: check the switch, then capture the zero");
    case Zero::far:
      return fire_.set_unready(
          "offset of coil current or voltage too large: check the sensor, then capture the zero");
  }
}

/// In the background: the configuration changes one word at a time, so that the level above may read it between any
/// two.
void Controller::end_zero_capture() {
  store_shared(zero_ended_, false);
  if (zero_.state() == ZeroCapture::State::done) {
    config_.calibration[index(Channel::coil_current)].zero_counts = zero_.current();
    config_.calibration[index(Channel::coil_voltage)].zero_counts = zero_.voltage();
    config_.interlocks.current_zero_counts = zero_.current();
    guard_ = ConfigGuard({reinterpret_cast<const std::uint8_t*>(&config_), sizeof config_});
  }
  announce();
  if (zero_.state() == ZeroCapture::State::flowing) fire_.current_at_rest();
}

bool Controller::at_rest() const {
  return fire_.state() != State::armed && fire_.state() != State::firing && fire_.at_rest();
}

Refusal Controller::capture_zero() {
  if (config_.zero.samples <= 0) return Refusal::accepted;
  if (!at_rest()) return Refusal::wrong_state;
  fire_.forget_record();
  zero_.begin(config_.zero);
  zero_ended_ = false;
  announce();
  return Refusal::accepted;
}

std::string_view interlock_error(const InterlockConfig& i, const Calibrations& rows) {
  if (i.no_current_counts <= 0 || i.overcurrent_counts <= i.no_current_counts ||
      i.overcurrent_counts > 32'767)
    return "current thresholds not in the order 0 < no_current < overcurrent <= 32767";
  if (i.mains_lost_counts <= 0 || i.mains_lost_samples <= 0) return "mains_lost thresholds not above 0";
  if (i.no_current_samples <= 0 || i.stuck_on_samples <= 0) return "coil time limits not above 0";
  if (i.heartbeat_samples <= 0) return "heartbeat_samples not above 0";
  // a channel that exists is watched
  const bool contact = rows[index(Channel::contact_a)].scale_pico != 0;
  const bool laser = rows[index(Channel::laser)].scale_pico != 0;
  if (contact && (i.contact_open_counts <= 0 || i.contact_open_counts > 32'767))
    return "there is a contact channel, but contact_open_counts is outside 1 .. 32767";
  if (laser && (i.travel_least_counts >= i.travel_most_counts || i.travel_most_counts > 32'767))
    return "there is a laser, but its range is not least < most <= 32767";
  if (contact && laser &&
      (i.travel_open_counts >= i.travel_closed_counts || i.travel_closed_counts >= i.travel_most_counts))
    return "there are contact and laser, but travel thresholds are not open < closed < most";
  return {};
}

std::string_view config_error(const ControllerConfig& c, std::size_t storage_values) {
  const InterlockConfig& i = c.interlocks;
  const BudgetConfig& b = c.fire.budget;
  if (c.sample_rate < 20'000 || c.sample_rate > 1'000'000) return "sample_rate outside 20000 .. 1000000 Hz";
  if (c.fire.sample_rate != c.sample_rate || c.phase.sample_rate != static_cast<float>(c.sample_rate))
    return "sample rates of fire control and phase tracker differ from the converter's";
  if (c.record_length <= 0 || c.pretrigger < 0 || c.pretrigger > c.record_length)
    return "pretrigger outside 0 .. record_length";
  if (storage_values / channel_count < static_cast<std::size_t>(c.record_length))
    return "record_length does not fit into the memory";
  if (!(c.phase.nominal_amplitude > 0.0F && c.phase.nominal_amplitude < 32768.0F))
    return "nominal_amplitude outside 0 .. 32767 counts";
  if (c.fire.hold_limit_ms < 1 || c.fire.hold_limit_ms > 10'000) return "hold_limit_ms outside 1 .. 10000";
  if (c.fire.gate_delay_samples_256 < 0) return "gate delay below 0";
  if (const std::string_view why = interlock_error(i, c.calibration); !why.empty()) return why;
  if (c.zero.samples < 0 || (c.zero.samples > 0 && (c.zero.most_counts <= 0 || c.zero.quiet_counts <= 0)))
    return "zero capture without limits";
  if (b.operations_per_minute < 0 ||
      b.operations_per_minute > static_cast<std::int64_t>(DutyBudget::most_operations))
    return "operations_per_minute outside 0 .. 64";
  if (b.pause_samples < 0 || b.heat_samples < 0 || b.duty_per_mille < 0 || b.duty_per_mille > 1000)
    return "budget outside its range";
  return {};
}

}  // namespace powbench::firmware
