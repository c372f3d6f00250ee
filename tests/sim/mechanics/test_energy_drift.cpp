// Where energy would leak: a million undamped steps, and the steps that end in an event.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "bench/mechanics/chain.h"
#include "bench/mechanics/reference_closing.h"
#include "sim/mechanics/rigid_contactor.h"

namespace {

using namespace powbench::sim;
using Contactor = RigidContactor<double>;

struct Drift {
  double worst = 0, seconds = 0;
  long events = 0;
};

Drift drift(double tolerance, long steps) {
  Contactor c(powbench::bench::without_losses(powbench::bench::reference_closing()), {}, true);
  alignas(64) double y[EventSolver<Contactor>::capacity] = {};
  c.equilibrium(y);
  c.mark_energy(y);
  const auto solver = std::make_unique<EventSolver<Contactor>>(c, tolerance, 1e-3);
  solver->restart(0, y, 1e-6);
  Drift d;
  while (solver->steps() < steps) {
    REQUIRE(solver->extend());
    if (solver->steps() % 16 == 0) d.worst = std::max(d.worst, c.energy_residual(solver->end_state()));
    c.events().clear();
  }
  d.seconds = solver->end();
  d.events = static_cast<long>(solver->events());
  return d;
}

}  // namespace

TEST_CASE("energy of a bouncing ball over a million undamped steps", "[mechanics]") {
  Chain<double, 1> ball;
  ball.mass = {5e-3};
  ball.force = {-4};
  ball.law.stiffness = 1e8;
  ball.wall = true;
  EventSolver solver(ball, 1e-14, 1e-3);
  const double y[] = {1e-4, -0.3};
  solver.restart(0, y, 1e-6);
  const double start = ball.energy(y);
  double worst = 0;
  while (solver.steps() < 1000000) {
    REQUIRE(solver.extend());
    if (solver.steps() % 16 == 0)
      worst = std::max(worst, std::fabs(ball.energy(solver.end_state()) / start - 1));
  }
  std::printf("  %lld steps, %d impacts, %.1f s: largest energy residual %.1e\n",
              static_cast<long long>(solver.steps()), ball.touches, static_cast<double>(solver.end()), worst);
  CHECK(ball.touches > 5000);
  CHECK(worst < 1e-9);
}

TEST_CASE("undamped contactor: what 50 000 steps lose or gain follows the tolerance", "[mechanics]") {
  for (const double tolerance : {1e-10, 1e-12}) {
    const auto d = drift(tolerance, 50000);
    std::printf("  50000 steps of the contactor at %.0e: %ld events, %.2f s, residual %.1e\n", tolerance,
                d.events, d.seconds, d.worst);
    CHECK(d.events > 500);
    CHECK(d.worst < 100 * tolerance);
  }
}

TEST_CASE("undamped contactor: residual below 1e-9 over a million steps", "[mechanics][.slow]") {
  const auto d = drift(1e-12, 1000000);
  std::printf("  1000000 steps of the contactor at 1e-12: %ld events, %.2f s, residual %.1e\n", d.events,
              d.seconds, d.worst);
  CHECK(d.events > 10000);
  CHECK(d.worst < 1e-9);
}

TEST_CASE("a touch costs no energy, although the step that found it went beyond", "[mechanics]") {
  // taken from the dense output, each touch of the reference closing costs about 1e-9 J at this tolerance
  Contactor c(powbench::bench::reference_closing(), {}, true);
  alignas(64) double y[EventSolver<Contactor>::capacity] = {};
  c.equilibrium(y);
  const auto solver = std::make_unique<EventSolver<Contactor>>(c, 1e-8, 1e-3);
  solver->restart(0, y, 1e-6);
  const auto total = [&](const double* s) {
    const auto e = c.energies(s);
    return e.stored() + e.lost() - e.supplied;
  };
  double before = total(y);
  double in_touches = 0;
  int touches = 0;
  while (solver->end() < 0.06) {
    REQUIRE(solver->extend());
    const double now = total(solver->end_state());
    const std::uint64_t pending = solver->memory().pending & ((std::uint64_t{1} << rigid_contacts) - 1);
    if (pending != 0 && !c.is_pressing(c.number_of(__builtin_ctzll(pending)))) {
      in_touches += std::fabs(now - before);
      ++touches;
    }
    before = now;
  }
  std::printf("  %d touches change the energy by %.1e J in all\n", touches, in_touches);
  CHECK(touches > 80);
  CHECK(in_touches < 1e-10);
}

TEST_CASE("one guard alone has the value and the rate that it has among all", "[mechanics]") {
  Contactor c(powbench::bench::reference_closing(), {}, true);
  alignas(64) double y[EventSolver<Contactor>::capacity] = {};
  c.equilibrium(y);
  const auto solver = std::make_unique<EventSolver<Contactor>>(c, 1e-8, 1e-3);
  solver->restart(0, y, 1e-6);
  int moving = 0;
  for (const double until : {2e-3, 10e-3, 15e-3, 25e-3}) {
    while (solver->end() < until) REQUIRE(solver->extend());
    const double* state = solver->end_state();
    EventSolver<Contactor>::GuardSet all{};
    c.guards(solver->end(), state, nullptr, all);
    for (int k = 0; k < rigid_contacts; ++k) {
      double rate = -1;
      const double value = c.guard(k, solver->end(), state, rate);
      if (all.value[k] == 1 && all.rate[k] == 0) continue;  // an idle lane
      CHECK(value == Approx(all.value[k]).margin(1e-15));
      CHECK(rate == Approx(all.rate[k]).margin(1e-12));
      moving += std::fabs(all.rate[k]) > 1e-3;
    }
  }
  CHECK(moving > 20);
}

TEST_CASE("samples within a step that a release has cut lie on the motion", "[mechanics]") {
  // in the followed contact's own variable, time runs backwards beyond the release
  Chain<double, 1> ball;
  ball.mass = {5e-3};
  ball.law.stiffness = 1e8;
  ball.wall = true;
  EventSolver solver(ball, 1e-9, 1e-3);
  const double y[] = {1e-6, -0.5};
  solver.restart(0, y, 1e-6);
  double worst = 0;
  while (ball.times.size() < 2) {
    REQUIRE(solver.extend());
    alignas(64) double s[EventSolver<Chain<double, 1>>::capacity] = {};
    double x = 0, v = 0;
    const double h = (solver.end() - solver.begin()) / 100;
    for (int k = 0; k <= 100; ++k) {
      solver.state(solver.begin() + k * h, s);
      constexpr double fastest = 1.4e4;  // m/s2: the peak force over the mass
      if (k > 0) worst = std::max(worst, std::fabs(s[0] - x - v * h) - fastest * h * h / 2);
      x = s[0];
      v = s[1];
    }
  }
  CHECK(worst < 1e-12);
}
