// Multi-body problems with exact or published answers.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <vector>

#include "bench/mechanics/friction.h"
#include "bench/mechanics/smooth.h"
#include "tests/sim/mechanics/zeno.h"

namespace {

using namespace powbench::sim;

template <class System>
void run_to(EventSolver<System>& solver, double end, double* y) {
  while (solver.end() < end) REQUIRE(solver.extend());
  alignas(64) double wide[EventSolver<System>::capacity] = {};
  solver.state(end, wide);
  std::copy_n(wide, System::capacity, y);
}

}  // namespace

TEST_CASE("pendulum released horizontally: position after 10 s and energy", "[mechanics]") {
  Smooth<2> pendulum;
  pendulum.rate = [](double, const double* y, double* dy) {
    dy[0] = y[1];
    dy[1] = -9.81 * std::sin(y[0]);
  };
  EventSolver solver(pendulum, 1e-13, 0.1);
  double y[2] = {std::acos(-1.0) / 2, 0};
  solver.restart(0, y, 1e-3);
  run_to(solver, 10, y);
  const double drift = std::fabs(y[1] * y[1] / 2 - 9.81 * std::cos(y[0])) / 9.81;
  std::printf("  pendulum: |x| %.10f, y %.10f, energy drift %.1e\n", std::fabs(std::sin(y[0])),
              -std::cos(y[0]), drift);
  CHECK(std::fabs(std::sin(y[0])) == Approx(0.2750874626).margin(1e-9));
  CHECK(-std::cos(y[0]) == Approx(-0.9614192051).margin(1e-9));
  CHECK(drift < 1e-11);
}

TEST_CASE("spring and Coulomb stop: half cycles, then rest for ever", "[mechanics]") {
  Smooth<2> block;
  FrictionMode mode = FrictionMode::backward;
  std::vector<double> stops;
  block.rate = [&](double, const double* y, double* dy) {
    dy[0] = y[1];
    dy[1] = -y[0] + friction_force(mode, -y[0], 1);
    if (mode == FrictionMode::stick) dy[1] = 0;
  };
  block.positive = [&](double, const double* y) { return friction_guard(mode, y[1], -y[0], 1); };
  block.at_zero = [&](double& t, double* y) {
    stops.push_back(t);
    y[1] = 0;
    mode = after_stop(-y[0], 1);
  };
  EventSolver solver(block, 1e-13, 1);
  double y[2] = {8.5, 0};
  solver.restart(0, y, 1e-3);
  run_to(solver, 100, y);
  CAPTURE(stops.size(), y[0]);
  REQUIRE(mode == FrictionMode::stick);
  std::printf("  Coulomb stop: at t - 4 pi = %.1e, x - 0.5 = %.1e at t = 100, speed %.1e\n",
              stops.back() - 4 * std::acos(-1.0), y[0] - 0.5, y[1]);
  CHECK(std::fabs(stops.back() - 4 * std::acos(-1.0)) < 1e-9);
  CHECK(std::fabs(y[0] - 0.5) < 1e-9);
  CHECK(y[1] == 0.0);
}

TEST_CASE("return map: rests within Fc / kt, and tangential damping takes the ringing out", "[mechanics]") {
  for (const double kt : {1e4, 1e6}) {
    double speed[2] = {};
    for (const bool damped : {false, true}) {
      ReturnMap map;
      map.stiffness = kt;
      map.damping = damped ? std::sqrt(kt) : 0;  // half of critical
      const double h = 1e-4;
      double x = 8.5;
      double v = 0;
      double force = 0;
      for (long i = 0; i < 1000000; ++i) {
        v += h * (-x + force);
        x += h * v;
        force = map.step(h * v, v, 1);
        if (i > 900000) speed[damped] = std::max(speed[damped], std::fabs(v));
      }
      CHECK(std::fabs(x - 0.5) < 20 / kt + 1e-3);
    }
    std::printf("  return map, kt %.0e: rest speed %.1e without, %.1e with tangential damping\n", kt,
                speed[0], speed[1]);
    CHECK(speed[1] < 1e-12);
    CHECK(speed[0] > 1e3 * speed[1]);
  }
}

TEST_CASE("friction that falls exponentially with speed: stop time and distance", "[mechanics]") {
  const FrictionLaw law{0.3, 0.2, 20};
  CHECK(law.coefficient(0) == Approx(0.3));
  Smooth<2> block;
  double stop = 0;
  block.rate = [&](double, const double* y, double* dy) {
    dy[0] = stop > 0 ? 0.0 : y[1];
    dy[1] = stop > 0 ? 0.0 : -9.81 * law.coefficient(y[1]);
  };
  block.positive = [&](double, const double* y) { return stop > 0 ? 1.0 : y[1]; };
  block.at_zero = [&](double& t, double* y) {
    stop = t;
    y[1] = 0;
  };
  EventSolver solver(block, 1e-12, 0.1);
  double y[2] = {0, 1};
  solver.restart(0, y, 1e-4);
  run_to(solver, 1, y);
  const double a = 0.2 * 9.81;
  const double b = 0.1 * 9.81;
  const double exact = std::log((a * std::exp(20.0) + b) / (a + b)) / (a * 20);
  std::printf("  exponential friction: stop %.8f s, error %.1e; distance %.8f m\n", stop, stop - exact, y[0]);
  CHECK(std::fabs(stop - exact) < 1e-9 * exact);
  CHECK(stop == Approx(0.49935104).margin(1e-8));
  CHECK(y[0] == Approx(0.25427062).margin(1e-8));
}

namespace {

/// A ball under a constant acceleration and a rigid law. Once the impacts accumulate it jumps to their limit.
struct BouncingBall : NoRoots<double> {
  static constexpr int capacity = 2;
  static constexpr int guard_capacity = 8;
  using GuardSet = Guards<double, guard_capacity>;
  double restitution = 0.5;
  double acceleration = 9.81;
  ZenoWatch<double> watch{0.5, 1e-6};
  bool closed = false;

  int size() const { return 2; }
  int guard_count() const { return 1; }
  int smooth_guards() const { return 1; }
  double scale(int) const { return 1; }
  void derivative(double, const double* y, double* dy) const {
    dy[0] = closed ? 0.0 : y[1];
    dy[1] = closed ? 0.0 : -acceleration;
  }
  void guards(double, const double* y, const double* dy, GuardSet& g) const {
    g.value[0] = closed ? 1.0 : y[0];
    g.rate[0] = closed ? 0.0 : y[1];
    if (dy != nullptr) g.curve[0] = closed ? 0.0 : dy[1];
  }
  double guard(int, double, const double* y, double& rate) const {
    rate = y[1];
    return y[0];
  }
  void flip(double& t, double* y, std::uint64_t) {
    y[1] = -restitution * y[1];
    y[0] = 0;
    if (!watch.impact(t, y[1], acceleration)) return;
    t = watch.limit();
    y[1] = 0;
    closed = true;
  }
};

double settles(double height, double speed, double e, double a, int& impacts, bool& held) {
  BouncingBall ball;
  ball.restitution = e;
  ball.acceleration = a;
  ball.watch = ZenoWatch<double>(e, 1e-6);
  EventSolver solver(ball, 1e-13, 1);
  const double y[2] = {height, speed};
  solver.restart(0, y, 1e-4);
  double end = 0;
  while (!ball.closed) {
    REQUIRE(solver.extend());
    end = solver.end();
  }
  end = ball.watch.limit();
  impacts = ball.watch.impacts();
  for (int i = 0; i < 5; ++i) REQUIRE(solver.extend());
  held = solver.end_state()[0] == 0.0;  // it does not fall through the floor
  return end;
}

}  // namespace

TEST_CASE("accumulating impacts of a rigid law end at the analytic limit", "[mechanics]") {
  int impacts = 0;
  bool held = false;
  const double drop = settles(1, 0, 0.5, 9.81, impacts, held);
  const double exact = std::sqrt(2 / 9.81) * (1 + 2 * 0.5 / (1 - 0.5));
  std::printf("  Zeno: limit %.9f s, error %.1e, after %d impacts\n", drop, drop - exact, impacts);
  CHECK(std::fabs(drop - exact) < 1e-10);
  CHECK(drop == Approx(1.3545709).margin(1e-7));
  CHECK(held);
  const double pad = settles(1e-12, -0.6, 0.7, 800, impacts, held);
  CHECK(std::fabs(pad - 3.5e-3) < 1e-10);
  CHECK(held);
}

TEST_CASE("rocking block: time to the first impact and the loss in it", "[mechanics]") {
  const double b = 0.01;
  const double h = 0.03;
  const double alpha = std::atan(b / h);
  const double p = std::sqrt(3 * 9.81 / (4 * std::hypot(b, h)));
  CHECK(p == Approx(15.25335).epsilon(1e-6));
  const double ratio = 1 - 1.5 * std::sin(alpha) * std::sin(alpha);
  CHECK(ratio == Approx(0.85));
  Smooth<2> block;
  double side = 1;
  std::vector<double> impacts;
  std::vector<double> speeds;
  block.rate = [&](double, const double* y, double* dy) {
    dy[0] = y[1];
    dy[1] = p * p * (y[0] - side * alpha);
  };
  block.positive = [&](double, const double* y) { return side * y[0]; };
  block.at_zero = [&](double& t, double* y) {
    impacts.push_back(t);
    speeds.push_back(y[1]);
    y[1] *= ratio;
    side = -side;
  };
  EventSolver solver(block, 1e-13, 0.1);
  double y[2] = {alpha / 2, 0};
  solver.restart(0, y, 1e-4);
  run_to(solver, 0.5, y);
  REQUIRE(impacts.size() >= 2);
  const double quarter = std::acosh(1 / (1 - 0.5)) / p;
  CHECK(std::fabs(impacts[0] - quarter) < 1e-9 * quarter);
  CHECK(4 * quarter == Approx(0.3453558).margin(1e-7));
  CHECK(std::fabs(speeds[1] / speeds[0]) == Approx(ratio).epsilon(1e-9));
}

TEST_CASE("a rod that jams against its sliding direction stays finite", "[mechanics]") {
  // half length l, mass 1, inertia l^2 / 3, tip on the floor at the angle theta. The friction acts against the slip.
  const double l = 0.5;
  const auto critical = [](double angle) {
    const double c = std::cos(angle);
    return (1 + 3 * c * c) / (3 * std::sin(angle) * c);
  };
  CHECK(critical(std::atan(2.0)) == Approx(4.0 / 3));
  const auto largest_force = [&](double mu) {
    Smooth<6> rod;  // x, y, theta and their rates
    double peak = 0;
    const auto forces = [&](const double* y, double& normal, double& tangent) {
      const double depth = l * std::sin(y[2]) - y[1];
      const double depth_rate = l * std::cos(y[2]) * y[5] - y[4];
      const double slip = y[3] + l * std::sin(y[2]) * y[5];
      normal = depth > 0 ? std::max(0.0, 1e7 * depth * std::sqrt(depth) * (1 + 0.5 * depth_rate)) : 0.0;
      tangent = -mu * normal * std::clamp(slip / 1e-3, -1.0, 1.0);
    };
    rod.rate = [&](double, const double* y, double* dy) {
      double normal = 0;
      double tangent = 0;
      forces(y, normal, tangent);
      dy[0] = y[3];
      dy[1] = y[4];
      dy[2] = y[5];
      dy[3] = tangent;
      dy[4] = normal - 9.81;
      // the tip lies at (-l cos, -l sin) from the middle; a positive turn sinks it
      dy[5] = 3 / (l * l) * (-l * std::cos(y[2]) * normal + l * std::sin(y[2]) * tangent);
    };
    rod.tolerance_scale = 1e-2;
    EventSolver solver(rod, 1e-9, 1e-3);
    const double angle = std::atan(2.0);
    double y[6] = {0, l * std::sin(angle), angle, -2, 0, 0};
    y[1] -= std::pow(9.81 / 4e7, 2.0 / 3);
    solver.restart(0, y, 1e-6);
    double before = 1e300;
    while (solver.end() < 0.02) {
      REQUIRE(solver.extend());
      const double* s = solver.end_state();
      for (int i = 0; i < 6; ++i) REQUIRE(std::isfinite(s[i]));
      double normal = 0;
      double tangent = 0;
      forces(s, normal, tangent);
      peak = std::max(peak, normal);
      const double depth = std::max(0.0, l * std::sin(s[2]) - s[1]);
      const double energy = (s[3] * s[3] + s[4] * s[4] + l * l / 3 * s[5] * s[5]) / 2 + 9.81 * s[1] +
                            0.4e7 * depth * depth * std::sqrt(depth);
      REQUIRE(energy < before + 1e-6);
      before = energy;
    }
    return peak;
  };
  const double below = largest_force(1.0);
  const double above = largest_force(1.6);
  std::printf("  rod on a rough floor: largest force %.1f N at mu 1.0, %.1f N at mu 1.6 (jams)\n", below,
              above);
  CHECK(above > 4 * below);
}
