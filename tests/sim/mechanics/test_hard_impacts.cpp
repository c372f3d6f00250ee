// Hard cases of impacts: grazing, extreme stiffness and mass ratio, denormal depths, and sequences
// that nobody can compute.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/mechanics/chain.h"
#include "bench/mechanics/reference_closing.h"
#include "sim/mechanics/bounce_error.h"
#include "sim/models/rigid_run.h"

using namespace powbench::sim;

TEST_CASE("mass ratio 1e4 at k = 1e10 without damping: the elastic formula holds", "[mechanics]") {
  for (const bool heavy_first : {true, false}) {
    Chain<double, 2> pair;
    pair.mass = heavy_first ? std::array<double, 2>{1.0, 1e-4} : std::array<double, 2>{1e-4, 1.0};
    pair.law.stiffness = 1e10;
    EventSolver solver(pair, 1e-12, 1e-3);
    const double y[] = {0, 1e-5, 1, 0};
    solver.restart(0, y, 1e-7);
    while (pair.times.size() < 2) REQUIRE(solver.extend());
    const double total = pair.mass[0] + pair.mass[1];
    CHECK(std::fabs(solver.end_state()[2] - (pair.mass[0] - pair.mass[1]) / total) < 1e-9);
    CHECK(std::fabs(solver.end_state()[3] - 2 * pair.mass[0] / total) < 2e-9);
  }
}

TEST_CASE("a touch 1e-12 m deep inside one step is neither missed nor invented", "[mechanics]") {
  for (const double depth : {1e-12, -1e-12}) {
    Chain<double, 1> ball;
    ball.mass = {1};
    ball.force = {2};  // gap(t) = (t - t0)^2 - depth
    ball.law.stiffness = 1e3;
    ball.wall = true;
    EventSolver solver(ball, 1e-10, 1.0);
    const double t0 = 0.3721;
    const double y[] = {t0 * t0 - depth, -2 * t0};
    solver.restart(0, y, 0.1);
    while (solver.end() < 1) REQUIRE(solver.extend());
    CAPTURE(depth, ball.times.size());
    if (depth < 0) {
      CHECK(ball.times.empty());
    } else {
      REQUIRE(ball.times.size() == 2);
      CHECK(ball.times[0] == Approx(t0 - 1e-6).margin(1e-9));
      CHECK(ball.times[1] == Approx(t0 + 1e-6).margin(1e-8));
    }
  }
}

TEST_CASE("denormal depths and speeds neither stall nor spoil a run", "[mechanics]") {
  Chain<double, 1> ball;
  ball.mass = {5e-3};
  ball.wall = true;
  ball.law = {1e8, 1.5, DampingForm::hunt_crossley, 0.6, 0};
  EventSolver solver(ball, 1e-9, 1e-3);
  const double y[] = {3e-310, -2e-305};
  solver.restart(0, y, 1e-6);
  for (int i = 0; i < 200; ++i) {
    REQUIRE(solver.extend());
    REQUIRE(std::isfinite(solver.end_state()[0]));
    REQUIRE(std::isfinite(solver.end_state()[1]));
  }
  CHECK(solver.end() > 1e-3);
  CHECK(std::fabs(solver.end_state()[0]) < 1e-300);
}

TEST_CASE("a pad that rests on its damped contact settles instead of chattering", "[mechanics]") {
  Chain<double, 1> ball;
  ball.mass = {5e-3};
  ball.force = {-4};
  ball.wall = true;
  ball.law = {1e8, 1.5, DampingForm::hunt_crossley, 3, 0};
  EventSolver solver(ball, 1e-8, 1e-3);
  const double y[] = {1e-3, 0};
  solver.restart(0, y, 1e-6);
  while (solver.end() < 0.5) REQUIRE(solver.extend());
  CHECK(solver.evaluations() < 200000);
  CHECK(-solver.end_state()[0] == Approx(std::pow(4e-8, 2.0 / 3)).epsilon(0.05));
}

namespace {

std::vector<RigidEvent> close(const RigidParts& parts, double tolerance) {
  RigidOptions o;
  o.tolerance = tolerance;
  o.ledger = false;
  const auto run = run_rigid(parts, {}, o);
  REQUIRE(run.completed);
  return run.events;
}

}  // namespace

TEST_CASE("condition of the reference closing by a twin run", "[mechanics]") {
  const auto base = close(powbench::bench::reference_closing(), 1e-11);
  auto changed = powbench::bench::reference_closing();
  changed.core_mass *= 1 + 1e-8;
  const auto c = bounce_condition(close(changed, 1e-11), base, 1e-8, 0.06);
  std::printf("  condition: %.4f s of event time per unit of relative mass\n", c.per_input);
  CHECK_FALSE(c.diverged);
  CHECK(c.per_input > 5e-3);
  CHECK(c.per_input < 5e-2);
}

TEST_CASE("k = 1e10: the run ends, but its bounces are not computable and the numbers say so",
          "[mechanics]") {
  const auto base = close(powbench::bench::reference_closing(100), 1e-8);
  auto changed = powbench::bench::reference_closing(100);
  changed.core_mass *= 1 + 1e-8;
  const auto twin = close(changed, 1e-8);
  const auto e = bounce_error(twin, base, 0.06);
  std::printf("  k x 100: %d of %d events agree, until %.2f ms; contact states differ for %.2f ms\n",
              e.matched, e.reference, e.diverged_at * 1e3, e.distance * 1e3);
  CHECK_FALSE(e.all());
  CHECK(e.diverged_at > 0.0275);
  CHECK(e.diverged_at < 0.045);
  CHECK(e.distance > 1e-5);
  const auto a = bounce_summary(base, 0);
  const auto b = bounce_summary(twin, 0);
  CHECK(a.first_touch == Approx(b.first_touch).epsilon(1e-4));
  CHECK(a.open_time > 0);
}

TEST_CASE("bounce errors of made-up sequences", "[mechanics]") {
  const std::vector<RigidEvent> reference = {
      {0, true, 1e-3, 1}, {0, false, 2e-3, 1}, {0, true, 3e-3, 1}, {8, true, 2.5e-3, 1}};
  auto moved = reference;
  moved[1].time += 1e-6;
  auto e = bounce_error(moved, reference, 0.01);
  CHECK(e.all());
  CHECK(e.largest_dt == Approx(1e-6));
  CHECK(e.distance == Approx(1e-6));
  // a grazing touch more: the prefix ends there, the states hardly differ
  moved.push_back({8, false, 5e-3, 1e-6});
  moved.push_back({8, true, 5e-3 + 1e-9, 1e-6});
  e = bounce_error(moved, reference, 0.01);
  CHECK(e.matched == 4);
  CHECK(e.diverged_at == Approx(5e-3));
  CHECK(e.distance == Approx(1e-6));
  const auto s = spread({3, 1, 2, 5, 4});
  CHECK(s.mean == Approx(3));
  CHECK(s.median == Approx(3));
  CHECK(s.low == Approx(1.2));
  CHECK(s.high == Approx(4.8));
}
