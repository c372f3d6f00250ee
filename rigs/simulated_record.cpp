#include "rigs/simulated_record.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/crc32.h"
#include "core/phase.h"
#include "core/version.h"
#include "rigs/plant_stepper.h"
#include "rigs/sensors.h"

namespace powbench::rigs {

namespace {

SensorConfig without_noise(SensorConfig s) {
  s.force_noise = s.force_hum = s.laser_noise = s.current_noise = s.voltage_noise = 0.0;
  s.contact_noise = s.accelerometer_noise = 0.0;
  s.film_a_inverted = false;
  return s;
}

std::uint32_t record_crc(const Record& record) {
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < record.samples(); ++i) {
    std::uint8_t scan[2 * channel_count];
    for (std::size_t c = 0; c < channel_count; ++c) {
      const auto v = static_cast<std::uint16_t>(record.channels[c].raw[i]);
      scan[2 * c] = static_cast<std::uint8_t>(v & 0xFFU);
      scan[2 * c + 1] = static_cast<std::uint8_t>(v >> 8);
    }
    crc = crc32(scan, crc);
  }
  return crc;
}

}  // namespace

SimulatedClosing simulate_record(const sim::Specimen& specimen, const Conditions& conditions,
                                 const SimRigConfig& rig) {
  const double rate = rig.sample_rate;
  const auto samples = static_cast<std::size_t>(std::llrint(rig.record_length * rate));
  const std::int64_t pretrigger = std::llrint(rig.pretrigger * rate);
  const double angle = conditions.closing_angle + (conditions.polarity < 0 ? pi : 0.0);

  // the plant's time starts with the record; sample n is taken at (n + 1) / rate, switch-on falls on a sample
  const double switch_on = static_cast<double>(pretrigger + 1) / rate;
  const double switch_off = switch_on + conditions.hold_time;
  const sim::Mains mains{.volts = conditions.supply_volts,
                         .hertz = conditions.mains_hertz,
                         .phase = wrap_turn(angle - 2 * pi * conditions.mains_hertz * switch_on)};
  sim::Plant plant(specimen, mains,
                   {.relative_tolerance = rig.integrator_tolerance, .coil_kelvin = conditions.ambient});
  SensorChain sensors(without_noise(rig.sensors), rate, conditions.mains_hertz, conditions.seed);

  SimulatedClosing out;
  Record& record = out.record;
  record.conditions = conditions;
  record.sample_rate = rate;
  record.fire_sample = pretrigger;
  record.rig = "simulation";
  record.firmware = program_version;
  record.calibration = "virtual";
  const auto scales = channel_scales(rig.sensors, rate);
  for (std::size_t c = 0; c < channel_count; ++c) {
    record.channels.push_back({.channel = static_cast<Channel>(c),
                               .raw = std::vector<std::int16_t>(samples),
                               .scale = scales[c].si_per_count,
                               .delay = scales[c].delay,
                               .corner_hertz = scales[c].corner_hertz});
  }

  // in stretches of 1 ms: the integrator is not held to the converter's clock
  constexpr std::size_t stretch = 100;
  std::vector<SwitchEdge> edges{{switch_on, true}, {switch_off, false}};
  std::array<std::int16_t, channel_count> scan{};
  for (std::size_t first = 0; first < samples; first += stretch) {
    const std::size_t count = std::min(stretch, samples - first);
    std::vector<double> times(count * oversampling);
    std::vector<sim::PlantSample> states(times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
      times[i] = static_cast<double>(first * oversampling + i + 1) / (rate * oversampling);
    std::vector<SwitchEdge> due;
    while (!edges.empty() && edges.front().at <= times.back()) {
      due.push_back(edges.front());
      edges.erase(edges.begin());
    }
    advance_through(plant, due, times, states);
    for (std::size_t i = 0; i < count; ++i) {
      sensors.convert({&states[i * oversampling], oversampling}, scan);
      for (std::size_t c = 0; c < channel_count; ++c) record.channels[c].raw[first + i] = scan[c];
    }
  }
  record.crc32 = record_crc(record);

  out.events.assign(plant.events().begin(), plant.events().end());
  for (auto& e : out.events) e.time -= switch_on;
  out.truth = sim::closing_truth(out.events, conditions.hold_time);
  out.evaluations = plant.evaluations();
  return out;
}

}  // namespace powbench::rigs
