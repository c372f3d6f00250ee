// Closings of the reference contactor.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/closing.h"

using namespace powbench::sim;
using powbench::Conditions;
using powbench::radians;

namespace {

Conditions at(double degrees, double volts = 230, double hertz = 50) {
  Conditions c;
  c.closing_angle = radians(degrees);
  c.supply_volts = volts;
  c.mains_hertz = hertz;
  return c;
}

}  // namespace

TEST_CASE("the reference contactor closes in the published range at the six published angles") {
  for (const double angle : {30.0, 60.0, 90.0, 120.0, 150.0, 180.0}) {
    const auto r = simulate({}, at(angle), 0.1, 0);
    CAPTURE(angle);
    REQUIRE(r.truth.touch);
    REQUIRE(r.truth.core_seat);
    CHECK(*r.truth.touch >= 11e-3);
    CHECK(*r.truth.touch <= 18e-3);
    CHECK(*r.truth.core_seat >= 13e-3);
    CHECK(*r.truth.core_seat <= 20e-3);
    CHECK(*r.truth.core_seat > *r.truth.touch);
    CHECK(*r.truth.settled < 35e-3);
    CHECK(r.truth.openings.size() >= 1);
    CHECK(r.energy_residual < 1e-6);
  }
}

TEST_CASE("default tolerance: first touch and core seat within 1 us of a much tighter run") {
  for (const double angle : {0.0, 45.0, 80.0, 90.0, 135.0}) {
    const auto usual = simulate({}, at(angle), 0.06, 0);
    const auto tight = simulate({}, at(angle), 0.06, 0, 1e-12);
    CAPTURE(angle);
    REQUIRE(usual.truth.touch);
    REQUIRE(tight.truth.core_seat);
    CHECK(std::fabs(*usual.truth.touch - *tight.truth.touch) < 1e-7);
    CHECK(std::fabs(*usual.truth.core_seat - *tight.truth.core_seat) < 1e-7);
    CHECK(std::fabs(*usual.truth.settled - *tight.truth.settled) < 1e-6);
    CHECK(usual.truth.openings.size() == tight.truth.openings.size());
  }
}

TEST_CASE("angle and angle + 180 degrees, by phase and by polarity, are the same closing") {
  for (const double angle : {10.0, 75.0, 130.0}) {
    const auto plus = simulate({}, at(angle), 0.06, 1e-3);
    const auto half_turn = simulate({}, at(angle + 180), 0.06, 1e-3);
    auto reversed = at(angle);
    reversed.polarity = -1;
    const auto minus = simulate({}, reversed, 0.06, 1e-3);
    CAPTURE(angle);
    CHECK(std::fabs(*plus.truth.touch - *half_turn.truth.touch) < 1e-9);
    CHECK(std::fabs(*plus.truth.core_seat - *half_turn.truth.core_seat) < 1e-9);
    CHECK(std::fabs(*plus.truth.settled - *half_turn.truth.settled) < 1e-7);
    CHECK(std::fabs(*minus.truth.touch - *half_turn.truth.touch) < 1e-9);
    for (std::size_t k = 0; k < plus.samples.size(); ++k)
      CHECK(plus.samples[k].coil_current == Approx(-half_turn.samples[k].coil_current).margin(1e-7));
  }
}

TEST_CASE("supply: no pick-up at 0.7 of rated voltage, sure closing at 0.85 and 1.1, at 45 and 65 Hz") {
  for (const double angle : {0.0, 40.0, 90.0, 140.0}) {
    CAPTURE(angle);
    CHECK_FALSE(simulate({}, at(angle, 0.7 * 230), 0.1, 0).truth.core_seat);
    CHECK(simulate({}, at(angle, 0.85 * 230), 0.1, 0).truth.core_seat);
    const auto strong = simulate({}, at(angle, 1.1 * 230), 0.06, 0);
    REQUIRE(strong.truth.core_seat);
    CHECK(*strong.truth.core_seat < *simulate({}, at(angle), 0.06, 0).truth.core_seat);
    CHECK(simulate({}, at(angle, 230, 45), 0.06, 0).truth.core_seat);
    CHECK(simulate({}, at(angle, 250, 65), 0.1, 0).truth.core_seat);
  }
}

TEST_CASE("a warm coil closes later") {
  auto warm = at(120);
  warm.ambient += 40;
  CHECK(*simulate({}, warm, 0.08, 0).truth.touch > *simulate({}, at(120), 0.08, 0).truth.touch + 0.5e-3);
}

TEST_CASE(
    "truth from events: both breaks count, openings lie between first and last touch, drop-out is not "
    "bounce") {
  using Kind = PlantEvent::Kind;
  const std::vector<PlantEvent> events{
      {Kind::touch_a, 0.010, 0.5},     {Kind::touch_b, 0.011, 0.6},     {Kind::release_a, 0.012, -0.2},
      {Kind::release_b, 0.0125, -0.2}, {Kind::touch_b, 0.0128, 0.1},    {Kind::touch_a, 0.013, 0.1},
      {Kind::core_touch, 0.014, 1.2},  {Kind::core_release, 0.0141, 0}, {Kind::core_touch, 0.015, 0.3},
      {Kind::release_b, 0.120, -0.1},  {Kind::release_a, 0.121, -0.1}};
  const auto t = closing_truth(events, 0.1);
  CHECK(*t.touch == 0.011);
  CHECK(t.touch_velocity == 0.6);
  CHECK(*t.touch_a == 0.010);
  CHECK(*t.touch_b == 0.011);
  REQUIRE(t.openings.size() == 1);
  CHECK(t.openings[0].release == 0.012);
  CHECK(t.openings[0].touch == 0.013);
  CHECK(*t.settled == 0.013);
  CHECK(*t.core_seat == 0.014);
  CHECK(*t.core_settled == 0.015);
  CHECK(t.seat_velocity == 1.2);
  CHECK(*t.opened == 0.120);
}

TEST_CASE("hold time: the coil is switched off and the contacts open again") {
  auto c = at(60);
  c.hold_time = 0.05;
  const auto r = simulate({}, c, 0.15, 1e-3);
  REQUIRE(r.truth.opened);
  CHECK(*r.truth.opened > 0.05);
  CHECK(*r.truth.settled < 0.05);
  CHECK(r.samples.size() == 150);
  CHECK(std::fabs(r.samples.back().travel) < 1e-4);
}

TEST_CASE("bad conditions are refused") {
  auto c = at(0);
  c.mains_hertz = 0;
  CHECK_THROWS_WITH(simulate({}, c, 0.1, 0), Catch::Contains("mains_hertz"));
  c = at(0);
  c.polarity = 2;
  CHECK_THROWS_WITH(simulate({}, c, 0.1, 0), Catch::Contains("polarity"));
  CHECK_THROWS_WITH(simulate({}, at(0), -1, 0), Catch::Contains("duration"));
}
