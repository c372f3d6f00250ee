// Cells that flow: hexahedra and tetrahedra share one return map.

#include <catch2/catch.hpp>
#include <functional>
#include <iostream>

#include "bench/solid/impact_cases.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench;
using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

SolidMaterial flowing() {
  SolidMaterial m = material(1e6, 0.25, 1000);
  m.yield = 1200;
  m.hardening = 1e4;
  return m;
}

SolidMesh shape(bool tets) {
  return tets ? tetrahedra_of(distorted_eight()) : seven_hexahedra();
}

/// Logarithmic strains along x, y, z as functions of a parameter 0 .. 1, in `steps`; all cells feel the same.
void stretch(CellBatches& cells, const std::function<Vec3(double)>& strain, int steps,
             const std::function<void(double, const std::vector<CellStress>&)>& see) {
  const SolidMesh& mesh = cells.mesh();
  std::vector<double> u(4 * mesh.nodes.size(), 0.0), v(u);
  const double dt = 1.0 / steps;
  for (int k = 1; k <= steps; ++k) {
    const Vec3 e = strain(k * dt);
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      for (int i = 0; i < 3; ++i) {
        const std::size_t at = 4 * n + static_cast<std::size_t>(i);
        const double now = std::expm1(e[i]) * mesh.nodes[n][i];
        v[at] = (now - u[at]) / dt;
        u[at] = now;
      }
    for (int b = 0; b < cells.count(); ++b) REQUIRE(cells.compute(b, u.data(), v.data(), dt) == -1);
    see(k * dt, cells.stresses(u));
  }
}

}  // namespace

TEST_CASE("patch test of plastic cells: one step of a linear velocity") {
  constexpr double gradient[3][3] = {{1e-3, 4e-4, -2e-4}, {3e-4, -5e-4, 6e-4}, {-1e-4, 2e-4, 7e-4}};
  std::array<CellStress, 2> first;
  for (const bool tets : {false, true}) {
    const SolidMesh mesh = shape(tets);
    CellBatches cells(mesh, {flowing()}, false);
    const auto u = linear_field(mesh, gradient);
    for (int b = 0; b < cells.count(); ++b) REQUIRE(cells.compute(b, u.data(), u.data(), 1.0) == -1);
    double inner = 0, all = 0;
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
      const double f = norm(cells.node_force(n));
      all = std::max(all, f);
      if (tets ? n == 13 : n >= 8) inner = std::max(inner, f);
    }
    std::cout << "patch test, plastic " << (tets ? "tet4" : "hex8") << ": inner force " << inner / all
              << ", stress scatter " << stress_scatter(cells, u) << "\n";
    CHECK(inner < 1e-12 * all);
    CHECK(stress_scatter(cells, u) < 1e-12);
    const auto s = cells.stresses(u);
    first[tets] = s[0];
    CHECK(s[0].plastic > 0);
    CHECK(von_mises(s[0]) == Approx(1200 + 1e4 * s[0].plastic).epsilon(1e-12));  // on the yield surface
  }
  for (std::size_t k = 0; k < 6; ++k) CHECK(first[1].stress[k] == Approx(first[0].stress[k]).epsilon(1e-11));
  CHECK(first[1].plastic == Approx(first[0].plastic).epsilon(1e-11));
}

TEST_CASE("tension of a free bar: elastic to the yield stress, then along the hardening line") {
  // sigma = E e up to Y; then e = sigma / E + e_p, sigma = Y + H e_p; across -nu sigma / E - e_p / 2
  const SolidMaterial m = flowing();
  constexpr double most = 0.05;
  const auto exact = [&](double e) {
    const double flow = std::max(0.0, (m.young * e - m.yield) / (m.young + m.hardening));
    return std::make_pair(m.young * (e - flow), flow);
  };
  for (const bool tets : {false, true}) {
    CellBatches cells(shape(tets), {m}, false);
    double worst = 0, across = 0, strain = 0;
    stretch(
        cells,
        [&](double t) {
          const auto [stress, flow] = exact(most * t);
          const double side = -m.poisson * stress / m.young - 0.5 * flow;
          return Vec3{most * t, side, side};
        },
        2000,
        [&](double t, const std::vector<CellStress>& s) {
          const auto [stress, flow] = exact(most * t);
          for (const auto& c : s) {
            worst = std::max(worst, std::fabs(c.stress[0] - stress) / m.yield);
            across = std::max({across, std::fabs(c.stress[1]) / m.yield, std::fabs(c.stress[2]) / m.yield});
            strain = std::max(strain, std::fabs(c.plastic - flow));
          }
        });
    std::cout << "tension to " << 100 * most << " %, " << (tets ? "tet4" : "hex8") << ": stress off by "
              << worst << " of yield, across " << across << ", plastic strain by " << strain << "\n";
    CHECK(worst < 1e-3);  // the step that crosses the yield stress is one of 2000
    CHECK(across < 1e-3);
    CHECK(strain < 1e-6);
  }
}

TEST_CASE("pressed without room to give way: pressure elastic, deviator on the hardening line") {
  // s_x - s_y = 2 mu e - 3 mu e_p = Y + H e_p, mean stress K e
  const SolidMaterial m = flowing();
  constexpr double most = -0.1;
  for (const bool tets : {false, true}) {
    CellBatches cells(shape(tets), {m}, false);
    double worst = 0;
    stretch(
        cells,
        [&](double t) {
          return Vec3{most * t, 0, 0};
        },
        2000,
        [&](double t, const std::vector<CellStress>& s) {
          const double e = most * t, bulk = m.lambda() + 2.0 / 3 * m.mu();
          const double flow = std::max(0.0, (2 * m.mu() * -e - m.yield) / (3 * m.mu() + m.hardening));
          const double along = bulk * e - 2.0 / 3 * (2 * m.mu() * -e - 3 * m.mu() * flow);
          for (const auto& c : s) worst = std::max(worst, std::fabs(c.stress[0] - along) / m.yield);
        });
    std::cout << "uniaxial strain to " << 100 * most << " %, " << (tets ? "tet4" : "hex8")
              << ": stress off by " << worst << " of yield\n";
    CHECK(worst < 1e-4);
  }
}

TEST_CASE(
    "Taylor bar of tetrahedra beside hexahedra: lengths agree, the foot of four-node cells is stiffer") {
  const auto hex = bench::taylor_bar(2, 20, false, bench::TaylorCells::hexahedra),
             tet = bench::taylor_bar(2, 20, false, bench::TaylorCells::tetrahedra);
  std::cout << "Taylor bar, hex8 / tet4: length " << 1e3 * hex.length << " / " << 1e3 * tet.length
            << " mm, radius of the foot " << 1e3 * hex.radius << " / " << 1e3 * tet.radius
            << " mm, plastic strain " << hex.plastic_strain << " / " << tet.plastic_strain << ", residual "
            << hex.residual << " / " << tet.residual << "\n";
  CHECK(tet.length == Approx(hex.length).epsilon(0.03));
  CHECK(tet.radius < hex.radius);
  CHECK(tet.residual < 0.01);
  CHECK(tet.plastic_strain > 0.5);
}
