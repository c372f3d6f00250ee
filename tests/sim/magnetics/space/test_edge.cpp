#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/space/edge_space.h"
#include "bench/space/team13.h"
#include "sim/magnetics/space/newton.h"

namespace sim = powbench::sim;
namespace bench = powbench::bench;

namespace {

double psi_above(const sim::space::Problem& p, double current) {
  const sim::space::Coenergy w(p);
  sim::space::Newton newton(w);
  return newton.solve({{false, current}}).flux[0];
}

/// Curls at 125 points, one row a function: how many rows are independent.
int rank_of_curls(const bench::EdgeSpace& space, const sim::Vec3& size) {
  std::vector<std::vector<double>> rows(space.functions().size());
  std::vector<sim::Vec3> curls;
  for (int q = 0; q < 125; ++q) {
    space.curls(size, {0.2 * (q % 5), 0.2 * (q / 5 % 5) + 0.1, 0.2 * (q / 25) + 0.05}, curls);
    for (std::size_t n = 0; n < rows.size(); ++n)
      rows[n].insert(rows[n].end(), {curls[n].x, curls[n].y, curls[n].z});
  }
  int rank = 0;
  for (;; ++rank) {
    std::size_t best = 0, column = 0;
    for (std::size_t n = 0; n < rows.size(); ++n)
      for (std::size_t c = 0; c < rows[n].size(); ++c)
        if (std::fabs(rows[n][c]) > std::fabs(rows[best][column])) best = n, column = c;
    if (std::fabs(rows[best][column]) < 1e-9) return rank;
    const auto pivot = rows[best];
    for (auto& r : rows) {
      const double f = r[column] / pivot[column];
      for (std::size_t c = 0; c < r.size(); ++c) r[c] -= f * pivot[c];
    }
  }
}

}  // namespace

TEST_CASE("Scalar and vector potential enclose the flux linkage of a coil in air") {
  auto above = bench::team13(8);
  above.media = {sim::space::air(), sim::space::air()};
  const double high = psi_above(above, 1000);
  double before = 0.75 * high;
  for (const int order : {1, 2}) {
    auto p = bench::team13_edges(8, order);  // on fewer bricks, in a box that also keeps the flux linkage low
    p.x = {0, 0.05, 0.075, 0.1, 0.2, 0.6};
    p.y = {-0.6, -0.2, -0.1, -0.075, -0.05, 0, 0.05, 0.075, 0.1, 0.2, 0.6};
    p.z = {0, 0.05, 0.2, 0.6};
    p.steel = [](const sim::Vec3&) { return false; };
    bench::EdgeField below(p);
    const auto low = below.solve(1000);
    CHECK(low.converged);
    CHECK(low.iterations <= 2);  // linear
    CAPTURE(order);
    CHECK(low.psi < high);
    CHECK(low.psi > before);
    before = low.psi;
  }
  CHECK(before > 0.95 * high);
}

TEST_CASE("Only the gradients of corner functions are left among the edge functions of a brick") {
  const std::vector<double> x{0, 0.7}, y{-1, 1}, z{0, 0.4};
  for (const int order : {1, 2}) {
    const bench::EdgeSpace space(order, x, y, z);
    // fields div B = 0 of the full space: its functions less the gradients of all nodal functions but the constant
    const int nodes = (order + 1) * (order + 1) * (order + 1), full = 3 * order * (order + 1) * (order + 1);
    CHECK(static_cast<int>(space.functions().size()) == full - (nodes - 8));
    CHECK(rank_of_curls(space, {0.7, 2, 0.4}) == full - (nodes - 1));
  }
}

TEST_CASE("Scalar and vector potential enclose the flux linkage of TEAM 13 and close in on it", "[.slow]") {
  const double high[] = {psi_above(bench::team13(8), 1000), psi_above(bench::team13(5), 1000)};
  CHECK(high[1] < high[0]);
  double before = 1;
  for (const int order : {1, 2}) {
    bench::EdgeField below(bench::team13_edges(8, order));
    const auto low = below.solve(1000);
    CHECK(low.converged);
    CHECK(low.iterations <= 25);
    CAPTURE(order, low.psi, high[order - 1]);
    CHECK(low.psi < high[1]);
    CHECK(high[order - 1] / low.psi - 1 < before);
    before = high[order - 1] / low.psi - 1;
  }
  CHECK(before < 0.03);
}
