// A drawing in space from its file: beside the grid core of the same shape, and lying on its side.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/config/space_file.h"
#include "host/export/field_frame.h"
#include "host/export/space_svg.h"
#include "sim/magnetics/plane/msh.h"
#include "tests/folder.h"
#include "tests/places.h"

using namespace powbench;
using powbench::test::Folder;

namespace {

const std::string relay = powbench::test::source_dir() + "/docs/examples/own-magnet/relay";

/// The relay's drawing with x, y, z in the places of z, -y and x: it opens towards +x, mirrored at y = 0.
std::string turned(const Folder& folder) {
  std::ifstream in(relay + ".msh", std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  const auto mesh = sim::read_msh(bytes.str());
  std::ostringstream out;
  out.precision(17);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" << mesh.groups.size() << "\n";
  for (const auto& g : mesh.groups) out << g.dimension << " " << g.tag << " \"" << g.name << "\"\n";
  out << "$EndPhysicalNames\n$Nodes\n" << mesh.nodes.size() << "\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    out << n + 1 << " " << mesh.nodes[n][2] << " " << -mesh.nodes[n][1] << " " << mesh.nodes[n][0] << "\n";
  std::ostringstream cells;
  int count = 0;
  for (const auto& b : mesh.blocks) {
    if (b.shape != sim::MshShape::tetrahedron) continue;
    for (int e = 0; e < b.elements(); ++e) {
      cells << ++count << " 4 2 " << b.groups.front() << " " << b.entity;
      for (int k = 0; k < 4; ++k) cells << " " << b.nodes[static_cast<std::size_t>(4 * e + k)] + 1;
      cells << "\n";
    }
  }
  out << "$EndNodes\n$Elements\n" << count << "\n" << cells.str() << "$EndElements\n";
  folder.write("turned.msh", out.str());
  std::ifstream drawing(relay + ".magnet.toml");
  std::ostringstream text;
  for (std::string line; std::getline(drawing, line);) {
    if (line.starts_with("mesh")) line = "mesh = \"turned.msh\"";
    if (line.starts_with("opening")) line = "opening = \"+x\"";
    if (line.starts_with("axis")) line = "axis = \"x\"";
    text << line << "\n";
  }
  return folder.write("turned.magnet.toml", text.str());
}

}  // namespace

TEST_CASE("a relay drawn in space beside the C-core of the same shape", "[.slow]") {
  const auto drawing = host::read_space_drawing(relay + ".magnet.toml");
  CHECK(drawing->copies == 2);
  CHECK(drawing->turns() == 3000);
  sim::MagnetDesign d;
  auto& s = d.shape;
  s.legs = 2;
  s.closed_leg = 1;
  s.ring_share = 0;
  s.centre_width = 10e-3;
  s.outer_width = 8e-3;
  s.window_width = 14e-3;
  s.fixed_window = 30e-3;
  s.moving_window = 0;
  s.yoke = 6e-3;
  s.stack = 12e-3;
  s.stack_factor = 1;
  s.coil_width = 10e-3;
  s.coil_height = 26e-3;
  s.coil_offset = 2e-3;
  d.turns = 3000;
  d.residual_gap = 60e-6;
  d.steel = sim::builtin_steel("m530-50a");
  sim::space::MagnetField core(d, sim::space::CoreMeshSizes{}.scaled(1.4));
  auto field = sim::space_field(*drawing, false);
  std::printf("relay: %d unknowns, its grid %d\n", field.unknowns(), core.unknowns());
  double worst = 0;
  for (const double gap : {0.0, 0.5e-3, 1.5e-3})
    for (const double current : {0.05, 0.3}) {
      core.set_gap(gap);
      field.set_gap(gap);
      const auto a = field.at_current(current), b = core.at_current(current);
      std::printf("gap %.1f mm, %.2f A: flux linkage %+.2f %%, pull %+.2f %%, by stress %+.2f %%\n",
                  gap * 1e3, current, 100 * (a.psi / b.psi - 1),
                  100 * (a.response.pull / b.response.pull - 1), 100 * (a.stress_pull / a.response.pull - 1));
      // edges of 0.6 mm beside the pole against 0.35 mm
      CHECK(a.psi == Approx(b.psi).epsilon(0.02));
      CHECK(a.response.pull == Approx(b.response.pull).epsilon(0.03));
      worst =
          std::max({worst, std::fabs(a.psi / b.psi - 1), std::fabs(a.response.pull / b.response.pull - 1)});
    }
  const double stated = sim::mesh_error(*drawing, field, {0.1, 0.4});
  std::printf("the mesh errs by %.1f %% at most, %.1f %% are stated\n", 100 * worst, 100 * stated);
  CHECK(stated > worst);
  CHECK(stated < 4 * worst);
}

TEST_CASE("a drawing in space that lies on its side has the same states", "[.slow]") {
  const Folder folder;
  const auto drawing = host::read_space_drawing(relay + ".magnet.toml"),
             other = host::read_space_drawing(turned(folder));
  auto field = sim::space_field(*drawing, false), side = sim::space_field(*other, false);
  field.set_gap(0.4e-3);
  side.set_gap(0.4e-3);
  const auto a = field.at_current(0.2), b = side.at_current(0.2);
  CHECK(b.psi == Approx(a.psi).epsilon(1e-8));
  CHECK(b.response.pull == Approx(a.response.pull).epsilon(1e-7));
}

namespace {

/// Area of all polygons of path data, pixels squared.
double area_of(const std::string& path) {
  std::istringstream in(path);
  std::vector<std::pair<double, double>> corners;
  double area = 0;
  const auto close = [&] {
    double twice = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const auto &a = corners[k], &b = corners[(k + 1) % corners.size()];
      twice += a.first * b.second - b.first * a.second;
    }
    area += std::fabs(twice) / 2;
    corners.clear();
  };
  for (char mark; in >> mark;) {
    if (mark == 'Z') {
      close();
      continue;
    }
    double x = 0, y = 0;
    in >> x >> y;
    corners.emplace_back(x, y);
  }
  return area;
}

}  // namespace

TEST_CASE("the section through a drawing in space shows all of its plane, once", "[.slow]") {
  const auto drawing = host::read_space_drawing(relay + ".magnet.toml");
  auto field = sim::space_field(*drawing, true);
  field.set_gap(0.5e-3);
  const auto& mesh = field.function().problem().mesh;
  const std::string svg =
      host::space_svg(*drawing, mesh, std::vector<double>(mesh.region.size(), 1.0), "half: gap 0.50 mm");
  CHECK(svg.find("half: gap 0.50 mm") != std::string::npos);
  double area = 0;
  const std::string mark = "<path d=\"";
  for (std::size_t at = svg.find(mark); at != std::string::npos; at = svg.find(mark, at + 1)) {
    const std::size_t from = at + mark.size(), to = svg.find('"', from);
    const std::string path = svg.substr(from, to - from);
    if (path.find('Z') != std::string::npos) area += area_of(path);
  }
  double low[3] = {1, 1, 1}, high[3] = {-1, -1, -1};
  for (const auto& n : mesh.nodes)
    for (std::size_t i = 0; i < 3; ++i) low[i] = std::min(low[i], n[i]), high[i] = std::max(high[i], n[i]);
  // mirrored at y = 0, where the drawing ends in the middle of its winding
  const double box = (high[0] - low[0]) * (high[2] - low[2]) * host::field_pixels * host::field_pixels;
  CHECK(area == Approx(box).epsilon(2e-3));
}
