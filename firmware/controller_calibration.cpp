#include <new>

#include "firmware/controller.h"

/// How a stored calibration becomes the configuration.

namespace powbench::firmware {

namespace {

constexpr std::int64_t longest_delay_ns = 1'000'000;

/// round(a b / c), c > 0; the product fits into 63 bits (calibration_error() sees to it).
[[gnu::noinline]] std::int64_t ratio(std::int64_t a, std::int64_t b, std::int64_t c) {
  const std::int64_t product = a * b;
  return (product + (product < 0 ? -c / 2 : c / 2)) / c;
}

/// Thresholds in counts of one channel: as far from its zero as before, in SI.
struct Rescale {
  const ChannelCalibration& from;
  const ChannelCalibration& to;

  [[gnu::noinline]] std::int32_t span(std::int32_t counts) const {
    return from.scale_pico == 0 ? counts
                                : static_cast<std::int32_t>(ratio(counts, from.scale_pico, to.scale_pico));
  }
  /// 0: not watched.
  std::int32_t level(std::int32_t counts) const {
    if (counts == 0 || from.scale_pico == 0) return counts;
    return static_cast<std::int32_t>(to.zero_counts) +
           span(counts - static_cast<std::int32_t>(from.zero_counts));
  }
};

/// By how much the edge comes earlier than with the nominal front end, 1/256 sample: mains is shown later, the switch
/// is slow.
std::int64_t edge_advance(const ControllerConfig& nominal, const StoredCalibration& stored) {
  const std::size_t mains = index(Channel::mains_voltage);
  return ratio(stored.rows[mains].delay_ns - nominal.calibration[mains].delay_ns + stored.switch_delay_ns,
               nominal.sample_rate * 256, 1'000'000'000);
}

}  // namespace

InterlockConfig calibrated(const InterlockConfig& nominal, const Calibrations& from, const Calibrations& to) {
  const auto by = [&](Channel channel) { return Rescale{from[index(channel)], to[index(channel)]}; };
  const Rescale current = by(Channel::coil_current), mains = by(Channel::mains_voltage);
  const Rescale contact = by(Channel::contact_a), laser = by(Channel::laser);
  InterlockConfig i = nominal;
  i.overcurrent_counts = current.span(i.overcurrent_counts);
  i.no_current_counts = current.span(i.no_current_counts);
  i.current_zero_counts = static_cast<std::int32_t>(current.to.zero_counts);
  i.mains_lost_counts = mains.span(i.mains_lost_counts);
  i.contact_open_counts = contact.level(i.contact_open_counts);
  i.travel_least_counts = laser.span(i.travel_least_counts);
  i.travel_most_counts = laser.span(i.travel_most_counts);
  i.travel_open_counts = laser.level(i.travel_open_counts);
  i.travel_closed_counts = laser.level(i.travel_closed_counts);
  return i;
}

std::string_view calibration_error(const ControllerConfig& nominal, const StoredCalibration& stored) {
  for (std::size_t n = 0; n < channel_count; ++n) {
    const ChannelCalibration &was = nominal.calibration[n], &is = stored.rows[n];
    if ((was.scale_pico == 0) != (is.scale_pico == 0))
      return "the calibration has other channels than the bench";
    // films and lasers are exchanged; the electrical inputs are resistors and converters
    const bool sensor = channel_table[n].unit == "N" || channel_table[n].unit == "m";
    const std::int64_t percent = sensor ? 50 : 10;
    if (is.scale_pico < 0 || is.scale_pico > 2 * was.scale_pico) return "a gain is below 0 or doubled";
    if (is.scale_pico * 100 < was.scale_pico * (100 - percent) ||
        is.scale_pico * 100 > was.scale_pico * (100 + percent))
      return sensor ? "a gain is more than 50 % off" : "a gain is more than 10 % off: check the front end";
    if (is.zero_counts < -3000 || is.zero_counts > 3000)
      return "a zero is beyond 3000 counts: check the front end";
    if (is.delay_ns < -longest_delay_ns || is.delay_ns > longest_delay_ns) return "a delay is beyond 1 ms";
    if (is.corner_microhertz < 0 || is.corner_microhertz > 100'000'000)
      return "a low corner is outside 0 .. 100 Hz";
    if (channel_table[n].unit == "N" && is.scale_pico != 0 &&
        (is.film_area_pico <= 0 || is.film_area_pico > 10'000'000'000))
      return "a film's area is outside 0 .. 0.01 m2";
  }
  if (stored.switch_delay_ns < 0 || stored.switch_delay_ns > 10 * longest_delay_ns)
    return "the switch's delay is outside 0 .. 10 ms";
  if (nominal.fire.gate_delay_samples_256 + edge_advance(nominal, stored) < 0)
    return "the delay of the mains channel is too short";
  return interlock_error(calibrated(nominal.interlocks, nominal.calibration, stored.rows), stored.rows);
}

/// What is in force from now on; the level above is held off, or has not begun.
void Controller::apply(const StoredCalibration& stored) {
  const std::int64_t current_zero = config_.calibration[index(Channel::coil_current)].zero_counts;
  const std::int64_t voltage_zero = config_.calibration[index(Channel::coil_voltage)].zero_counts;
  const Rescale mains{nominal_.calibration[index(Channel::mains_voltage)],
                      stored.rows[index(Channel::mains_voltage)]};
  const Rescale current{nominal_.calibration[index(Channel::coil_current)],
                        stored.rows[index(Channel::coil_current)]};
  certificate_ = stored.certificate;
  config_.calibration_id = certificate_.name();
  config_.calibration = stored.rows;
  config_.interlocks = calibrated(nominal_.interlocks, nominal_.calibration, stored.rows);
  config_.zero.quiet_counts = current.span(nominal_.zero.quiet_counts);
  config_.fire.gate_delay_samples_256 = nominal_.fire.gate_delay_samples_256 + edge_advance(nominal_, stored);
  config_.phase.nominal_amplitude = nominal_.phase.nominal_amplitude;
  if (mains.from.scale_pico != 0)
    config_.phase.nominal_amplitude *=
        static_cast<float>(mains.from.scale_pico) / static_cast<float>(mains.to.scale_pico);
  if (config_.zero.samples > 0) {  // captured at every start: newer than any certificate
    config_.calibration[index(Channel::coil_current)].zero_counts = current_zero;
    config_.calibration[index(Channel::coil_voltage)].zero_counts = voltage_zero;
    config_.interlocks.current_zero_counts = static_cast<std::int32_t>(current_zero);
  }
  mains_.~PhaseFeed();
  new (&mains_) PhaseFeed(config_.phase);
  guard_ = ConfigGuard({reinterpret_cast<const std::uint8_t*>(&config_), sizeof config_});
  guard_verdict_ = no_verdict;
}

void Controller::use_memory(CalibrationMemory& memory) {
  calibrations_.open(memory);
  if (calibrations_.number() == 0) return;
  if (calibration_error(nominal_, calibrations_.draft()).empty())
    apply(calibrations_.draft());
  else
    calibrations_.reject();
}

Refusal Controller::draft(std::size_t channel, const ChannelCalibration& row) {
  if (!at_rest() || calibrations_.due()) return Refusal::wrong_state;
  calibrations_.draft().rows[channel] = row;
  return Refusal::accepted;
}

Refusal Controller::propose(const Certificate& certificate, std::int64_t switch_delay_ns) {
  StoredCalibration& draft = calibrations_.draft();
  if (!at_rest() || calibrations_.due()) return Refusal::wrong_state;
  draft.certificate = certificate;
  draft.switch_delay_ns = switch_delay_ns;
  const std::string_view why = calibration_error(nominal_, draft);
  if (!why.empty()) {
    fire_.note_refusal(why);
    return Refusal::out_of_range;
  }
  if (!calibrations_.submit()) return Refusal::wrong_state;
  announce();
  return Refusal::accepted;
}

void Controller::take_calibration(bool saved) {
  if (saved) {
    apply(calibrations_.draft());
    fire_.forget_record();
    fire_.stored_config_lost(false);
  }
  announce();
}

}  // namespace powbench::firmware
