// Closings that are hard to simulate or to judge.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/study/modes.h"
#include "tests/sim/study/points.h"

using namespace powbench::sim;
using powbench::Conditions;
using powbench::radians;

namespace {

Conditions at(double degrees, double volts = 230) {
  Conditions c;
  c.closing_angle = radians(degrees);
  c.supply_volts = volts;
  return c;
}

ClosingTruth close(const Specimen& s, const Conditions& c, double tolerance = 1e-8, double duration = 0.08) {
  return simulate(s, c, duration, 0, tolerance).truth;
}

}  // namespace

TEST_CASE("theta and theta + 180 deg give the same closing: nothing in the model remembers") {
  for (const double degrees : {0.0, 37.0, 78.0, 90.0, 150.0}) {
    const auto a = close({}, at(degrees));
    const auto b = close({}, at(degrees + 180));
    REQUIRE((a.settled && b.settled));
    CHECK(*a.touch == Approx(*b.touch).margin(1e-9));
    CHECK(*a.core_seat == Approx(*b.core_seat).margin(1e-9));
    CHECK(*a.settled == Approx(*b.settled).margin(1e-7));
  }
}

TEST_CASE("near the cliff 1 % of the mains decides between two outcomes, which a mean would hide") {
  // one half-wave just suffices or just does not, and the offset flux dies out through zero early or late
  Team team(2);
  int bistable = 0;
  for (int degrees = 60; degrees <= 90; degrees += 2) {
    Case edge;
    edge.conditions = at(degrees);
    const Design scatter({uniform_axis("supply_volts", 0.99 * 230, 1.01 * 230)}, Sampling::latin, 60, 4);
    std::vector<double> settled;
    std::vector<std::int64_t> all(60);
    std::iota(all.begin(), all.end(), 0);
    for (const auto& m : run_points(scatter, edge, all, {}, team)) {
      REQUIRE(m.closed == 1);
      settled.push_back(m.settled);
    }
    const auto found = modes(settled);
    // outcomes that are milliseconds apart, with no closing halfway between: that is what makes them two
    for (std::size_t k = 1; k < found.size(); ++k) {
      if (found[k].mean - found[k - 1].mean < 5e-3) continue;
      ++bistable;
      const double middle = 0.5 * (found[k - 1].mean + found[k].mean);
      CHECK((found[k - 1].high < middle && middle < found[k].low));
    }
  }
  CHECK(bistable >= 1);
}

TEST_CASE("0.85 and 1.1 of the rated voltage, cold and hot coil: it closes, and later with less flux") {
  for (const double degrees : {0.0, 60.0, 120.0}) {
    const auto low = close({}, at(degrees, 0.85 * 230));
    const auto rated = close({}, at(degrees));
    const auto high = close({}, at(degrees, 1.1 * 230));
    REQUIRE((low.core_seat && rated.core_seat && high.core_seat));
    CHECK(*high.touch < *rated.touch);
    CHECK(*rated.touch < *low.touch);
    Conditions cold = at(degrees);
    cold.ambient = 253.15;
    Conditions hot = at(degrees);
    hot.ambient = 313.15;
    const auto c = close({}, cold);
    const auto h = close({}, hot);
    REQUIRE((c.touch && h.touch));
    CHECK(*c.touch < *rated.touch);
    CHECK(*h.touch > *rated.touch);
  }
}

TEST_CASE("no pick-up: half the rated voltage moves the core but closes nothing, at every angle") {
  for (double degrees = 0; degrees < 180; degrees += 15) {
    const auto t = close({}, at(degrees, 115));
    CHECK_FALSE(t.touch);
    CHECK_FALSE(t.core_seat);
    CHECK(t.openings.empty());
  }
}

TEST_CASE("contacts that never settle: without a ring the core drops at every zero of the flux") {
  Specimen s;
  s.magnet.shaded_share = 0;
  Conditions held = at(90);
  held.hold_time = 0.2;
  const auto t = close(s, held, 1e-6, 0.2);
  REQUIRE(t.settled);
  CHECK(*t.settled > 0.15);
  CHECK(t.openings.size() > 10);
  // openings are in order and apart, however many
  for (std::size_t k = 0; k < t.openings.size(); ++k) {
    CHECK(t.openings[k].release < t.openings[k].touch);
    if (k > 0) CHECK(t.openings[k - 1].touch <= t.openings[k].release);
  }
}

TEST_CASE(
    "a hard mounting bounces shorter than the soft one: the base's motion is what re-opens the contacts") {
  Specimen soft;
  Specimen hard;
  hard.base.mass = 5;
  hard.base.hertz = 2000;
  double sum_soft = 0;
  double sum_hard = 0;
  for (const double degrees : {30.0, 120.0, 150.0}) {
    const auto a = close(soft, at(degrees));
    const auto b = close(hard, at(degrees));
    REQUIRE((a.settled && b.settled));
    sum_soft += *a.settled - *a.touch;
    sum_hard += *b.settled - *b.touch;
  }
  CHECK(sum_hard < 0.7 * sum_soft);
}

TEST_CASE("one bridge missing: less spring force, so the core arrives earlier and still seats") {
  Specimen two;
  two.bridges.poles = 2;
  for (const double degrees : {0.0, 60.0, 120.0}) {
    const auto all = close({}, at(degrees));
    const auto less = close(two, at(degrees));
    REQUIRE((all.core_seat && less.core_seat));
    CHECK(*less.core_seat < *all.core_seat);
  }
}

TEST_CASE("a weakly damped stop makes the core bounce, and every arrival is counted") {
  Specimen s;
  s.core.stop_restitution = 0.6;
  const auto hard = close(s, at(90));
  const auto reference = close({}, at(90));
  REQUIRE((hard.core_seat && reference.core_seat));
  CHECK(*hard.core_settled - *hard.core_seat > *reference.core_settled - *reference.core_seat);
}

TEST_CASE("a copy taken in mid-closing goes on with the same bits") {
  Plant one({}, closing_mains(at(40)), closing_options(at(40)));
  one.gate(true);
  one.advance(12.3456e-3, {}, {});
  Plant two = one.copy();
  const std::vector<double> times{13e-3, 15e-3, 20e-3};
  std::vector<PlantSample> a(3), b(3);
  one.advance(20e-3, times, a);
  two.advance(14e-3, std::span(times).first(1), std::span(b).first(1));
  two.advance(20e-3, std::span(times).last(2), std::span(b).last(2));
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(a[k].travel == b[k].travel);
    CHECK(a[k].coil_current == b[k].coil_current);
    CHECK(a[k].force_a == b[k].force_a);
  }
  REQUIRE(one.events().size() == two.events().size());
  for (std::size_t k = 0; k < one.events().size(); ++k) CHECK(one.events()[k].time == two.events()[k].time);
}

TEST_CASE(
    "a static core on buffer springs: very stiff it is the base, and the energy balance holds either way") {
  Specimen rigid;
  Specimen buffered = rigid;
  rigid.base.mass = 0.3;
  buffered.base.mass = 0.15;
  buffered.base.core_mass = 0.15;
  buffered.base.core_hertz = 20'000;
  buffered.base.hertz *= std::sqrt(2.0);  // the same mounting under half of the mass
  buffered.base.damping *= std::sqrt(2.0);
  const auto a = simulate(rigid, at(60), 0.03, 0, 1e-8);
  const auto b = simulate(buffered, at(60), 0.03, 0, 1e-8);
  CHECK(*a.truth.core_seat == Approx(*b.truth.core_seat).margin(5e-6));
  CHECK(b.energy_residual < 1e-5);
  buffered.base.core_hertz = 200;
  const auto soft = simulate(buffered, at(60), 0.03, 0, 1e-9);
  REQUIRE(soft.truth.core_seat);
  CHECK(soft.energy_residual < 1e-6);
  CHECK(std::fabs(*soft.truth.core_seat - *b.truth.core_seat) > 20e-6);
}
