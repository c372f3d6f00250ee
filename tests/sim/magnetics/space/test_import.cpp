#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "bench/space/exact.h"
#include "sim/magnetics/space/grid.h"
#include "sim/magnetics/space/import.h"
#include "sim/magnetics/space/newton.h"

namespace sim = powbench::sim;
using sim::Vec3;
using sim::space::Cell;

namespace {

/// A mesh as gmsh writes it, lengths in mm; region r is the physical volume 10 + r.
std::string as_msh(const sim::space::Mesh& mesh, int type) {
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 2\n";
  for (int r = 0; r < 2; ++r)
    text += std::to_string(r + 1) + " 0 0 0 1 1 1 1 " + std::to_string(10 + r) + " 0\n";
  const auto nodes = std::to_string(mesh.nodes.size());
  text += "$EndEntities\n$Nodes\n1 " + nodes + " 1 " + nodes + "\n3 1 0 " + nodes + "\n";
  for (std::size_t n = 1; n <= mesh.nodes.size(); ++n) text += std::to_string(n) + "\n";
  for (const auto& n : mesh.nodes)
    text += std::to_string(n[0] * 1e3) + " " + std::to_string(n[1] * 1e3) + " " + std::to_string(n[2] * 1e3) +
            "\n";
  const auto count = std::to_string(mesh.count());
  text += "$EndNodes\n$Elements\n2 " + count + " 1 " + count + "\n";
  const int per = mesh.per_cell();
  for (int r = 0; r < 2; ++r) {
    text += "3 " + std::to_string(r + 1) + " " + std::to_string(type) + " " +
            std::to_string(std::count(mesh.region.begin(), mesh.region.end(), r)) + "\n";
    for (int c = 0; c < mesh.count(); ++c) {
      if (mesh.region[c] != r) continue;
      text += std::to_string(c + 1);
      for (int a = 0; a < per; ++a) text += " " + std::to_string(mesh.cells[c * per + a] + 1);
      text += "\n";
    }
  }
  return text + "$EndElements\n";
}

/// Each cube cut into six tetrahedra round the diagonal from its first to its seventh corner.
sim::space::Mesh tetrahedra(const sim::space::Mesh& cubes) {
  constexpr int cut[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                             {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  sim::space::Mesh out;
  out.cell = Cell::tet4;
  out.nodes = cubes.nodes;
  for (int c = 0; c < cubes.count(); ++c)
    for (const auto& t : cut) {
      for (const int a : t) out.cells.push_back(cubes.cells[c * 8 + a]);
      out.region.push_back(cubes.region[c]);
    }
  return out;
}

/// Flux through a bar of two layers between z = 0 and z = 0.02 at potentials 0 and -1000 A.
double flux_of(const sim::space::Mesh& mesh) {
  sim::space::Problem p;
  p.mesh = mesh;
  p.media = {powbench::bench::linear_medium(50), sim::space::air()};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (mesh.nodes[n][2] < 1e-9) p.fixed.emplace_back(static_cast<int>(n), 0.0);
    if (mesh.nodes[n][2] > 0.02 - 1e-9) p.fixed.emplace_back(static_cast<int>(n), -1000.0);
  }
  const sim::space::Coenergy w(p);
  sim::space::Newton newton(w);
  return 2 * newton.solve({}).coenergy / 1000;
}

}  // namespace

TEST_CASE("An imported mesh gives the flux of the mesh it was made of, in hexahedra and tetrahedra") {
  const double exact = 1000 / (0.01 / (50 * 4e-7 * M_PI * 1e-4) + 0.01 / (4e-7 * M_PI * 1e-4));
  for (const auto& [cell, type] :
       {std::pair{Cell::hex8, 5}, std::pair{Cell::hex20, 17}, std::pair{Cell::hex27, 12}}) {
    const auto mesh = sim::space::grid_mesh({0, 0.004, 0.01}, {0, 0.01}, {0, 0.005, 0.01, 0.02}, cell,
                                            [](const Vec3& c) { return c[2] > 0.01 ? 1 : 0; });
    const auto read = sim::space::import_mesh(sim::read_msh(as_msh(mesh, type)), 1e-3, {{10, 0}, {11, 1}});
    CHECK(read.cell == cell);
    CHECK(flux_of(read) == Approx(exact).epsilon(1e-9));
    if (cell != Cell::hex8) continue;
    const auto tets =
        sim::space::import_mesh(sim::read_msh(as_msh(tetrahedra(mesh), 4)), 1e-3, {{10, 0}, {11, 1}});
    CHECK(tets.count() == 6 * mesh.count());
    CHECK(flux_of(tets) == Approx(exact).epsilon(1e-9));
  }
}

TEST_CASE("Imported meshes that do not fit are refused") {
  const auto mesh = sim::space::grid_mesh({0, 1}, {0, 1}, {0, 1, 2}, Cell::hex8,
                                          [](const Vec3& c) { return c[2] > 1 ? 1 : 0; });
  const auto read = sim::read_msh(as_msh(mesh, 5));
  CHECK_THROWS_WITH(sim::space::import_mesh(read, 1e-3, {{10, 0}}),
                    "mesh: volume 2 belongs to none of the physical groups that have a medium");
  CHECK_THROWS_WITH(sim::space::import_mesh(read, 0, {{10, 0}, {11, 1}}), Catch::Contains("allowed above 0"));
  auto mixed = read;
  mixed.blocks[1].nodes_per_element = 4;
  CHECK_THROWS_WITH(sim::space::import_mesh(mixed, 1, {{10, 0}, {11, 1}}), Catch::Contains("two kinds"));
  CHECK_THROWS_WITH(sim::space::import_mesh({}, 1, {}), Catch::Contains("no tetrahedra or hexahedra"));
}
