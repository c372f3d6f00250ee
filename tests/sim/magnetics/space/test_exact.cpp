#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "bench/space/exact.h"
#include "bench/space/probe.h"
#include "sim/magnetics/space/newton.h"

namespace sim = powbench::sim;
namespace bench = powbench::bench;
using sim::Vec3;

namespace {

constexpr double mu0 = 4e-7 * std::numbers::pi;

/// B_z at a point of concentric shells in a uniform field b0 whose dipole coefficient outside is known.
double ball_solution(const std::vector<double>& radius, std::vector<sim::space::Medium> media, double b0,
                     double dipole, const Vec3& where, int cells,
                     sim::space::Cell cell = sim::space::Cell::hex27, int* iterations = nullptr) {
  sim::space::Problem p;
  p.mesh = bench::ball_mesh(radius, cells, cell);
  p.media = std::move(media);
  p.copies = 8;
  p.fixed = bench::ball_potentials(p.mesh, radius.back(), [&](const Vec3& x) {
    const double r = std::hypot(x[0], x[1], x[2]);
    return -b0 / mu0 * x[2] * (1 - dipole / (r * r * r));
  });
  const sim::space::Coenergy w(p);
  sim::space::Newton newton(w);
  const auto s = newton.solve({});
  REQUIRE(s.converged);
  if (iterations) *iterations = s.iterations;
  return bench::Probe(w, s.state).at(where).b[2];
}

}  // namespace

TEST_CASE("A ball of any permeability holds 3 mu / (mu + 2) of the field around it") {
  for (const double mu : {10.0, 100.0, 1000.0, 10000.0}) {
    CAPTURE(mu);
    const double b = ball_solution({1, 4}, {powbench::bench::linear_medium(mu), sim::space::air()}, 1,
                                   (mu - 1) / (mu + 2), {0.2, 0.15, 0.3}, 3);
    CHECK(b == Approx(3 * mu / (mu + 2)).epsilon(1e-3));
  }
}

TEST_CASE(
    "A steel ball is magnetised to the point of its curve where B + 2 mu0 H = 3 B0, up to deep saturation") {
  for (const char* name : {"team13", "team20", "power"})
    for (const double b0 : {0.001, 0.5, 0.8, 2.0, 4.0}) {
      CAPTURE(name, b0);
      const auto steel = sim::builtin_steel(name);
      const double exact = bench::ball_field(steel, b0);
      const double dipole = (exact / b0 - mu0 * steel.h(exact) / b0) / 3;
      int iterations = 0;
      const double b = ball_solution({1, 4}, {sim::space::solid(steel), sim::space::air()}, b0, dipole,
                                     {0.2, 0.15, 0.3}, 2, sim::space::Cell::hex27, &iterations);
      CHECK(b == Approx(exact).epsilon(5e-3));
      CHECK(iterations <= 25);
    }
}

TEST_CASE("A permeable shell keeps the field from its cavity") {
  for (const double mu : {10.0, 1000.0}) {
    const auto exact = bench::shell_exact(mu, 1, 1.2);
    const double b =
        ball_solution({1, 1.2, 4}, {sim::space::air(), powbench::bench::linear_medium(mu), sim::space::air()},
                      1, exact.dipole, {0.2, 0.15, 0.3}, 3);
    CAPTURE(mu, exact.cavity);
    CHECK(b == Approx(exact.cavity).epsilon(5e-3));
  }
}

TEST_CASE("The inductance of a current sheet is Lorenz's, and converges from above") {
  CHECK(bench::solenoid_inductance(10e-3, 40e-3, 1000) == Approx(0.00807467622).epsilon(1e-8));
  double last = 1e9;
  for (const int cells : {2, 3}) {
    const auto p = bench::solenoid(10e-3, 40e-3, 1000, cells);
    const sim::space::Coenergy w(p);
    sim::space::Newton newton(w);
    const auto s = newton.solve({{false, 1}});
    const double error = s.flux[0] / 0.00807467622 - 1;
    CAPTURE(cells, w.unknowns(), error);
    CHECK(std::fabs(error) < 5e-3);
    CHECK(s.flux[0] < last);
    CHECK(newton.inductance(s.state)[0] == Approx(s.flux[0]).epsilon(1e-10));
    CHECK(2 * s.energy == Approx(s.flux[0]).epsilon(1e-10));
    last = s.flux[0];
  }
}
