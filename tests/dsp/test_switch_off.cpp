#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/phase.h"
#include "core/random.h"
#include "dsp/events/switch_off.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// 40 ms before switch-on to `to`, 20 kHz, with white noise.
Signal drawn(const std::function<double(double)>& at, double to, double noise = 0, std::uint64_t seed = 1) {
  Random random(seed);
  Signal s;
  s.t0 = -0.04, s.dt = 50e-6;
  for (int i = 0; s.t0 + i * s.dt < to; ++i) s.value.push_back(at(s.t0 + i * s.dt) + noise * random.normal());
  s.masked.assign(s.size(), mask_none);
  return s;
}

}  // namespace

TEST_CASE("switch-off of coil voltages: where they depart, and nothing where they do not") {
  for (const double hertz : {49.5, 50.0, 60.0})
    for (int k = 0; k < 12; ++k) {
      const double off = 0.100 + 2e-3 * k;
      const auto voltage = [&](double t) {
        if (t < 0) return 0.0;
        // what the flux that is left induces goes on behind switch-off
        return t < off ? 325 * std::sin(2 * pi * hertz * t + k) : -70 * std::exp(-(t - off) / 5e-3);
      };
      INFO(hertz << " Hz, off at " << off);
      // where the sine and what comes behind it cross, the departure shows late: by less than 2 ms
      const double found = left_at(drawn(voltage, 0.16, 1.0, static_cast<std::uint64_t>(k)));
      CHECK(found > off - 0.2e-3);
      CHECK(found < off + 2e-3);
      CHECK(std::isnan(
          left_at(drawn([&](double t) { return t < off ? voltage(t) : voltage(1e3); }, off, 1.0))));
      CHECK(
          std::isnan(left_at(drawn([&](double t) { return t < 0 ? 0 : 325 * std::sin(314.16 * t); }, 0.16))));
    }
  const auto direct = [](double t) { return t >= 0 && t < 0.12 ? 24.0 : 0.0; };
  CHECK(left_at(drawn(direct, 0.2, 0.05)) == Approx(0.12).margin(1e-4));
  CHECK(std::isnan(left_at(drawn(direct, 0.12, 0.05))));
  const auto rectified = [](double t) {
    return t >= 0 && t < 0.12 ? 325 * std::abs(std::sin(314.16 * t + 1)) : 0.0;
  };
  const double found = left_at(drawn(rectified, 0.2, 0.5));
  CHECK(found > 0.11);
  CHECK(found < 0.121);
}

TEST_CASE("switch-off of coil currents: an economiser is none") {
  // a DC coil behind a diode: off is where the current begins to fall
  const auto freewheel = [](double t) {
    return t < 0 ? 0.0 : t < 0.12 ? 1 - std::exp(-t / 10e-3) : std::exp(-(t - 0.12) / 20e-3);
  };
  CHECK(left_at(drawn(freewheel, 0.3, 1e-3)) == Approx(0.12).margin(3e-3));
  CHECK(std::isnan(left_at(drawn(freewheel, 0.12, 1e-3))));
  // 1 A to pull in, then a tenth of it or a twentieth: still on, for as long as it flows
  for (const double held : {0.1, 0.05}) {
    const auto saving = [&](double t) { return t < 0 || t > 0.25 ? 0.0 : t < 0.1 ? 1.0 : held; };
    CHECK(std::isnan(left_at(drawn(saving, 0.24, 1e-3))));
    CHECK(left_at(drawn(saving, 0.3, 1e-3)) == Approx(0.25).margin(1e-4));
  }
  // an AC coil: a closed magnet takes a twentieth of the inrush, in short peaks
  const auto peaks = [](double t) {
    const double s = std::sin(314.16 * t);
    return t < 0 || t > 0.13 ? 0.0 : (t < 15e-3 ? 1.0 : 0.05) * s * s * s;
  };
  CHECK(std::isnan(left_at(drawn(peaks, 0.13, 1e-3))));
  const double found = left_at(drawn(peaks, 0.17, 1e-3));
  CHECK(found > 0.12);
  CHECK(found < 0.131);
  // the end of a record within a pause of the pulsation says nothing
  CHECK(std::isnan(left_at(drawn(peaks, 0.1005, 1e-3))));
}

TEST_CASE(
    "switch-off of the simulated rig: the commanded time, up to a half period of the solid-state switch "
    "later") {
  for (int k = 0; k < 8; ++k) {
    Conditions c;
    c.closing_angle = radians(45.0 * k);
    c.hold_time = 0.12 + 2e-3 * k;
    rigs::SimRigConfig rig;
    rig.record_length = 0.24;
    Record r = rigs::simulate_record({}, c, rig).record;
    const double by_voltage = seen_switch_off(r);
    CHECK(by_voltage > c.hold_time - 1e-3);
    CHECK(by_voltage < c.hold_time + 10.5e-3);
    std::erase_if(r.channels, [](const ChannelRecord& x) { return x.channel == Channel::coil_voltage; });
    const double by_current = seen_switch_off(r);
    CHECK(by_current > by_voltage - 5e-3);
    CHECK(by_current < by_voltage + 1e-3);
    std::erase_if(r.channels, [](const ChannelRecord& x) { return x.channel == Channel::coil_current; });
    CHECK(std::isnan(seen_switch_off(r)));
    rig.record_length = 0.12;
    CHECK(std::isnan(seen_switch_off(rigs::simulate_record({}, c, rig).record)));
  }
}
