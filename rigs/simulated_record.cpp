#include "rigs/simulated_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/commanded_phase.h"
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
    for (std::size_t c = 0; c < record.channels.size(); ++c) {
      const auto v = static_cast<std::uint16_t>(record.channels[c].raw[i]);
      scan[2 * c] = static_cast<std::uint8_t>(v & 0xFFU);
      scan[2 * c + 1] = static_cast<std::uint8_t>(v >> 8);
    }
    crc = crc32({scan, 2 * record.channels.size()}, crc);
  }
  return crc;
}

Record empty_record(const Conditions& conditions, const SimRigConfig& rig, const std::string& name) {
  Record record;
  record.conditions = conditions;
  record.sample_rate = rig.sample_rate;
  record.fire_sample = std::llrint(rig.pretrigger * rig.sample_rate);
  record.rig = name;
  record.firmware = program_version;
  record.calibration = "virtual";
  const auto samples = static_cast<std::size_t>(std::llrint(rig.record_length * rig.sample_rate));
  const auto scales = channel_scales(rig.sensors, rig.sample_rate);
  if ((rig.sensors.channels & all_channels) == 0)
    throw std::invalid_argument("channels: allowed at least one of the channel table");
  for (std::size_t c = 0; c < channel_count; ++c) {
    if (!contains(rig.sensors.channels, static_cast<Channel>(c))) continue;
    record.channels.push_back({.channel = static_cast<Channel>(c),
                               .raw = std::vector<std::int16_t>(samples),
                               .scale = scales[c].si_per_count,
                               .delay = scales[c].delay,
                               .corner_hertz = scales[c].corner_hertz});
  }
  return record;
}

/// Samples first, first + 1, ... of the record from `oversampling` plant states each.
void convert(SensorChain& sensors, const std::vector<sim::PlantSample>& states, std::size_t first,
             Record& record) {
  std::array<std::int16_t, channel_count> scan{};
  for (std::size_t i = 0; i < states.size() / oversampling; ++i) {
    sensors.convert({&states[i * oversampling], oversampling}, scan);
    for (auto& c : record.channels) c.raw[first + i] = scan[index(c.channel)];
  }
}

}  // namespace

SimulatedClosing simulate_record(const sim::Specimen& specimen, const Conditions& conditions,
                                 const SimRigConfig& rig) {
  const double rate = rig.sample_rate;
  const double angle = commanded_phase(conditions);
  SimulatedClosing out;
  out.record = empty_record(conditions, rig, "simulation");
  const std::size_t samples = out.record.samples();

  // the plant's time starts with the record; sample n is taken at (n + 1) / rate, switch-on falls on a sample
  const double switch_on = static_cast<double>(out.record.fire_sample + 1) / rate;
  const double switch_off = switch_on + conditions.hold_time;
  sim::Mains mains = rig.supply.mains;
  mains.volts = conditions.supply_volts;
  mains.hertz = conditions.mains_hertz;
  mains.phase = wrap_turn(angle - 2 * pi * conditions.mains_hertz * switch_on);
  sim::Plant plant(specimen, mains,
                   {.relative_tolerance = rig.integrator_tolerance,
                    .coil_kelvin = conditions.ambient,
                    .coil_switch = rig.supply.coil_switch,
                    .suppression = rig.supply.suppression});
  SensorChain sensors(without_noise(rig.sensors), rate, conditions.mains_hertz, conditions.seed);

  // in stretches of 1 ms: the integrator is not held to the converter's clock
  constexpr std::size_t stretch = 100;
  std::vector<SwitchEdge> edges{{switch_on, true}, {switch_off, false}};
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
    convert(sensors, states, first, out.record);
  }
  out.record.crc32 = record_crc(out.record);

  out.events.assign(plant.events().begin(), plant.events().end());
  for (auto& e : out.events) e.time -= switch_on;
  out.truth = sim::closing_truth(out.events, conditions.hold_time);
  out.conversions = sensors.conversions();
  out.evaluations = plant.evaluations();
  return out;
}

SimulatedClosing simulate_record_with(const ClosingRun& run, const std::string& name,
                                      const sim::Specimen& specimen, const Conditions& conditions,
                                      const SimRigConfig& rig) {
  const double dt = 1 / (rig.sample_rate * oversampling);
  SimulatedClosing out;
  out.record = empty_record(conditions, rig, name);
  const std::size_t states = out.record.samples() * oversampling;
  const std::size_t rest =
      static_cast<std::size_t>(out.record.fire_sample + 1) * oversampling;  // at and before 0
  if (rest >= states) throw std::invalid_argument("record_length: allowed above the pretrigger");
  const double duration = static_cast<double>(states - rest) * dt;
  auto closing = run(specimen, conditions, duration + 0.5 * dt, dt);

  std::vector<sim::PlantSample> all(states);
  const sim::Mains mains = sim::closing_mains(conditions, rig.supply.mains);
  sim::PlantSample last;
  for (std::size_t i = 0; i < states; ++i) {
    const bool known = i >= rest && i - rest < closing.samples.size();
    if (known) last = closing.samples[i - rest];
    all[i] = last;
    all[i].time = static_cast<double>(i + 1) * dt;
    const double t = all[i].time - static_cast<double>(rest) * dt;
    all[i].mains_voltage = mains_voltage(mains, mains_piece(mains, t, 0), t);
    if (!known && i >= rest) all[i].coil_voltage = t < conditions.hold_time ? all[i].mains_voltage : 0;
  }
  SensorChain sensors(without_noise(rig.sensors), rig.sample_rate, conditions.mains_hertz, conditions.seed);
  convert(sensors, all, 0, out.record);
  out.record.crc32 = record_crc(out.record);
  out.events = std::move(closing.events);
  out.truth = closing.truth;
  out.conversions = sensors.conversions();
  out.evaluations = closing.evaluations;
  out.field_states = closing.field_states;
  out.field_beyond = closing.field_beyond;
  return out;
}

}  // namespace powbench::rigs
