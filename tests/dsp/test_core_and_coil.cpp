#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/phase.h"
#include "dsp/extract.h"

using namespace powbench;
using namespace powbench::dsp;

TEST_CASE("closing angle within 0.1 degrees rms at 50 Hz +- 0.5, its uncertainty calibrated") {
  for (const double hertz : {49.5, 50.0, 50.5}) {
    double e2 = 0, z2 = 0;
    const int n = 40;
    for (int k = 0; k < n; ++k) {
      bench::FullTruth truth;
      const Record r =
          bench::synthesise_full(1e5, hertz, radians(9.0 * k), static_cast<std::uint64_t>(k), &truth);
      ExtractOptions o;
      o.ring_modes = 0;
      const CoilEvents c = extract_events(r, o).coil;
      REQUIRE(c.closing_angle.known());
      const double d = wrap_half_turn(c.closing_angle.value - truth.closing_angle);
      e2 += d * d / n;
      z2 += d * d / (c.closing_angle.u * c.closing_angle.u) / n;
      CHECK(std::abs(c.mains_hertz.value - hertz) < 5 * c.mains_hertz.u);
      CHECK(c.supply_volts.value == Approx(325 / std::sqrt(2.0)).epsilon(0.002));
      CHECK(std::abs(c.switch_on.value) < 10e-6);
    }
    CHECK(degrees(std::sqrt(e2)) < 0.1);
    CHECK(std::sqrt(z2) < 1.6);
  }
}

TEST_CASE("a shot at the wrong angle is flagged") {
  Record r = bench::synthesise_full(1e5, 50, radians(60), 1);
  Events e = extract_events(r);
  const auto off = [&](double tolerance) {
    check_angle(e, r.conditions, tolerance);
    CHECK((e.flags & flag_angle_off) == (e.coil.flags & flag_angle_off));
    return (e.flags & flag_angle_off) != 0;
  };
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = radians(62);
  CHECK(off(radians(1)));
  CHECK_FALSE(off(radians(5)));
  CHECK_FALSE(off(0));  // none given
  r.conditions.closing_angle = radians(240);
  r.conditions.polarity = -1;
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = std::nan("");  // nothing was commanded
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = 0;
  e.coil.closing_angle = {};
  CHECK_FALSE(off(radians(1)));
}

TEST_CASE("core seat from the kink of the travel, on a base that goes on moving") {
  double e2 = 0;
  const int n = 20;
  for (int k = 0; k < n; ++k) {
    bench::FullTruth truth;
    const Record r = bench::synthesise_full(1e5, 50, 0.3 * k, static_cast<std::uint64_t>(k), &truth);
    const CoreEvents c = extract_events(r).core;
    REQUIRE(c.seat.known());
    e2 += std::pow(c.seat.value - truth.core_seat, 2) / n;
    CHECK(c.impact_velocity.value == Approx(truth.impact_velocity).epsilon(0.03));
    CHECK(c.bounce_time.value == 0.0);
    CHECK(c.travel.value == Approx(3.8e-3).epsilon(0.01));
  }
  CHECK(std::sqrt(e2) < 15e-6);
}

TEST_CASE("a core that never moves has no seat") {
  Record r = bench::synthesise_full(1e5, 50, 1, 1);
  bench::Random random(2);
  for (auto& c : r.channels)
    if (c.channel == Channel::laser)
      for (auto& v : c.raw) v = static_cast<std::int16_t>(std::lround(3 * random.normal()));
  const CoreEvents c = extract_events(r).core;
  CHECK(c.present);
  CHECK_FALSE(c.seat.known());
  CHECK(c.travel.value == Approx(0.0).margin(2e-6));
}
