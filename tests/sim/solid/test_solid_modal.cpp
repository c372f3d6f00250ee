#include <catch2/catch.hpp>
#include <iostream>

#include "bench/solid/impact_cases.h"
#include "core/units.h"
#include "sim/solid/modal_body.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

TEST_CASE("a free beam's modes: six rigid ones, then Euler and Bernoulli's") {
  SolidMesh mesh;
  const double h = 1e-3, length = 40e-3;
  add_box(mesh, mesh.add_part("beam"), {0, 0, 0}, {length, 1.2 * h, h}, 40, 3, 4);
  SolidMaterial m = material(2.1e11, 0.3, 7850);
  const ModalBody body = reduce(mesh, m, 4, {});
  REQUIRE(body.modes() == 10);
  for (int r = 0; r < 6; ++r) CHECK(body.omega[static_cast<std::size_t>(r)] == 0);
  const double scale = std::sqrt(m.young / (12 * m.density)) / (length * length);
  const double flat = 4.73004074 * 4.73004074 * scale * h, edge = 4.73004074 * 4.73004074 * scale * 1.2 * h;
  std::cout << "free beam: modes at " << body.omega[6] / flat - 1 << " and " << body.omega[7] / edge - 1
            << " from Euler-Bernoulli\n";
  CHECK(body.omega[6] == Approx(flat).epsilon(0.015));
  CHECK(body.omega[7] == Approx(edge).epsilon(0.015));
  // orthonormal in the masses
  const CellBatches cells(mesh, {m}, false);
  for (int r = 0; r < body.modes(); ++r)
    for (int s = 0; s <= r; ++s) {
      double product = 0;
      for (int n = 0; n < body.nodes; ++n)
        product += cells.masses()[static_cast<std::size_t>(n)] * dot(body.shape(r, n), body.shape(s, n));
      CHECK(product == Approx(r == s ? 1.0 : 0.0).margin(1e-9));
    }
}

TEST_CASE("a reduced bridge lands like the finite elements it comes from: force within 3 %") {
  const auto with = powbench::bench::bridge_on_pads({2, 6}, true);
  const auto without = powbench::bench::bridge_on_pads({2}, false);
  for (const auto& r : with)
    std::cout << "bridge on pads, " << r.modes << " modes: force within " << 100 * r.worst
              << " % of the peak, impulse " << 100 * r.impulse_error << " %, explicit takes " << r.cpu_ratio
              << " times the CPU\n";
  CHECK(with[0].worst < 0.03);
  CHECK(with[1].worst < 0.01);
  CHECK(without[0].worst > 0.05);  // as many elastic modes without attachment modes are not enough
}

TEST_CASE("reducing asks for one part and a sensible number of modes") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {1, 1, 1}, 1, 1, 1);
  CHECK_THROWS_WITH(reduce(mesh, SolidMaterial{}, 100, {}), Catch::Contains("modes = 100"));
  CHECK_THROWS_AS(reduce(mesh, SolidMaterial{}, -1, {}), std::invalid_argument);
}
