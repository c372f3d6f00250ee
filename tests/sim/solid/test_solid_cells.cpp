#include <catch2/catch.hpp>
#include <iostream>

#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

/// Largest force on an inner node (8 .. 15, of the tetrahedra 13) relative to the largest at all, after all batches
/// have been computed.
double inner_force(CellBatches& cells, const std::vector<double>& u, bool tets) {
  for (int b = 0; b < cells.count(); ++b) REQUIRE(cells.compute(b, u.data(), u.data(), 0) == -1);
  double inner = 0, all = 0;
  for (int n = 0; n < static_cast<int>(cells.mesh().nodes.size()); ++n) {
    const double f = norm(cells.node_force(n));
    all = std::max(all, f);
    if (tets ? n == 13 : n >= 8) inner = std::max(inner, f);
  }
  return inner / all;
}

constexpr double gradient[3][3] = {{1e-3, 4e-4, -2e-4}, {3e-4, -5e-4, 6e-4}, {-1e-4, 2e-4, 7e-4}};

}  // namespace

TEST_CASE(
    "patch test: a linear displacement leaves inner nodes without force and all cells with one stress") {
  for (const bool small : {true, false})
    for (const bool tets : {false, true}) {
      SolidMaterial m = material(1e6, 0.25, 1000);
      m.small_displacement = small;
      const SolidMesh mesh = tets ? tetrahedra_of(distorted_eight()) : seven_hexahedra();
      CellBatches cells(mesh, {m}, false);
      const auto u = linear_field(mesh, gradient);
      const double force = inner_force(cells, u, tets), stress = stress_scatter(cells, u);
      std::cout << "patch test, " << (tets ? "tet4" : "hex8") << (small ? ", linear" : ", neo-Hookean")
                << ": inner force " << force << ", stress scatter " << stress << "\n";
      CHECK(force < 1e-12);
      CHECK(stress < 1e-12);
      CHECK(cells.energies(0, u).hourglass < 1e-24 * cells.energies(0, u).strain);
    }
}

TEST_CASE("a rotation of any size strains nothing: no stress, no hourglass energy") {
  const SolidMesh mesh = seven_hexahedra();
  CellBatches cells(mesh, {material(1e6, 0.25, 1000)}, false);
  const double c = std::cos(1.0), s = std::sin(1.0);
  const double turn[3][3] = {{c - 1, -s, 0}, {s, c - 1, 0}, {0, 0, 0}};
  const auto u = linear_field(mesh, turn);
  for (int b = 0; b < cells.count(); ++b) REQUIRE(cells.compute(b, u.data(), u.data(), 0) == -1);
  for (int n = 0; n < 16; ++n) CHECK(norm(cells.node_force(n)) < 1e-12 * 1e6);
  CHECK(cells.energies(0, u).hourglass < 1e-25 * 1e6);
  CHECK(std::fabs(cells.energies(0, u).strain) < 1e-14 * 1e6);
}

TEST_CASE("forces are the derivative of the energy, hourglass modes included") {
  const SolidMesh mesh = seven_hexahedra();
  CellBatches cells(mesh, {material(1e6, 0.3, 1000)}, false);
  std::vector<double> u(4 * mesh.nodes.size(), 0.0);
  for (std::size_t k = 0; k < u.size(); ++k)
    if (k % 4 != 3) u[k] = 0.03 * std::sin(1.7 * static_cast<double>(k) + 0.3);
  for (int b = 0; b < cells.count(); ++b) REQUIRE(cells.compute(b, u.data(), u.data(), 0) == -1);
  const auto energy = [&](const std::vector<double>& at) {
    const auto e = cells.energies(0, at);
    return e.strain + e.hourglass;
  };
  double worst = 0, size = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) {
      auto up = u, down = u;
      up[4 * n + i] += 1e-5;
      down[4 * n + i] -= 1e-5;
      const double f = cells.node_force(static_cast<int>(n))[static_cast<int>(i)];
      worst = std::max(worst, std::fabs(f + (energy(up) - energy(down)) / 2e-5));
      size = std::max(size, std::fabs(f));
    }
  std::cout << "force against derivative of energy: " << worst / size << "\n";
  CHECK(worst < 2e-8 * size);
}

TEST_CASE("the volume of a hexahedron is exact and its gradient is its derivative") {
  std::array<Vec3, 8> x{Vec3{0, 0, 0}, {1, .1, 0}, {1.2, 1, .1}, {0, .9, -.1},
                        {.1, 0, 1},    {1, 0, .8}, {1, 1.3, 1},  {-.1, 1, 1.1}};
  const HexShape s = hex_shape(x);
  // two Gauss points a direction integrate the Jacobian of a trilinear cell exactly
  double volume = 0;
  for (int q = 0; q < 8; ++q) {
    const double g = 1 / std::sqrt(3.0), r[3] = {q & 1 ? g : -g, q & 2 ? g : -g, q & 4 ? g : -g};
    Vec3 d[3];
    for (int a = 0; a < 8; ++a) {
      const double n[3] = {hex_sign(0, a), hex_sign(1, a), hex_sign(2, a)};
      for (int i = 0; i < 3; ++i)
        d[i] += 0.125 * n[i] * (1 + n[(i + 1) % 3] * r[(i + 1) % 3]) * (1 + n[(i + 2) % 3] * r[(i + 2) % 3]) *
                x[static_cast<std::size_t>(a)];
    }
    volume += dot(d[0], cross(d[1], d[2]));
  }
  CHECK(s.volume == Approx(volume).epsilon(1e-14));
  const auto b = hex_gradient(s);
  for (std::size_t a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      auto up = x, down = x;
      up[a][i] += 1e-3;
      down[a][i] -= 1e-3;
      CHECK(b[a][i] ==
            Approx((hex_shape(up).volume - hex_shape(down).volume) / 2e-3).epsilon(1e-9).margin(1e-12));
    }
}

TEST_CASE("forces in float follow those in double, far from the origin too") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0.05, 0, 0}, {0.06, 0.01, 0.01}, 5, 5, 5);
  CellBatches precise(mesh, {material(2e11, 0.3, 7850)}, false),
      coarse(mesh, {material(2e11, 0.3, 7850)}, true);
  std::vector<double> u(4 * mesh.nodes.size(), 0.0);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) u[4 * n + i] = 4e-3 + 1e-6 * std::sin(static_cast<double>(3 * n + i));
  double worst = 0, size = 0;
  for (int b = 0; b < precise.count(); ++b) {
    REQUIRE(precise.compute(b, u.data(), u.data(), 0) == -1);
    REQUIRE(coarse.compute(b, u.data(), u.data(), 0) == -1);
  }
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    worst = std::max(worst, norm(precise.node_force(n) - coarse.node_force(n)));
    size = std::max(size, norm(precise.node_force(n)));
  }
  std::cout << "float against double forces, 4 mm away from rest: " << worst / size << "\n";
  CHECK(worst < 2e-6 * size);
}

TEST_CASE("bad cells, materials and parts are refused in one sentence") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {1, 1, 1}, 1, 1, 2);
  SolidMesh flipped = mesh;
  std::swap(flipped.cells[1].nodes[0], flipped.cells[1].nodes[2]);
  CHECK_THROWS_WITH(CellBatches(flipped, {SolidMaterial{}}, false), Catch::Contains("mesh cell 1"));
  SolidMaterial heavy;
  heavy.density = -1;
  CHECK_THROWS_WITH(CellBatches(mesh, {heavy}, false), Catch::Contains("density") && Catch::Contains("> 0"));
  CHECK_THROWS_WITH(known_material("cheese"), Catch::Contains("cheese") && Catch::Contains("copper"));
  SolidMesh shared = mesh;
  shared.add_part("other");
  shared.cells[1].part = 1;
  CHECK_THROWS_WITH(CellBatches(shared, {SolidMaterial{}, SolidMaterial{}}, false),
                    Catch::Contains("two parts"));
}
