// The fall-back for settled phases that are stiff.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/mechanics/reference_closing.h"
#include "bench/mechanics/smooth.h"
#include "sim/mechanics/bounce_error.h"
#include "sim/mechanics/stiff_solver.h"
#include "sim/models/rigid_run.h"

using namespace powbench::sim;

TEST_CASE("the Rosenbrock method keeps its tolerance on a stiff equation with a few hundred steps",
          "[mechanics]") {
  // y' = -1e6 (y - cos t): exact y = (cos t + 1e-6 sin t) / (1 + 1e-12) from a start on it; z' = y z
  for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
    Smooth<2> system;
    system.rate = [](double t, const double* y, double* dy) {
      dy[0] = -1e6 * (y[0] - std::cos(t));
      dy[1] = y[0] * y[1];
    };
    StiffSolver<Smooth<2>> solver(system, tolerance);
    alignas(64) double y[StiffSolver<Smooth<2>>::capacity] = {1, 1};
    double t = 0;
    double h = 1e-6;
    int steps = 0;
    while (t < 2) {
      REQUIRE(solver.step(t, y, h, 2 - t, 1e-9));
      ++steps;
    }
    const double exact = std::exp(std::sin(2.0) + 1e-6 * (1 - std::cos(2.0)));
    const double error = std::fabs(y[1] - exact);
    std::printf("  Rosenbrock at %.0e: %d steps, error %.1e\n", tolerance, steps, error);
    CHECK(std::fabs(y[0] - std::cos(2.0) - 1e-6 * std::sin(2.0)) < tolerance + 1e-9);
    CHECK(error < 10 * tolerance);
    CHECK(steps < 3000);  // an explicit method needs a million
  }
}

TEST_CASE("seats so damped that the settled phase is stiff: same events, a fraction of the work",
          "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  parts.seat = {5e5, 1, DampingForm::linear, 2e4, 0};
  RigidOptions o;
  o.tolerance = 1e-7;
  o.ledger = false;
  o.end = 0.0256;  // up to the first touches
  const auto with = run_rigid(parts, {}, o);
  o.stiff_fallback = false;
  const auto without = run_rigid(parts, {}, o);
  REQUIRE(with.completed);
  REQUIRE(without.completed);
  std::printf("  stiff seats: %lld evaluations with the fall-back (%lld steps), %lld without\n",
              static_cast<long long>(with.evaluations), static_cast<long long>(with.stiff_steps),
              static_cast<long long>(without.evaluations));
  CHECK(with.stiff_steps > 10);
  CHECK(with.evaluations < without.evaluations / 3);
  const auto e = bounce_error(with.events, without.events, o.end);
  CHECK(e.reference > 0);
  CHECK(e.all());
  CHECK(e.largest_dt < 1e-6);
}

TEST_CASE("the reference closing never needs the fall-back", "[mechanics]") {
  RigidOptions o;
  o.ledger = false;
  const auto run = run_rigid(powbench::bench::reference_closing(), {}, o);
  CHECK(run.stiff_steps == 0);
}
