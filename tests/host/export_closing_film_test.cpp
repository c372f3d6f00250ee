#include <catch2/catch.hpp>
#include <map>

#include "host/export/closing_film.h"

using namespace powbench;

namespace {

struct Shown {
  sim::ContactorMesh contactor = sim::contactor_mesh(sim::Specimen{}, 6e-3);
  sim::ExplicitSolid solid{contactor.mesh, contactor.materials};
  std::map<std::string, std::string> files;

  /// Two states, the bridges 1 mm further up in the second.
  void film(host::ClosingFilm::Format format) {
    host::ClosingFilm film(
        format, [&](const std::string& name, const std::string& content) { files[name] = content; }, 0);
    film(solid, contactor);
    for (const int b : contactor.bridges)
      for (int n = solid.cells().nodes_begin(b); n < solid.cells().nodes_end(b); ++n)
        solid.set_node_displacement(n, {0, 0, 1e-3});
    film(solid, contactor);  // the same instant again: not a state of its own
    solid.step();
    film(solid, contactor);
    film.finish();
    CHECK(film.states() == 2);
  }
};

}  // namespace

TEST_CASE("a state of the bodies as a grid: places, motion, and no stress without strain") {
  Shown s;
  const auto& nodes = s.contactor.mesh.nodes;
  s.solid.set_velocity(s.contactor.mover, {0, 0, 2});
  const host::VtuGrid g = host::state_grid(s.solid, s.contactor);
  REQUIRE(g.points.size() == 3 * nodes.size());
  CHECK(g.points[3 * 7 + 2] == nodes[7].z);
  REQUIRE(g.cells.size() == s.contactor.mesh.cells.size());
  CHECK(g.point_fields[1].values[2] == 2);
  double most = 0;
  for (const double x : g.cell_fields[0].values) most = std::max(most, x);
  CHECK(most == 0);
  CHECK_NOTHROW(host::to_vtu(g));
}

TEST_CASE("a film of states: one VTU each and the PVD that names them") {
  Shown s;
  s.film(host::ClosingFilm::Format::vtu);
  REQUIRE(s.files.size() == 3);
  CHECK(s.files.at("closing_0.vtu") != s.files.at("closing_1.vtu"));
  CHECK(s.files.at("closing.pvd").find("closing_1.vtu") != std::string::npos);
}

TEST_CASE("a film as glTF: one file with every part") {
  Shown s;
  s.film(host::ClosingFilm::Format::gltf);
  REQUIRE(s.files.size() == 1);
  for (const auto& part : s.contactor.mesh.parts)
    CHECK(s.files.at("closing.gltf").find(part) != std::string::npos);
}
