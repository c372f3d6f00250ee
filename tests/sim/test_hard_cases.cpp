// Extreme specimens: each must finish, stay finite, close its ledger, and do the expected.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/closing.h"

using namespace powbench::sim;
using powbench::Conditions;
using powbench::radians;

namespace {

Trajectory shot(const Specimen& s, double degrees = 60, double duration = 0.06, double tolerance = 1e-8) {
  Conditions c;
  c.closing_angle = radians(degrees);
  const auto r = simulate(s, c, duration, 1e-4, tolerance);
  for (const auto& p : r.samples) {
    REQUIRE(std::isfinite(p.travel));
    REQUIRE(std::isfinite(p.coil_current));
    REQUIRE(p.force_a >= 0);
    REQUIRE(p.core_force >= 0);
  }
  return r;
}

}  // namespace

TEST_CASE("no friction: closes earlier") {
  Specimen s;
  s.core.friction = 0;
  const auto r = shot(s);
  REQUIRE(r.truth.touch);
  CHECK(*r.truth.touch < *shot({}).truth.touch);
  CHECK(r.energy_residual < 2e-6);
}

TEST_CASE("no damping anywhere: bounces without end, finishes, keeps its energy") {
  Specimen s;
  s.core.friction = 0;
  s.core.stop_restitution = 1;
  s.bridges.contact_restitution = 1;
  s.bridges.seat_damping = 0;
  s.base.damping = 0;
  const auto r = shot(s);
  REQUIRE(r.truth.touch);
  CHECK(r.truth.openings.size() > shot({}).truth.openings.size());
  CHECK(r.energy_residual < 2e-6);
}

TEST_CASE("shading ring of 1e-9 ohm: no flux enters it; of 1e9 ohm: it is not there") {
  Specimen s;
  s.magnet.ring_resistance = 1e-9;
  const auto tight = shot(s);
  CHECK(tight.energy_residual < 2e-6);
  s.magnet.ring_resistance = 1e9;
  const auto open = shot(s);
  REQUIRE(open.truth.touch);
  CHECK(open.energy_residual < 2e-6);
  s.magnet.shaded_share = 0;
  const auto none = shot(s);
  CHECK(*open.truth.touch == Approx(*none.truth.touch).epsilon(1e-9));
  CHECK(open.evaluations < 2 * none.evaluations);
}

TEST_CASE("a ring just slow enough to be kept agrees with one just fast enough to be dropped") {
  Specimen s;
  s.magnet.ring_resistance = 0.1;
  const auto kept = shot(s, 60, 0.02);
  s.magnet.ring_resistance = 1e3;
  const auto dropped = shot(s, 60, 0.02);
  REQUIRE(kept.truth.touch);
  CHECK(std::fabs(*kept.truth.touch - *dropped.truth.touch) < 20e-6);
  CHECK(kept.evaluations > 3 * dropped.evaluations);
}

TEST_CASE("contacts and stop of 1e10 N/m") {
  Specimen s;
  s.bridges.contact_stiffness = 1e10;
  s.core.stop_stiffness = 1e10;
  const auto r = shot(s, 60, 0.03);
  REQUIRE(r.truth.core_seat);
  // Earlier by the 0.4 um that the softer open stop gives way, at the creeping start of the motion.
  CHECK(*r.truth.touch == Approx(*shot({}).truth.touch).margin(20e-6));
  CHECK(r.energy_residual < 5e-6);
}

TEST_CASE("very soft contacts") {
  Specimen s;
  s.bridges.contact_stiffness = 1e4;
  const auto r = shot(s);
  REQUIRE(r.truth.touch);
  CHECK(r.energy_residual < 2e-6);
}

TEST_CASE("mass ratio of 1e4 between core and bridge") {
  Specimen s;
  s.bridges.mass = s.core.mass / 1e4;
  s.bridges.inertia = 6e-7 / 500;
  s.bridges.seat_stiffness = 1e6;
  const auto r = shot(s, 60, 0.03);
  REQUIRE(r.truth.touch);
  CHECK(r.energy_residual < 2e-6);
}

TEST_CASE("tilted bridge: break A touches first, the pole closes with break B") {
  Specimen s;
  s.bridges.tilt_gap = 0.2e-3;
  const auto r = shot(s);
  REQUIRE(r.truth.touch_a);
  REQUIRE(r.truth.touch_b);
  CHECK(*r.truth.touch_b > *r.truth.touch_a + 50e-6);
  CHECK(*r.truth.touch >= *r.truth.touch_b);
  CHECK(r.energy_residual < 2e-6);
  s.bridges.tilt_gap = -0.2e-3;
  const auto other = shot(s);
  CHECK(*other.truth.touch_b < *other.truth.touch_a);
}

TEST_CASE("a vanishing tilt gives the untilted closing") {
  // the last touch moves 2e4 times as far as the first one, by the tilt (1e-12 m: 2e-8 s) as by the error of a step:
  // the tolerance must be finer than the question
  Specimen s;
  s.bridges.tilt_gap = 1e-12;
  const auto tilted = shot(s, 60, 0.06, 1e-10);
  const auto level = shot({}, 60, 0.06, 1e-10);
  CHECK(std::fabs(*tilted.truth.touch - *level.truth.touch) < 1e-11);
  CHECK(std::fabs(*tilted.truth.settled - *level.truth.settled) < 1e-7);
}

TEST_CASE("poles with different gaps are bodies of their own; equal ones give the lumped closing") {
  Specimen s;
  s.bridges.gap_spread = 1e-13;
  const auto apart = shot(s);
  const auto lumped = shot({});
  CHECK(std::fabs(*apart.truth.touch - *lumped.truth.touch) < 1e-9);
  CHECK(std::fabs(*apart.truth.settled - *lumped.truth.settled) < 1e-6);
  s.bridges.gap_spread = 0.1e-3;
  const auto spread = shot(s);
  CHECK(std::fabs(*spread.truth.touch - *lumped.truth.touch) < 50e-6);
  CHECK(spread.energy_residual < 2e-6);
}

TEST_CASE("no leakage inductance and no saturation") {
  Specimen s;
  s.coil.leakage = 0;
  s.magnet.bh_power = 0;
  const auto r = shot(s);
  REQUIRE(r.truth.touch);
  CHECK(r.energy_residual < 2e-6);
}

TEST_CASE("no supply: nothing moves") {
  Conditions c;
  c.supply_volts = 0;
  const auto r = simulate({}, c, 0.05, 1e-3);
  for (const auto& p : r.samples) CHECK(p.travel == 0);
  CHECK_FALSE(r.truth.touch);
}
