#pragma once

#include "core/units.h"
#include "firmware/controller.h"
#include "firmware/port/stm32g474/board.h"

/// What stands between the bench and the converters, and the controller's configuration that follows from it. All of it
/// is worked out by the compiler; the gains are those of docs/how-to/board.md, to be replaced by calibrated ones.

namespace powbench::firmware::stm32g474 {

inline constexpr double reference_volts = 3.3;  ///< VDDA
inline constexpr double pin_per_count =
    reference_volts / 65536;  ///< V, bipolar channel; a unipolar one has twice that

// charge amplifier: V = Q / Cf, low corner 1 / (2 pi Rf Cf)
inline constexpr double feedback_farad = 3.3e-9, feedback_ohm = 100e6;
inline constexpr double film_coulomb_per_newton = 21e-12, film_area = 25e-6;  // m2
// the others: volts at the pin per unit
inline constexpr double volts_per_ampere = 0.75;  ///< coil current, +-2 A
inline constexpr double volts_per_volt = 2.5e-3;  ///< coil and mains voltage, +-600 V
inline constexpr double volts_per_metre = 300.0;  ///< laser, 0 .. 10 mm as 0 .. 10 V through 10:3
inline constexpr double volts_per_contact = 0.3;  ///< contact-voltage, 0 .. 10 V
inline constexpr double volts_per_aux = 0.15;     ///< auxiliary input, +-10 V
inline constexpr double filter_delay = 7.5e-6;    ///< s: two-pole low-pass of 30 kHz, sqrt(2) / (2 pi f)
inline constexpr double laser_delay = 82e-6;      ///< s: transport delay of the sensor, a setting of its own

inline constexpr double cut_off_ampere = 1.9;  ///< comparators: at once, without the processor
inline constexpr double largest_offset = 0.1;  ///< V at the pin: more is no offset but a damaged sensor

/// The laser tells of its own range: 0.1 mm from either end it has lost its target.
inline constexpr InterlockLimits limits{.laser_least_metres = 0.1e-3, .laser_most_metres = 9.9e-3};

// what the coil may be asked for; a contactor's coil draws ten times its holding current until the core is closed
inline constexpr std::int64_t shots_a_minute = 20;  ///< 1200 an hour, the usual rating of an AC contactor
inline constexpr double pause_between_shots = 0.5;  ///< s, from the gate's off edge
inline constexpr double longest_energised = 30.0;   ///< s, from cold
inline constexpr double lasting_duty = 0.5;         ///< share of time energised that it stands for ever

constexpr std::int64_t nearest(double x) {
  return static_cast<std::int64_t>(x + (x < 0 ? -0.5 : 0.5));
}

/// Level of the 12-bit converter that stands for a coil current.
constexpr std::uint32_t comparator_level(double ampere) {
  return static_cast<std::uint32_t>(
      nearest((reference_volts / 2 + ampere * volts_per_ampere) / reference_volts * 4096));
}

/// `per_unit`: volts at the pin per IIO unit (kPa, m, mA, mV).
constexpr ChannelCalibration calibration(Channel channel, double per_unit, double delay) {
  const port::ChannelSource& source = channel_sources[index(channel)];
  const double count = pin_per_count * (source.bipolar ? 1 : 2);
  return {.scale_pico = nearest(count / per_unit * 1e12),
          .delay_ns = nearest((delay - burst_centre(source.converter, source.rank)) * 1e9)};
}

constexpr ChannelCalibration force_calibration(Channel channel) {
  const double volts_per_kilopascal = film_coulomb_per_newton / feedback_farad * film_area * 1e3;
  ChannelCalibration c = calibration(channel, volts_per_kilopascal, filter_delay);
  c.corner_microhertz = nearest(1e6 / (2 * pi * feedback_ohm * feedback_farad));
  c.film_area_pico = nearest(film_area * 1e12);
  c.sensitivity_femto = nearest(film_coulomb_per_newton * 1e15);
  return c;
}

constexpr ControllerConfig controller_config() {
  ControllerConfig c;
  c.sample_rate = sample_rate;
  c.record_length = record_length;
  c.pretrigger = pretrigger;
  c.calibration_id = "nominal";
  c.calibration[index(Channel::pvdf_a)] = force_calibration(Channel::pvdf_a);
  c.calibration[index(Channel::pvdf_b)] = force_calibration(Channel::pvdf_b);
  c.calibration[index(Channel::laser)] = calibration(Channel::laser, volts_per_metre, laser_delay);
  c.calibration[index(Channel::coil_current)] =
      calibration(Channel::coil_current, volts_per_ampere * 1e-3, filter_delay);
  c.calibration[index(Channel::coil_voltage)] =
      calibration(Channel::coil_voltage, volts_per_volt * 1e-3, filter_delay);
  c.calibration[index(Channel::mains_voltage)] =
      calibration(Channel::mains_voltage, volts_per_volt * 1e-3, filter_delay);
  c.calibration[index(Channel::contact_a)] =
      calibration(Channel::contact_a, volts_per_contact * 1e-3, filter_delay);
  c.calibration[index(Channel::aux)] = calibration(Channel::aux, volts_per_aux * 1e-3, filter_delay);

  constexpr double nominal_peak = 230.0 * 1.41421356237;
  const auto samples = [](double seconds) { return nearest(seconds * sample_rate); };
  c.phase.sample_rate = sample_rate;
  c.phase.nominal_amplitude = static_cast<float>(nominal_peak * volts_per_volt / pin_per_count);
  c.fire.sample_rate = sample_rate;
  c.fire.lead_samples = lead_samples;
  // filter and burst show the mains late, so that the edge would come late too: it is advanced by as much
  c.fire.gate_delay_samples_256 =
      nearest((filter_delay - burst_centre(channel_sources[index(Channel::mains_voltage)].converter,
                                           channel_sources[index(Channel::mains_voltage)].rank)) *
              sample_rate * 256);
  c.fire.phase_timeout_samples = samples(1.0);
  c.fire.quiet_samples = samples(0.005);
  c.fire.budget = {.operations_per_minute = shots_a_minute,
                   .pause_samples = samples(pause_between_shots),
                   .heat_samples = samples(longest_energised),
                   .duty_per_mille = nearest(1000 * lasting_duty)};
  c.limits = limits;
  c.interlocks = interlock_config(limits, count_scales(c.calibration), sample_rate);
  c.zero = {.samples = static_cast<std::int32_t>(samples(0.1)),
            .most_counts = static_cast<std::int32_t>(nearest(largest_offset / pin_per_count)),
            .quiet_counts = 2 * c.interlocks.no_current_counts};
  return c;
}

}  // namespace powbench::firmware::stm32g474
