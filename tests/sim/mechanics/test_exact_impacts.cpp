// Impacts with known answers: every number is exact or recomputed from a closed form, and none depends on a step.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/mechanics/chain.h"
#include "core/units.h"

namespace {

using namespace powbench::sim;

/// Runs until `stop` s or until every contact has been left again.
template <class System>
void run(System& system, EventSolver<System>& solver, double stop) {
  while (static_cast<double>(solver.end()) < stop) REQUIRE(solver.extend());
  (void)system;
}

struct Rebound {
  double duration = 0, speed = 0, deepest = 0;
};

/// One mass against a wall with the speed v: an impact from 1 um away.
Rebound impact(const ContactLaw& law, double mass, double v, double tolerance) {
  Chain<double, 1> ball;
  ball.mass = {mass};
  ball.law = law;
  ball.wall = true;
  EventSolver<Chain<double, 1>> solver(ball, tolerance, 1e-3);
  const double y[] = {1e-6, -v};
  solver.restart(0, y, 1e-6);
  Rebound r;
  while (ball.times.size() < 2) {
    REQUIRE(solver.extend());
    double state[16];
    for (int k = 0; k <= 200; ++k) {
      solver.state(solver.begin() + (solver.end() - solver.begin()) * k / 200, state);
      r.deepest = std::max(r.deepest, -state[0]);
    }
  }
  r.duration = ball.times[1] - ball.times[0];
  r.speed = solver.end_state()[1];
  return r;
}

/// Largest depth of a mass m that arrives with v: ((n + 1) m v^2 / (2 k))^(1/(n + 1)), without damping.
double largest_depth(const ContactLaw& law, double mass, double speed) {
  const double p = law.exponent + 1;
  return std::pow(p * mass * speed * speed / (2 * law.stiffness), 1 / p);
}

/// Duration of an undamped impact: 2 d_max / (v (n + 1)) B(1/(n + 1), 1/2).
double contact_time(const ContactLaw& law, double mass, double speed) {
  const double p = law.exponent + 1;
  const double beta = std::exp(std::lgamma(1 / p) - std::lgamma(1 / p + 0.5)) * std::sqrt(powbench::pi);
  return 2 * largest_depth(law, mass, speed) / (speed * p) * beta;
}

}  // namespace

TEST_CASE("Hertz impact: duration, depth and rebound to 1e-9", "[mechanics]") {
  for (const double n : {1.0, 1.5, 2.0}) {
    ContactLaw law;
    law.stiffness = 1e8;
    law.exponent = n;
    const auto r = impact(law, 5e-3, 0.5, 1e-11);
    const double tc = contact_time(law, 5e-3, 0.5);
    const double dt = std::fabs(r.duration / tc - 1);
    const double dv = std::fabs(r.speed / 0.5 - 1);
    std::printf("  Hertz n = %.1f: Tc %.4f us, relative error of Tc %.1e, of the rebound %.1e\n", n, tc * 1e6,
                dt, dv);
    CHECK(dt < 1e-9);
    CHECK(dv < 1e-9);
    CHECK(r.deepest == Approx(largest_depth(law, 5e-3, 0.5)).epsilon(1e-4));
  }
  ContactLaw hertz;
  CHECK(contact_time(hertz, 5e-3, 0.5) == Approx(280.1489e-6).epsilon(1e-6));
  CHECK(largest_depth(hertz, 5e-3, 0.5) == Approx(47.5913e-6).epsilon(2e-6));
  hertz.exponent = 1;
  CHECK(contact_time(hertz, 5e-3, 0.5) == Approx(22.2144e-6).epsilon(1e-6));
  hertz.exponent = 2;
  CHECK(contact_time(hertz, 5e-3, 0.5) == Approx(1490.04e-6).epsilon(1e-5));
}

TEST_CASE("steel sphere on steel half-space", "[mechanics]") {
  const double radius = 10e-3;
  const double mass = 4.0 / 3 * powbench::pi * radius * radius * radius * 7850;
  ContactLaw law;
  law.stiffness = 4.0 / 3 * 210e9 / (2 * (1 - 0.09)) * std::sqrt(radius);
  CHECK(largest_depth(law, mass, 1) == Approx(23.4808e-6).epsilon(1e-5));
  CHECK(elastic_force(law, largest_depth(law, mass, 1)) == Approx(1750.47).epsilon(1e-5));
  const auto r = impact(law, mass, 1, 1e-11);
  CHECK(r.duration == Approx(69.110e-6).epsilon(1e-5));
}

TEST_CASE("Hunt-Crossley restitution follows its closed form, not 1 - 2/3 lambda v", "[mechanics]") {
  const double table[][2] = {{0.1, 0.937476}, {0.3, 0.832870}, {0.6, 0.711950}, {1, 0.593624}, {2, 0.410720}};
  for (const auto& row : table) {
    const double exact = hunt_crossley_restitution(row[0]);
    CHECK(exact == Approx(row[1]).margin(6e-7));
    for (const double n : {1.0, 1.5, 2.0})
      for (const double k : {1e6, 1e10}) {
        ContactLaw law{k, n, DampingForm::hunt_crossley, row[0] / 0.4, 0};
        const double e = impact(law, 3e-3, 0.4, 1e-11).speed / 0.4;
        CAPTURE(row[0], n, k, e - exact);
        CHECK(std::fabs(e - exact) < 1e-9);
      }
  }
}

TEST_CASE("Lankarani-Nikravesh and Flores take their damping from the speed of the touch", "[mechanics]") {
  // both are Hunt-Crossley with lambda v0 = 3 (1 - e^2) / 4 and 8 (1 - e) / (5 e), whatever the speed
  for (const double e : {0.9, 0.6}) {
    for (const double v : {0.05, 0.8}) {
      const auto lankarani =
          impact({1e8, 1.5, DampingForm::lankarani_nikravesh, e, 0}, 5e-3, v, 1e-11).speed / v;
      const auto flores = impact({1e8, 1.5, DampingForm::flores, e, 0}, 5e-3, v, 1e-11).speed / v;
      CHECK(std::fabs(lankarani - hunt_crossley_restitution(0.75 * (1 - e * e))) < 1e-9);
      CHECK(std::fabs(flores - hunt_crossley_restitution(1.6 * (1 - e) / e)) < 1e-9);
    }
  }
}

TEST_CASE("cradles of 3 and 5 equal bodies", "[mechanics]") {
  const auto cradle = [](auto& chain, double n, const double* exact, double bar) {
    constexpr int bodies = std::remove_reference_t<decltype(chain)>::capacity / 2;
    for (auto& m : chain.mass) m = 1;
    chain.law.stiffness = 1;
    chain.law.exponent = n;
    chain.size_scale = 1;
    EventSolver solver(chain, 1e-13, 1.0);
    double y[2 * bodies] = {};
    y[bodies] = 1;
    solver.restart(0, y, 1e-3);
    run(chain, solver, 60);
    double worst = 0;
    for (int i = 0; i < bodies; ++i)
      worst = std::max(worst, std::fabs(static_cast<double>(solver.end_state()[bodies + i]) - exact[i]));
    std::printf("  cradle of %d, n = %.1f: largest error %.1e\n", bodies, n, worst);
    CHECK(worst < bar);
  };
  // the references carry eight to nine digits
  const double three[] = {-0.07095235, 0.07640304, 0.99454931};
  const double five[] = {-0.07108502, -0.03027376, -0.01446363, 0.12704499, 0.98877742};
  const double linear[] = {-0.1302617, 0.15022957, 0.98003213};
  Chain<double, 3> a;
  cradle(a, 1.5, three, 6e-9);
  Chain<double, 5> b;
  cradle(b, 1.5, five, 6e-9);
  Chain<double, 3> c;
  cradle(c, 1, linear, 6e-8);
}
