#include <catch2/catch.hpp>

#include "bench/field3d/team13.h"
#include "sim/field3d/newton3.h"

namespace sim = powbench::sim;
namespace bench = powbench::bench;

namespace {

double psi_above(const sim::Problem3& p, double current) {
  const sim::Coenergy3 w(p);
  sim::Newton3 newton(w);
  return newton.solve({{false, current}}).flux[0];
}

}  // namespace

TEST_CASE("Scalar and vector potential enclose the flux linkage of a coil in air") {
  auto above = bench::team13(8);
  above.media = {sim::air(), sim::air()};
  auto below = bench::team13_edges(8);
  below.steel = [](const sim::Vec3&) { return false; };
  const auto low = bench::solve_edges(below, 1000);
  CHECK(low.converged);
  CHECK(low.iterations <= 2);  // linear
  const double high = psi_above(above, 1000);
  CHECK(low.psi < high);
  CHECK(low.psi > 0.8 * high);
}

TEST_CASE("Scalar and vector potential enclose the flux linkage of TEAM 13 and close in on it", "[.slow]") {
  double before = 1;
  for (const double size : {5.0, 2.5}) {
    const auto low = bench::solve_edges(bench::team13_edges(size), 1000);
    CHECK(low.converged);
    CHECK(low.iterations <= 25);
    const double high = psi_above(bench::team13(size), 1000);
    CAPTURE(size, low.psi, high);
    CHECK(low.psi < high);
    CHECK(high / low.psi - 1 < before);
    before = high / low.psi - 1;
  }
}
