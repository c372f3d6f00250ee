#include "rigs/sensors.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::rigs;

TEST_CASE("low-pass: unit gain at DC, half the power at the corner", "[sensors]") {
  constexpr double rate = 200e3, corner = 30e3;
  LowPass dc(corner, rate);
  double y = 0;
  for (int i = 0; i < 1000; ++i) y = dc.step(1.0);
  CHECK(y == Approx(1.0).epsilon(1e-12));
  LowPass filter(corner, rate);
  double power = 0;
  for (int i = 0; i < 40'000; ++i) {
    const double out = filter.step(std::sin(2 * pi * corner * i / rate));
    if (i >= 20'000) power += out * out;
  }
  CHECK(power / 20'000 == Approx(0.25).epsilon(1e-3));  // a sine has power 1/2
}

TEST_CASE("high-pass: a step decays with the time constant of the corner", "[sensors]") {
  constexpr double rate = 200e3, corner = 5.0;
  HighPass filter(corner, rate);
  double y = 0;
  const int n = static_cast<int>(0.05 * rate);
  for (int i = 0; i < n; ++i) y = filter.step(1.0);
  CHECK(y == Approx(std::exp(-2 * pi * corner * 0.05)).epsilon(2e-3));
}

TEST_CASE("resonator: exact against the closed-form step response", "[sensors]") {
  constexpr double rate = 200e3, hertz = 3100, damping = 0.015;
  Resonator mode(hertz, damping, rate);
  const double w = 2 * pi * hertz, wd = w * std::sqrt(1 - damping * damping);
  for (int i = 1; i <= 2000; ++i) {
    mode.step(2.0);
    const double t = i / rate;
    const double exact =
        2.0 * (1 - std::exp(-damping * w * t) * (std::cos(wd * t) + damping * w / wd * std::sin(wd * t)));
    REQUIRE(mode.value() == Approx(exact).margin(1e-11));
  }
}

TEST_CASE("the chain keeps a constant force apart from its droop, and saturates beyond full scale",
          "[sensors]") {
  SensorConfig config;
  config.force_noise = config.force_hum = config.force_crosstalk = 0.0;
  for (const double force : {10.0, 100.0, 400.0, -400.0}) {
    SensorChain chain(config, 100e3, 50.0, 1);
    std::array<std::int16_t, channel_count> scan{};
    std::array<sim::PlantSample, oversampling> plant{};
    for (int n = 0; n < 200; ++n) {
      for (int k = 0; k < oversampling; ++k)
        plant[k] = {.time = (n * oversampling + k + 1) / 200e3, .force_a = force};
      chain.convert(plant, scan);
    }
    const double value = scan[index(Channel::pvdf_a)] * 250.0 / 32768;
    const double droop = std::exp(-2 * pi * 0.5 * 200 / 100e3);
    CHECK(value == Approx(std::clamp(force * droop, -250.0, 250.0)).margin(0.02));
  }
}

TEST_CASE("the laser shows the travel of its stated delay ago", "[sensors]") {
  SensorConfig config;
  config.laser_noise = 0.0;
  SensorChain chain(config, 100e3, 50.0, 3);
  const auto scales = channel_scales(config, 100e3);
  std::array<std::int16_t, channel_count> scan{};
  std::array<sim::PlantSample, oversampling> plant{};
  double worst = 0, mean = 0;
  int counted = 0;
  for (int n = 0; n < 1500; ++n) {
    double t = 0;
    for (int k = 0; k < oversampling; ++k) {
      t = (n * oversampling + k + 1) / 200e3;
      plant[k] = {.time = t, .travel = 0.5 * t};  // 0.5 m/s
    }
    chain.convert(plant, scan);
    if (n < 100) continue;
    const double shown = scan[index(Channel::laser)] * config.laser_scale;
    const double expected = 0.5 * (t - scales[index(Channel::laser)].delay);
    worst = std::max(worst, std::abs(shown - expected));
    mean += shown - expected;
    ++counted;
  }
  // held for up to one laser period, quantised to 0.25 um
  CHECK(worst < 0.5 * (0.5 / config.laser_rate) + 0.3e-6);
  CHECK(std::abs(mean / counted) < 0.3e-6);
}

TEST_CASE("a simulated closing is a record like any other, without noise and reproducible", "[sensors]") {
  Conditions c;
  c.closing_angle = radians(60.0);
  const auto a = simulate_record({}, c, {});
  const auto b = simulate_record({}, c, {});
  CHECK(a.record.samples() == 14'000);
  CHECK(a.record.channels.size() == channel_count);
  CHECK(a.record.crc32 == b.record.crc32);
  REQUIRE(a.truth.touch);
  for (std::size_t n = 0; n < 4000; ++n) REQUIRE(a.record.find(Channel::pvdf_a)->raw[n] == 0);
  // the pole's voltage falls when the integrator says it touches
  const auto* contact = a.record.find(Channel::contact_a);
  std::size_t n = 4000;
  while (contact->value(n) > 3.0) ++n;
  CHECK(a.record.time(n) == Approx(*a.truth.touch).margin(1.1e-5));
}

TEST_CASE("only the channels asked for are computed, and they are the same to the last bit", "[sensors]") {
  Conditions c;
  c.closing_angle = radians(60.0);
  const auto all = simulate_record({}, c, {});
  CHECK(all.conversions == static_cast<std::int64_t>(all.record.samples() * channel_count));
  for (const std::vector<Channel>& wanted : {std::vector{Channel::contact_a, Channel::laser},
                                             {Channel::pvdf_b},
                                             {Channel::aux, Channel::coil_current}}) {
    SimRigConfig rig;
    rig.sensors.channels = 0;
    for (const Channel w : wanted) rig.sensors.channels |= 1U << index(w);
    const auto some = simulate_record({}, c, rig);
    CHECK(some.conversions == static_cast<std::int64_t>(some.record.samples() * wanted.size()));
    CHECK(some.evaluations == all.evaluations);  // the motion does not depend on who looks
    REQUIRE(some.record.channels.size() == wanted.size());
    for (const Channel w : wanted) {
      REQUIRE(some.record.find(w) != nullptr);
      CHECK((some.record.find(w)->raw == all.record.find(w)->raw));
    }
  }
  SimRigConfig nothing;
  nothing.sensors.channels = 0;
  CHECK_THROWS_AS(simulate_record({}, c, nothing), std::invalid_argument);
}

TEST_CASE("another rung of the simulator goes through the same sensors into the same record", "[sensors]") {
  Conditions c;
  c.closing_angle = radians(60.0);
  c.hold_time = 0.06;
  const auto plant = [](const sim::Specimen& s, const Conditions& q, double duration, double dt) {
    return sim::simulate(s, q, duration, dt, SimRigConfig{}.integrator_tolerance);
  };
  const auto a = simulate_record({}, c, {});
  const auto b = simulate_record_with(plant, "simulation, again", {}, c, {});
  CHECK(b.record.rig == "simulation, again");
  CHECK(b.record.samples() == a.record.samples());
  CHECK(*b.truth.touch == Approx(*a.truth.touch).margin(1e-8));
  CHECK(*b.truth.opened == Approx(*a.truth.opened).margin(1e-6));
  // the integrator steps otherwise, so the last bit may differ; contact voltage and force jump at a touch
  for (const auto& channel : a.record.channels) {
    const auto* other = b.record.find(channel.channel);
    int far = 0;
    for (std::size_t n = 0; n < channel.raw.size(); ++n) far += std::abs(channel.raw[n] - other->raw[n]) > 8;
    CAPTURE(channel.channel);
    CHECK(far < 20);
  }
  // the mains beside the closing are the bench's, harmonics and all
  SimRigConfig polluted;
  polluted.supply.mains.harmonics[0].share = 0.2;
  const auto wave = simulate_record({}, c, polluted);
  const auto same = simulate_record_with(plant, "x", {}, c, polluted);
  const auto& mains = *wave.record.find(Channel::mains_voltage);
  int apart = 0;
  for (std::size_t n = 0; n < mains.raw.size(); ++n)
    apart += std::abs(mains.raw[n] - same.record.find(Channel::mains_voltage)->raw[n]) > 2;
  CHECK(apart == 0);
  // a rung that stops early holds its last state
  const auto early = [](const sim::Specimen& s, const Conditions& q, double, double dt) {
    return sim::simulate(s, q, 0.03, dt);
  };
  const auto short_one = simulate_record_with(early, "early", {}, c, {});
  const auto* travel = short_one.record.find(Channel::laser);
  CHECK(travel->raw.back() == travel->raw[travel->raw.size() - 1000]);
  SimRigConfig no_room;
  no_room.record_length = no_room.pretrigger;
  CHECK_THROWS_AS(simulate_record_with(plant, "x", {}, c, no_room), std::invalid_argument);
}
