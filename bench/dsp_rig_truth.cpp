#include "bench/dsp_rig_truth.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "rigs/simulated_record.h"

namespace powbench::bench {

namespace {

using Kind = sim::PlantEvent::Kind;

/// Closed intervals of one break before `t_end`.
std::vector<TrueContact> contacts_of(const std::vector<sim::PlantEvent>& events, Kind touch, Kind release,
                                     double t_end) {
  std::vector<TrueContact> out;
  for (const auto& e : events) {
    if (e.time > t_end) break;
    if (e.kind == touch)
      out.push_back({.touch = e.time});
    else if (e.kind == release && !out.empty())
      out.back().release = e.time;
  }
  return out;
}

std::vector<TrueContact> both(const std::vector<TrueContact>& a, const std::vector<TrueContact>& b) {
  std::vector<TrueContact> out;
  for (const TrueContact& x : a)
    for (const TrueContact& y : b) {
      const double from = std::max(x.touch, y.touch), to = std::min(x.release, y.release);
      if (to > from) out.push_back({from, to, 0.0});
    }
  return out;
}

/// What `simulate_record` leaves out: the sensors' noise, and hum on the films.
void add_noise(Record& r, const rigs::SensorConfig& s, double hertz, std::uint64_t seed) {
  Random random(seed * 104729 + 3);
  for (ChannelRecord& c : r.channels) {
    double noise = 0, hum = 0;
    switch (c.channel) {
      case Channel::pvdf_a:
        noise = s.force_noise, hum = s.force_hum;
        break;
      case Channel::pvdf_b:
        noise = s.force_noise, hum = 0.8 * s.force_hum;
        break;
      case Channel::laser:
        noise = s.laser_noise;
        break;
      case Channel::coil_current:
        noise = s.current_noise;
        break;
      case Channel::coil_voltage:
      case Channel::mains_voltage:
        noise = s.voltage_noise;
        break;
      case Channel::contact_a:
        noise = s.contact_noise;
        break;
      case Channel::aux:
        noise = s.accelerometer_noise * 10.0 / s.accelerometer_full_scale;
        break;
    }
    for (std::size_t i = 0; i < c.raw.size(); ++i) {
      const double phase = 2 * pi * hertz * r.time(i);
      const double x = noise * random.normal() +
                       hum * std::sqrt(2.0) * (std::sin(phase + 0.7) + std::sin(3 * phase + 1.9) / 3.0);
      const double counts = static_cast<double>(c.raw[i]) + x / c.scale;
      c.raw[i] = static_cast<std::int16_t>(std::lrint(std::clamp(counts, -32768.0, 32767.0)));
    }
  }
}

}  // namespace

RigTruth rig_record(double rate, double closing_angle, double mains_hertz, std::uint64_t seed) {
  rigs::SimRigConfig rig;
  rig.sample_rate = rate;
  rig.record_length = 0.100;
  Conditions conditions;
  conditions.closing_angle = closing_angle;
  conditions.mains_hertz = mains_hertz;
  conditions.seed = seed;
  auto closing = rigs::simulate_record(sim::Specimen{}, conditions, rig);
  RigTruth out;
  out.record = std::move(closing.record);
  add_noise(out.record, rig.sensors, mains_hertz, seed);
  const double t_end = out.record.time(out.record.samples() - 1);
  out.film_a = contacts_of(closing.events, Kind::touch_a, Kind::release_a, t_end);
  out.film_b = contacts_of(closing.events, Kind::touch_b, Kind::release_b, t_end);
  out.pole = both(out.film_a, out.film_b);
  const auto core = contacts_of(closing.events, Kind::core_touch, Kind::core_release, t_end);
  if (!core.empty()) out.core_seat = core.front().touch, out.core_settled = core.back().touch;
  if (core.size() > 1) out.core_retouch = core[1].touch;
  out.closing_angle = closing_angle;
  return out;
}

}  // namespace powbench::bench
