// The integrator on systems with exact answers.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "sim/mechanics/unilateral.h"
#include "sim/models/integrator.h"

using namespace powbench::sim;
using powbench::pi;

namespace {

/// Runs to `t_end`; returns the state there.
template <class System>
typename EventIntegrator<System>::State run(EventIntegrator<System>& integrator, double t_end) {
  while (integrator.end() < t_end) REQUIRE(integrator.extend());
  typename EventIntegrator<System>::State s;
  integrator.state(t_end, s);
  return s;
}

struct Oscillator {
  static constexpr int capacity = 2;
  static constexpr int guard_capacity = 1;
  int size() const { return 2; }
  int guard_count() const { return 0; }
  double scale(int) const { return 1; }
  void derivative(double, const double* y, double* dy) const {
    dy[0] = y[1];
    dy[1] = -y[0];
  }
  void guards(double, const double*, double*) const {}
  void flip(double, double*, std::uint64_t) {}
};

/// Rigid bounce with restitution e under gravity.
struct BouncingBall {
  static constexpr int capacity = 2;
  static constexpr int guard_capacity = 1;
  double gravity = 9.81;
  double restitution = 0.5;
  std::vector<double> hits;
  int size() const { return 2; }
  int guard_count() const { return 1; }
  double scale(int) const { return 1; }
  void derivative(double, const double* y, double* dy) const {
    dy[0] = y[1];
    dy[1] = -gravity;
  }
  void guards(double, const double* y, double* g) const { g[0] = y[0]; }
  void flip(double t, double* y, std::uint64_t) {
    hits.push_back(t);
    y[0] = 0;
    y[1] = -restitution * y[1];
  }
};

/// m = k = mu m g = 1: slides, reverses, sticks where the spring cannot overcome friction.
struct CoulombStop {
  static constexpr int capacity = 2;
  static constexpr int guard_capacity = 1;
  double direction = -1;  ///< of motion, 0 = stick
  std::vector<std::pair<double, double>> stops;
  int size() const { return 2; }
  int guard_count() const { return 1; }
  double scale(int) const { return 1; }
  void derivative(double, const double* y, double* dy) const {
    dy[0] = y[1];
    dy[1] = direction == 0 ? 0.0 : -y[0] - direction;
  }
  void guards(double, const double* y, double* g) const {
    g[0] = direction == 0 ? 1 - std::fabs(y[0]) : direction * y[1];
  }
  void flip(double t, double* y, std::uint64_t) {
    y[1] = 0;
    stops.emplace_back(t, y[0]);
    direction = std::fabs(y[0]) <= 1 ? 0 : (y[0] > 0 ? -1 : 1);
  }
};

/// A mass that flies at a wall with a contact that only presses.
struct WallHit {
  static constexpr int capacity = 2;
  static constexpr int guard_capacity = 1;
  Unilateral wall;
  double mass = 1;
  int flips = 0;
  double touched = 0;
  double released = 0;
  int size() const { return 2; }
  int guard_count() const { return 1; }
  double scale(int i) const { return i == 0 ? 1e-4 : 1.0; }
  void derivative(double, const double* y, double* dy) const {
    dy[0] = y[1];
    dy[1] = -wall.force(y[0], y[1]) / mass;
  }
  void guards(double, const double* y, double* g) const { g[0] = wall.guard(y[0], y[1]); }
  void flip(double t, double*, std::uint64_t) {
    wall.pressed = !wall.pressed;
    (wall.pressed ? touched : released) = t;
    ++flips;
  }
};

/// Guards that are given functions of time; records what flips when.
struct Clock {
  static constexpr int capacity = 1;
  static constexpr int guard_capacity = 3;
  std::array<double, 3> zeros{};
  bool grazing = false;
  double depth = 0;
  std::array<bool, 3> done{};
  std::vector<std::pair<double, std::uint64_t>> flips;
  int size() const { return 1; }
  int guard_count() const { return 3; }
  double scale(int) const { return 1; }
  void derivative(double, const double*, double* dy) const { dy[0] = 1; }
  void guards(double, const double* y, double* g) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = y[0] - zeros[k];
      g[k] = done[k] ? 1.0 : (grazing ? d * d - depth : -d);
    }
  }
  void flip(double t, double*, std::uint64_t which) {
    flips.emplace_back(t, which);
    for (std::size_t k = 0; k < 3; ++k)
      if ((which >> k & 1U) != 0) done[k] = true;
  }
};

/// A mode that is wrong again as soon as it has been switched.
struct Chatter {
  static constexpr int capacity = 1;
  static constexpr int guard_capacity = 1;
  long flips = 0;
  int size() const { return 1; }
  int guard_count() const { return 1; }
  double scale(int) const { return 1; }
  void derivative(double, const double*, double* dy) const { dy[0] = 1; }
  void guards(double t, const double*, double* g) const { g[0] = 0.5e-3 - t; }
  void flip(double, double*, std::uint64_t) { ++flips; }
};

}  // namespace

TEST_CASE("oscillator: phase error falls with the tolerance, dense output included") {
  double previous = 1;
  for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
    Oscillator system;
    EventIntegrator<Oscillator> integrator(system, tolerance, 10);
    integrator.restart(0, {1, 0}, 0.1);
    double worst = 0;
    for (int k = 1; k <= 400; ++k) {
      const double t = 0.05 * k;
      const auto s = run(integrator, t);
      worst = std::max({worst, std::fabs(s[0] - std::cos(t)), std::fabs(s[1] + std::sin(t))});
    }
    CAPTURE(tolerance, worst);
    CHECK(worst < 60 * tolerance);
    CHECK(worst < previous / 20);
    previous = worst;
  }
}

TEST_CASE(
    "bouncing ball: hit times are exact, and the infinitely many hits before rest do not stop the clock") {
  BouncingBall ball;
  EventIntegrator<BouncingBall> integrator(ball, 1e-10, 1);
  integrator.restart(0, {1, 0}, 1e-3);
  run(integrator, 1.3545);
  double t = std::sqrt(2 / ball.gravity);
  double v = std::sqrt(2 * ball.gravity);
  REQUIRE(ball.hits.size() >= 12);
  for (std::size_t k = 0; k < 12; ++k) {
    CHECK(ball.hits[k] == Approx(t).margin(1e-9));
    v *= ball.restitution;
    t += 2 * v / ball.gravity;
  }
  const double rest = std::sqrt(2 / ball.gravity) * (1 + 2 * 0.5 / (1 - 0.5));
  const auto past = run(integrator, rest + 1e-6);
  CHECK(std::fabs(past[0]) < 1e-8);
}

TEST_CASE("spring and Coulomb friction: half-cycles of pi, amplitude two less each time, then a real stop") {
  CoulombStop block;
  EventIntegrator<CoulombStop> integrator(block, 1e-11, 1);
  integrator.restart(0, {8.5, 0}, 1e-3);
  const auto s = run(integrator, 100);
  REQUIRE(block.stops.size() == 4);
  const double expected[] = {-6.5, 4.5, -2.5, 0.5};
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(block.stops[k].first == Approx(pi * static_cast<double>(k + 1)).margin(1e-8));
    CHECK(block.stops[k].second == Approx(expected[k]).margin(1e-8));
  }
  CHECK(s[0] == block.stops.back().second);
  CHECK(s[1] == 0);
}

TEST_CASE("impact on a contact that may not pull: rebound ratio against the closed form") {
  for (const double zeta : {0.745, 0.404, 0.246, 0.0709, 0.0}) {
    WallHit hit;
    hit.mass = 9.6e-3;
    hit.wall = Unilateral::with_ratio(6e6, zeta, hit.mass);
    EventIntegrator<WallHit> integrator(hit, 1e-11, 1e-3);
    integrator.restart(0, {-1e-4, 0.5}, 1e-6);
    const auto s = run(integrator, 1e-3);
    CAPTURE(zeta);
    CHECK(hit.flips == 2);
    CHECK(hit.touched == Approx(2e-4).epsilon(1e-10));
    CHECK(-s[1] / 0.5 == Approx(rebound_ratio(zeta)).epsilon(1e-8));
    const double b = std::asin(zeta);
    const double omega = std::sqrt(6e6 / hit.mass) * std::cos(b);
    CHECK(hit.released - hit.touched == Approx((pi - 2 * b) / omega).epsilon(1e-8));
  }
}

TEST_CASE("simultaneous events switch together, whatever the order of the guards") {
  for (const auto& zeros :
       {std::array{0.3, 0.3, 0.7}, std::array{0.7, 0.3, 0.3}, std::array{0.3, 0.7, 0.3}}) {
    Clock clock;
    clock.zeros = zeros;
    EventIntegrator<Clock> integrator(clock, 1e-9, 10);
    integrator.restart(0, {0}, 10);
    run(integrator, 2);
    REQUIRE(clock.flips.size() == 2);
    CHECK(clock.flips[0].first == Approx(0.3).margin(1e-14));
    CHECK(clock.flips[1].first == Approx(0.7).margin(1e-14));
    for (std::size_t k = 0; k < 3; ++k) CHECK(((clock.flips[0].second >> k & 1U) != 0) == (zeros[k] == 0.3));
  }
}

TEST_CASE("a guard that dips below zero and back inside one step is found") {
  Clock clock;
  clock.zeros = {0.487, 5, 5};
  clock.grazing = true;
  clock.depth = 1e-8;
  EventIntegrator<Clock> integrator(clock, 1e-9, 10);
  integrator.restart(0, {0}, 1.0);
  run(integrator, 1);
  REQUIRE_FALSE(clock.flips.empty());
  CHECK(clock.flips[0].first == Approx(0.487 - 1e-4).margin(1e-12));
}

TEST_CASE("a mode that can never be right costs a bounded number of events") {
  Chatter chatter;
  EventIntegrator<Chatter> integrator(chatter, 1e-9, 1e-3);
  integrator.restart(0, {0}, 1e-3);
  run(integrator, 60e-3);
  CHECK(chatter.flips > 10);
  CHECK(chatter.flips < 20000);
}
