// Solid bodies from meshes drawn elsewhere.

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>

#include "sim/solid/explicit_solid.h"
#include "sim/solid/import_solid.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;

namespace {

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

/// A mesh as gmsh writes it, lengths as they stand; part p is volume p + 1 in the physical volume 10 + p.
std::string as_msh(const SolidMesh& mesh, const std::string& names = "") {
  const auto parts = mesh.parts.size();
  std::string text =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + names + "$Entities\n0 0 0 " + std::to_string(parts) + "\n";
  for (std::size_t p = 0; p < parts; ++p)
    text += std::to_string(p + 1) + " 0 0 0 1 1 1 1 " + std::to_string(10 + p) + " 0\n";
  const auto nodes = std::to_string(mesh.nodes.size()), cells = std::to_string(mesh.cells.size());
  text += "$EndEntities\n$Nodes\n1 " + nodes + " 1 " + nodes + "\n3 1 0 " + nodes + "\n";
  for (std::size_t n = 1; n <= mesh.nodes.size(); ++n) text += std::to_string(n) + "\n";
  for (const auto& n : mesh.nodes) text += number(n.x) + " " + number(n.y) + " " + number(n.z) + "\n";
  text += "$EndNodes\n$Elements\n" + std::to_string(2 * parts) + " " + cells + " 1 " + cells + "\n";
  for (std::size_t p = 0; p < parts; ++p)
    for (const int corners : {4, 8}) {
      std::string list;
      int count = 0;
      for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto& cell = mesh.cells[c];
        if (cell.part != static_cast<int>(p) || cell.corners() != corners) continue;
        list += std::to_string(c + 1);
        for (int k = 0; k < corners; ++k)
          list += " " + std::to_string(cell.nodes[static_cast<std::size_t>(k)] + 1);
        list += "\n";
        ++count;
      }
      text +=
          "3 " + std::to_string(p + 1) + (corners == 4 ? " 4 " : " 5 ") + std::to_string(count) + "\n" + list;
    }
  return text + "$EndElements\n";
}

/// A copper bridge above a pad: two bricks that do not touch, lengths in m.
SolidMesh two_bricks() {
  SolidMesh m;
  add_box(m, m.add_part("bridge"), {0, 0, 1.1e-3}, {6e-3, 2e-3, 2e-3}, 6, 2, 2);
  add_box(m, m.add_part("pad"), {0, 0, 0}, {2e-3, 2e-3, 1e-3}, 2, 2, 2);
  return m;
}

std::vector<double> after_a_fall(const SolidMesh& mesh) {
  ExplicitSolid solid(mesh, {known_material("copper"), known_material("copper")});
  solid.set_contact({{{0, 1}}});
  solid.set_velocity(0, {0, 0, -5});
  for (int k = 0; k < 500; ++k) solid.step();
  return solid.displacements();
}

}  // namespace

TEST_CASE("an imported mesh moves as the one it was made of, to the bit", "[import]") {
  const SolidMesh made = two_bricks();
  const SolidMesh read = import_solid_mesh(
      read_msh(as_msh(made, "$PhysicalNames\n2\n3 10 \"bridge\"\n3 11 \"pad\"\n$EndPhysicalNames\n")), 1);
  CHECK(read.parts == made.parts);
  REQUIRE(read.cells.size() == made.cells.size());
  CHECK(after_a_fall(read) == after_a_fall(made));
}

TEST_CASE("tetrahedra and hexahedra may be mixed, lengths have a unit, unused nodes are left out",
          "[import]") {
  SolidMesh mixed = two_bricks();
  const SolidMesh tets = cases::tetrahedra_of(mixed);
  std::erase_if(mixed.cells, [](const SolidCell& c) { return c.part == 1; });
  for (const auto& c : tets.cells)
    if (c.part == 1) mixed.cells.push_back(c);
  for (auto& n : mixed.nodes) n = 1e3 * n;
  mixed.nodes.push_back({7, 7, 7});
  const SolidMesh read = import_solid_mesh(read_msh(as_msh(mixed)), 1e-3);
  CHECK(read.parts == std::vector<std::string>{"volume 10", "volume 11"});
  CHECK(read.nodes.size() == mixed.nodes.size() - 1);
  double volume[2] = {0, 0};
  for (const auto& c : read.cells) volume[c.part] += cell_volume(read, c);
  CHECK(volume[0] == Approx(6e-3 * 2e-3 * 0.9e-3).epsilon(1e-12));
  CHECK(volume[1] == Approx(2e-3 * 2e-3 * 1e-3).epsilon(1e-12));
}

TEST_CASE("meshes that are no bodies are refused in one sentence", "[import]") {
  const auto refuses = [](const MshMesh& m, double metres, const char* why) {
    CHECK_THROWS_WITH(import_solid_mesh(m, metres), Catch::Contains(why));
  };
  const MshMesh good = read_msh(as_msh(two_bricks()));
  refuses(good, 0, "allowed above 0");
  refuses(good, 1e3, "is the unit of the file right?");
  refuses(good, 1e-3, "mm long, allowed 0.1 .. 1000");
  refuses({}, 1, "no tetrahedra or hexahedra");
  MshMesh wrong = good;
  wrong.blocks.front().groups.clear();
  wrong.blocks[1].groups.clear();
  refuses(wrong, 1, "belongs to no physical volume");
  wrong = good;
  for (auto& b : wrong.blocks) b.groups = {10, 11};
  refuses(wrong, 1, "belongs to two physical volumes, allowed one");
  wrong = good;
  for (auto& b : wrong.blocks) b.order = 2;
  refuses(wrong, 1, "second order");
  wrong = good;
  for (auto& b : wrong.blocks)
    if (b.groups == std::vector<int>{11} && !b.nodes.empty()) b.nodes[0] = 0;
  refuses(wrong, 1, "'volume 10' and 'volume 11' share a node");
  wrong = good;
  for (auto& b : wrong.blocks)
    if (!b.nodes.empty()) std::swap(b.nodes[0], b.nodes[4]);
  refuses(wrong, 1, "cell");
}
