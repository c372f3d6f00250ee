#include <catch2/catch.hpp>
#include <cmath>

#include "core/phase.h"
#include "core/random.h"
#include "core/units.h"
#include "dsp/events/coil.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// Mains and coil voltage of 325 V with noise of `sigma` V each, closed at `angle` by a switch that takes `late` s.
Record noisy(double angle, double late, double sigma, powbench::Random& random) {
  Record r;
  r.sample_rate = 100e3;
  r.fire_sample = 4200;
  r.conditions.mains_hertz = 50;
  ChannelRecord mains, coil;
  mains.channel = Channel::mains_voltage, coil.channel = Channel::coil_voltage;
  for (ChannelRecord* c : {&mains, &coil}) c->scale = 0.02, c->clip_low = -32768, c->clip_high = 32767;
  const auto counts = [&](double volts) {
    return static_cast<std::int16_t>(std::lround((volts + sigma * random.normal()) / 0.02));
  };
  for (int i = 0; i < 10'000; ++i) {
    const double t = (i - 4200) / r.sample_rate, volts = 325 * std::sin(2 * pi * 50 * t + angle);
    mains.raw.push_back(counts(volts));
    coil.raw.push_back(counts(t >= late ? volts : 0));
  }
  r.channels = {mains, coil};
  return r;
}

}  // namespace

TEST_CASE("the closing angle is within its uncertainty in any noise, near a zero of the mains too") {
  const double sigma = GENERATE(0.3, 2.0, 20.0, 40.0);
  INFO(sigma << " V of noise");
  powbench::Random random(11);
  const int n = 200;
  int beyond = 0;
  double squares = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * pi * random.uniform(), late = k % 2 == 0 ? 0.0 : 350e-6 * random.uniform();
    const Record r = noisy(angle, late, sigma, random);
    const CoilEvents c = coil_events(r, supply_fit(r, {}), {});
    INFO(degrees(angle) << " deg: " << c.no_angle);
    REQUIRE(c.closing_angle.known());
    const double z = wrap_half_turn(c.closing_angle.value - angle - 2 * pi * 50 * late) / c.closing_angle.u;
    CHECK(std::abs(z) < 6);
    beyond += std::abs(z) > 2 ? 1 : 0;
    squares += z * z / n;
  }
  CHECK(beyond <= n / 20);
  CHECK(std::sqrt(squares) < 1.15);
}
