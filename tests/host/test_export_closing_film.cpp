#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "host/export/closing_film.h"
#include "sim/models/solid_closing.h"
#include "sim/specimen/specimen_potential.h"

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

namespace {

/// Numbers of the appended array called `name` of a VTU file.
std::vector<double> array_of(const std::string& file, const std::string& name) {
  const auto place = file.find("Name=\"" + name);
  const auto data = file.find("raw\">\n_");
  REQUIRE(place != std::string::npos);
  REQUIRE(data != std::string::npos);
  const std::size_t at = data + 7 + std::stoul(file.substr(file.find("offset=\"", place) + 8));
  std::uint64_t size = 0;
  std::memcpy(&size, file.data() + at, sizeof size);
  REQUIRE(at + 8 + size <= file.size());
  std::vector<double> values(size / sizeof(double));
  std::memcpy(values.data(), file.data() + at + 8, size);
  return values;
}

}  // namespace

TEST_CASE("a closing whose energies do not balance stops, and its last state is in the files") {
  Conditions conditions;
  conditions.closing_angle = 1.5;
  const sim::Specimen specimen;
  const sim::SpecimenPotential field(specimen);
  sim::SolidClosingOptions options;
  options.cell = 6e-3;
  options.solid.energy_bound = 1e-14;  // none is that good
  std::map<std::string, std::string> files;
  for (const auto format : {host::ClosingFilm::Format::vtu, host::ClosingFilm::Format::gltf}) {
    host::ClosingFilm film(
        format, [&](const std::string& name, const std::string& content) { files[name] = content; });
    try {
      sim::solid_closing(specimen, conditions, field, options, std::ref(film));
      FAIL("went on");
    } catch (const sim::SolidStop& stop) {
      film.finish();
      CHECK(stop.cell == -1);
      CHECK_THAT(stop.what(), Catch::Contains("energy residual"));
      if (format == host::ClosingFilm::Format::gltf) continue;
      const std::string& list = files.at("closing.pvd");
      const auto last = list.rfind("timestep=\"");
      CHECK(std::stod(list.substr(last + 10)) == Approx(stop.time).epsilon(1e-15));
    }
  }
  CHECK(files.count("closing.gltf") == 1);
}

TEST_CASE("a state in which a cell is inside out can be read from the file it is left in") {
  Shown s;
  sim::SolidOptions options;
  options.energy_bound = 1e9;
  sim::ExplicitSolid solid(s.contactor.mesh, s.contactor.materials, options);
  host::ClosingFilm film(
      host::ClosingFilm::Format::vtu,
      [&](const std::string& name, const std::string& content) { s.files[name] = content; }, 1e9);
  film(solid, s.contactor);
  const int bridge = s.contactor.bridges[0], first = solid.cells().nodes_begin(bridge);
  solid.set_node_velocity(first, {5e4, 5e4, 5e4});  // a corner goes through its cell within a step
  int cell = -2;
  try {
    for (int k = 0; k < 10000; ++k) solid.step();
  } catch (const sim::SolidStop& stop) {
    cell = stop.cell;
    film(solid, s.contactor);  // at the instant of no other state, and in flight: kept all the same
  }
  film.finish();
  REQUIRE(cell >= 0);
  REQUIRE(film.states() == 2);
  const auto points = array_of(s.files.at("closing_1.vtu"), "Points");
  const auto moved = array_of(s.files.at("closing_1.vtu"), "displacement");
  REQUIRE(points.size() == 3 * s.contactor.mesh.nodes.size());
  sim::SolidMesh bent = s.contactor.mesh;
  for (std::size_t n = 0; n < bent.nodes.size(); ++n) {
    for (int i = 0; i < 3; ++i) {
      const double at = points[3 * n + static_cast<std::size_t>(i)];
      CHECK(at == bent.nodes[n][i] + moved[3 * n + static_cast<std::size_t>(i)]);
      bent.nodes[n][i] = at;
    }
  }
  CHECK_FALSE(sim::cell_volume(bent, bent.cells[static_cast<std::size_t>(cell)]) > 0);
}
