#include <catch2/catch.hpp>
#include <cmath>

#include "bench/space/exact.h"
#include "sim/magnetics/space/grid.h"
#include "sim/magnetics/space/newton.h"
#include "sim/magnetics/space/winding.h"

namespace sim = powbench::sim;
using sim::Vec3;
using sim::space::Cell;

TEST_CASE("Shape functions sum to one, are one at their node, and their slopes are derivatives") {
  for (const auto cell : {Cell::hex8, Cell::hex20, Cell::hex27, Cell::tet4, Cell::tet10}) {
    const auto& rule = sim::space::cell_rule(cell);
    std::vector<double> value, up, down;
    std::vector<Vec3> slope, unused;
    for (int a = 0; a < rule.nodes; ++a) {
      sim::space::cell_shape(cell, rule.node[a], value, slope);
      for (int b = 0; b < rule.nodes; ++b) CHECK(value[b] == Approx(a == b).margin(1e-14));
    }
    const Vec3 at{0.21, 0.17, 0.33};
    sim::space::cell_shape(cell, at, value, slope);
    double sum = 0;
    for (const double v : value) sum += v;
    CHECK(sum == Approx(1));
    for (int k = 0; k < 3; ++k) {
      Vec3 high = at, low = at;
      high[k] += 1e-5;
      low[k] -= 1e-5;
      sim::space::cell_shape(cell, high, up, unused);
      sim::space::cell_shape(cell, low, down, unused);
      for (int a = 0; a < rule.nodes; ++a)
        CHECK(slope[a][k] == Approx((up[a] - down[a]) / 2e-5).margin(1e-9));
    }
    double volume = 0;
    for (const double w : rule.weight) volume += w;
    CHECK(volume == Approx(cell == Cell::tet4 || cell == Cell::tet10 ? 1.0 / 6 : 8.0));
  }
}

TEST_CASE("A graded line holds its marks, its sizes and its growth") {
  const std::vector<sim::space::GridMark> marks{{0, 0.1}, {1, 0.02}, {1.05, 0.02}, {7, 2}};
  const auto line = sim::space::graded_line(marks, 1.6, 1.5);
  for (const auto& m : marks) CHECK(std::count(line.begin(), line.end(), m.at) == 1);
  for (std::size_t k = 2; k < line.size(); ++k) {
    const double ratio = (line[k] - line[k - 1]) / (line[k - 1] - line[k - 2]);
    CHECK(ratio < 1.6 * 1.5);
    CHECK(ratio > 1 / (1.6 * 1.5));
  }
  CHECK_THROWS_WITH(sim::space::graded_line({{0, 1}, {0, 1}}, 1.5, 1),
                    Catch::Contains("mark 1 at 0.000000 m does not lie above"));
  CHECK_THROWS_WITH(sim::space::graded_line({{0, 1}, {1, 0}}, 1.5, 1),
                    Catch::Contains("size 0.000000 of mark 1"));
}

TEST_CASE("Joined meshes share the nodes of their faces") {
  const auto all = [](const Vec3&) { return 0; };
  for (const auto cell : {Cell::hex8, Cell::hex20, Cell::hex27}) {
    const auto whole = sim::space::grid_mesh({0, 1, 2}, {0, 1}, {0, 1}, cell, all);
    const auto left = sim::space::grid_mesh({0, 1}, {0, 1}, {0, 1}, cell, all);
    const auto right = sim::space::grid_mesh({1, 2}, {0, 1}, {0, 1}, cell, all);
    CHECK(powbench::bench::join_meshes({left, right}, 1e-9).nodes.size() == whole.nodes.size());
  }
}

TEST_CASE("A ring of iron in a close coil: exact mmf over iron and gap, for every kind of hexahedron") {
  // a bar between two walls of infinite permeability: H_fe l_fe + H_gap l_gap = N I, B equal in both
  const double iron = 0.1, gap = 0.002, area = 1e-4, turns = 500;
  for (const auto cell : {Cell::hex8, Cell::hex20, Cell::hex27}) {
    sim::space::Problem p;
    p.mesh = sim::space::grid_mesh({0, 0.005, 0.01}, {0, 0.01}, {0, 0.05, iron, iron + gap}, cell,
                                   [&](const Vec3& c) { return c[2] < iron ? 1 : 0; });
    const auto steel = sim::builtin_steel("team20");
    p.media = {sim::space::air(), sim::space::solid(steel)};
    p.windings = {[=](const Vec3&) -> Vec3 { return {0, 0, turns / (iron + gap)}; }};
    for (std::size_t n = 0; n < p.mesh.nodes.size(); ++n)
      if (p.mesh.nodes[n][2] == 0 || p.mesh.nodes[n][2] == iron + gap)
        p.fixed.emplace_back(static_cast<int>(n), 0.0);
    const sim::space::Coenergy w(p);
    sim::space::Newton newton(w);
    const double psi = 1.7 * area * turns;
    const auto s = newton.solve({{true, psi}});
    REQUIRE(s.converged);
    const double mmf = steel.h(1.7) * iron + 1.7 / (4e-7 * M_PI) * gap;
    CHECK(s.state.current[0] == Approx(mmf / turns).epsilon(1e-9));
    CHECK(s.energy ==
          Approx(area * (steel.energy(1.7) * iron + 0.5 * 1.7 * 1.7 / (4e-7 * M_PI) * gap)).epsilon(1e-9));
    CHECK(newton.solve({{false, mmf / turns}}).flux[0] == Approx(psi).epsilon(1e-9));
  }
}

TEST_CASE("Coils without section and cells turned inside out are refused") {
  CHECK_THROWS_AS(sim::space::coil_field({0, 0, 1, 1, 0, 0, 0, 1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(sim::space::coil_field({0, 0, 1, 1, 2, 1, 0, 1, 1}), std::invalid_argument);
  sim::space::Problem p;
  p.mesh = sim::space::grid_mesh({0, 1}, {0, 1}, {0, 1}, Cell::hex8, [](const Vec3&) { return 0; });
  p.media = {sim::space::air()};
  std::swap(p.mesh.cells[0], p.mesh.cells[1]);
  std::swap(p.mesh.cells[2], p.mesh.cells[3]);
  std::swap(p.mesh.cells[4], p.mesh.cells[5]);
  std::swap(p.mesh.cells[6], p.mesh.cells[7]);
  CHECK_THROWS_WITH(sim::space::Coenergy(p), Catch::Contains("cell 0 is flat or turned inside out"));
  p.mesh.region[0] = 3;
  CHECK_THROWS_WITH(sim::space::Coenergy(p), Catch::Contains("region 3 of the mesh, allowed 0 .. 0"));
}
