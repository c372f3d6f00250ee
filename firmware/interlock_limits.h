#pragma once

#include <array>
#include <cstdint>

#include "core/channels.h"
#include "firmware/interlocks.h"

/// What the bench watches, in SI, and the one way from there to counts and samples. Every port and the simulated rig
/// take their thresholds from interlock_config(); a channel that exists is watched.

namespace powbench::firmware {

/// Error budget behind the defaults. Current: 6 mA are 10 % of the holding current of a small contactor's coil, and 90
/// counts of the board's 67 uA; zero drift after a capture stays below 1 mA, noise below 0.3 mA rms (20 standard
/// deviations). Contact: half of the 6 V of the open pole, so that a supply and a divider of 10 % each leave 2.4 V on
/// either side. Travel: an open contact touches between 2.5 and 2.9 mm in every specimen file; 0.5 mm and 3.2 mm
/// leave 2.0 mm and 0.3 mm.
struct InterlockLimits {
  double trip_ampere = 1.8;            ///< two samples beyond it trip
  double no_current_ampere = 0.006;    ///< below it no current flows
  double no_current_seconds = 0.0048;  ///< allowed without current while the gate is on
  double stuck_on_seconds = 0.025;     ///< allowed with current after the gate opened
  double mains_volts = 230.0;          ///< nominal, rms
  double mains_lost_share = 0.2;       ///< of the nominal peak: above it mains is there
  double mains_lost_seconds = 0.016;
  double heartbeat_seconds = 0.250;  ///< longest silence of the host while energised
  double contact_open_volts = 3.0;   ///< above it the pole is open
  double contact_open_seconds = 0.002;
  double weld_seconds = 0.100;  ///< allowed after the gate opened until the contact is open
  double laser_least_metres =
      -0.5e-3;  ///< readings outside of this range are no travel; from the sensor's own zero
  double laser_most_metres = 8.0e-3;
  double travel_open_metres = 0.5e-3;    ///< from rest: below it the contact must be open
  double travel_closed_metres = 3.2e-3;  ///< above it the contact must be closed
  double implausible_seconds = 0.005;
  double relay_seconds =
      0.100;  ///< the safety relay's time to follow: some 10 ms of pump and armature, and its bounce
};

/// One channel as the front end gives it: quantity = (counts - zero) * si_per_count. 0 counts a scale: there is no such
/// channel.
struct CountScale {
  double si_per_count = 0.0;
  std::int32_t zero = 0;
};
using CountScales = std::array<CountScale, channel_count>;

namespace detail {
constexpr std::int64_t nearest(double x) {
  return static_cast<std::int64_t>(x + (x < 0 ? -0.5 : 0.5));
}
}  // namespace detail

/// Thresholds in counts and samples. What does not fit into 16 bits, or a channel that a shot cannot do without, is
/// found by config_error().
constexpr InterlockConfig interlock_config(const InterlockLimits& limits, const CountScales& scales,
                                           double sample_rate) {
  const auto span = [&](Channel c, double si) {
    const double scale = scales[index(c)].si_per_count;
    return scale == 0.0 ? 0 : static_cast<std::int32_t>(detail::nearest(si / scale));
  };
  const auto level = [&](Channel c, double si) {
    return scales[index(c)].si_per_count == 0.0 ? 0 : scales[index(c)].zero + span(c, si);
  };
  const auto samples = [&](double seconds) { return detail::nearest(seconds * sample_rate); };
  constexpr double root_2 = 1.41421356237309505;
  InterlockConfig c;
  c.overcurrent_counts = span(Channel::coil_current, limits.trip_ampere);
  c.no_current_counts = span(Channel::coil_current, limits.no_current_ampere);
  c.current_zero_counts = scales[index(Channel::coil_current)].zero;
  c.no_current_samples = samples(limits.no_current_seconds);
  c.stuck_on_samples = samples(limits.stuck_on_seconds);
  c.mains_lost_counts = span(Channel::mains_voltage, limits.mains_lost_share * limits.mains_volts * root_2);
  c.mains_lost_samples = samples(limits.mains_lost_seconds);
  c.heartbeat_samples = samples(limits.heartbeat_seconds);
  c.contact_open_counts = level(Channel::contact_a, limits.contact_open_volts);
  c.contact_open_samples = samples(limits.contact_open_seconds);
  c.weld_samples = samples(limits.weld_seconds);
  // the sensor's range does not move with the zero of the travel
  c.travel_least_counts = span(Channel::laser, limits.laser_least_metres);
  c.travel_most_counts = span(Channel::laser, limits.laser_most_metres);
  c.travel_open_counts = level(Channel::laser, limits.travel_open_metres);
  c.travel_closed_counts = level(Channel::laser, limits.travel_closed_metres);
  c.implausible_samples = samples(limits.implausible_seconds);
  c.relay_samples = samples(limits.relay_seconds);
  return c;
}

}  // namespace powbench::firmware
