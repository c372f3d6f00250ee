#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/units.h"
#include "firmware/bench_devices.h"
#include "firmware/controller.h"
#include "firmware/iiod/responder.h"

/// A controller on an ideal front end: clean mains, a coil whose current follows the gate. No plant, no
/// sensors.
namespace powbench::test {

struct Answers final : firmware::iiod::ByteSink {
  void put(std::span<const std::uint8_t> bytes) override { text.append(bytes.begin(), bytes.end()); }
  std::string text;
};

struct Bench {
  static constexpr std::int64_t block_samples = 10;
  static constexpr double rate = 100e3;

  explicit Bench(double hertz = 50.0, double start_phase = 0.3) : mains_hertz(hertz), phase(start_phase) {
    controller.lease().claim("t", 3'600'000, "test");  // commands through ask() end in " t"
  }

  static firmware::ControllerConfig make_config() {
    firmware::ControllerConfig c;
    c.record_length = 3000;
    c.pretrigger = 1000;
    c.phase.sample_rate = static_cast<float>(rate);
    c.phase.nominal_amplitude = 16000.0F;
    c.interlocks = {.overcurrent_counts = 20000,
                    .no_current_counts = 100,
                    .no_current_samples = 480,
                    .stuck_on_samples = 2500,
                    .mains_lost_counts = 3200,
                    .mains_lost_samples = 1600};
    return c;
  }

  double phase_at(double sample) const {
    const double t = sample / rate;
    return phase + 2 * pi * mains_hertz * t + hunting * std::sin(2 * pi * hunting_hertz * t);
  }

  /// One block of the ideal front end.
  void step(bool emergency_stop = false) {
    std::vector<std::int16_t> scans(static_cast<std::size_t>(block_samples) * channel_count);
    for (std::int64_t i = 0; i < block_samples; ++i) {
      const std::int64_t n = next + i;
      auto* scan = &scans[static_cast<std::size_t>(i) * channel_count];
      const double v = mains_on ? 16000.0 * std::sin(phase_at(static_cast<double>(n))) : 0.0;
      scan[index(Channel::mains_voltage)] = static_cast<std::int16_t>(std::lrint(v));
      bool gate = gate_level;
      for (const auto& e : edges)
        if (e.at.sample_at_or_after() <= n) gate = e.on;
      scan[index(Channel::coil_current)] = static_cast<std::int16_t>(gate || shorted ? current : 0);
      scan[index(Channel::coil_voltage)] = static_cast<std::int16_t>(gate ? std::lrint(v) : 0);
      scan[index(Channel::pvdf_a)] = static_cast<std::int16_t>(n % 30000);
    }
    next += block_samples;
    for (auto e = edges.begin(); e != edges.end();)
      if (e->at.sample_at_or_after() < next) {
        gate_level = e->on;
        e = edges.erase(e);
      } else {
        ++e;
      }
    firmware::Block block{.first_sample = next - block_samples,
                          .scans = scans,
                          .emergency_stop = emergency_stop,
                          .owner_present = owner_present};
    if (drop_next > 0) {
      block.first_sample += drop_next;
      block.scans = block.scans.subspan(static_cast<std::size_t>(drop_next) * channel_count);
      drop_next = 0;
    }
    for (const auto& e : controller.step(block)) {
      edges.push_back(e);
      history.push_back(e);
    }
  }

  void run(double seconds) {
    for (const std::int64_t end = next + std::llrint(seconds * rate); next < end;) step();
  }

  /// Feeds text, returns the answers.
  std::string ask(std::string_view request) {
    Answers answers;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(request.data());
    std::size_t used = 0;
    while (used < request.size() && connection.status() == firmware::iiod::Connection::Status::ready)
      used += responder.feed(connection, {bytes + used, request.size() - used}, answers);
    return answers.text;
  }

  firmware::FireControl& fire_control() { return controller.fire_control(); }

  double mains_hertz, phase;
  double hunting = 0, hunting_hertz = 2;  ///< rad, Hz: swing of the phase
  bool mains_on = true, shorted = false;
  bool owner_present = true;  ///< stands for a heartbeat in every block
  int current = 8000;
  std::int64_t drop_next = 0;
  std::int64_t next = 0;
  bool gate_level = false;
  std::vector<firmware::GateEdge> edges;    ///< scheduled, not yet reached
  std::vector<firmware::GateEdge> history;  ///< all that were ever given out
  std::vector<std::int16_t> storage = std::vector<std::int16_t>(4000 * channel_count);
  firmware::Controller controller{make_config(), storage};
  firmware::BenchDevices devices{controller};
  std::array<const firmware::iiod::Device*, 3> list{&devices.daq(), &devices.control(), &devices.trigger()};
  firmware::iiod::Context context{.description = "test <bench> & \"co\"", .attributes = {}, .devices = list};
  firmware::iiod::Responder responder{context};
  firmware::iiod::Connection connection;
};

}  // namespace powbench::test
