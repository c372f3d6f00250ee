#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <map>
#include <numeric>

#include "host/config/bad_input.h"
#include "host/export/field_vtu.h"
#include "host/import/field_mesh.h"
#include "sim/magnetics/plane/magnet_field.h"

using namespace powbench;

namespace {

/// A plane mesh as gmsh writes it, in mm: each region one surface and one physical group of that name; the edges
/// between vertices where A = 0 as one line.
std::string as_msh(const sim::Mesh& m, const std::vector<std::string>& names, bool with_line = true) {
  std::map<std::string, std::vector<std::size_t>> triangles;
  for (std::size_t t = 0; t < m.triangle.size(); ++t)
    triangles[names[static_cast<std::size_t>(m.region[t])]].push_back(t);
  std::vector<std::array<int, 2>> lines;
  if (with_line) {
    std::map<std::pair<int, int>, int> sides;
    for (const auto& v : m.triangle)
      for (std::size_t k = 0; k < 3; ++k) ++sides[std::minmax(v[k], v[(k + 1) % 3])];
    for (const auto& [ends, count] : sides)
      if (count == 1 && m.zero[static_cast<std::size_t>(ends.first)] &&
          m.zero[static_cast<std::size_t>(ends.second)])
        lines.push_back({ends.first, ends.second});
  }
  const std::size_t groups = triangles.size() + (lines.empty() ? 0 : 1);
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n" + std::to_string(groups) + "\n";
  if (!lines.empty()) text += "1 99 \"A=0\"\n";
  int tag = 0;
  for (const auto& [name, list] : triangles) text += fmt::format("2 {} \"{}\"\n", ++tag, name);
  text += fmt::format("$EndPhysicalNames\n$Entities\n0 {} {} 0\n", lines.empty() ? 0 : 1, triangles.size());
  if (!lines.empty()) text += "1 0 0 0 1 1 0 1 99 0\n";
  for (int s = 1; s <= tag; ++s) text += fmt::format("{0} 0 0 0 1 1 0 1 {0} 0\n", s);
  const std::size_t n = m.x.size();
  text += fmt::format("$EndEntities\n$Nodes\n1 {0} 1 {0}\n2 1 0 {0}\n", n);
  for (std::size_t k = 1; k <= n; ++k) text += fmt::format("{}\n", k);
  for (std::size_t k = 0; k < n; ++k) text += fmt::format("{:.17g} {:.17g} 0\n", m.x[k] * 1e3, m.y[k] * 1e3);
  const std::size_t elements = m.triangle.size() + lines.size();
  text += fmt::format("$EndNodes\n$Elements\n{0} {1} 1 {1}\n", groups, elements);
  std::size_t element = 0;
  if (!lines.empty()) text += fmt::format("1 1 1 {}\n", lines.size());
  for (const auto& l : lines) text += fmt::format("{} {} {}\n", ++element, l[0] + 1, l[1] + 1);
  int surface = 0;
  for (const auto& [name, list] : triangles) {
    text += fmt::format("2 {} 2 {}\n", ++surface, list.size());
    for (const std::size_t t : list)
      text += fmt::format("{} {} {} {}\n", ++element, m.triangle[t][0] + 1, m.triangle[t][1] + 1,
                          m.triangle[t][2] + 1);
  }
  return text + "$EndElements\n";
}

const std::vector<std::string> core_names{"air", "air", "steel", "armature", "coil+", "air", "air"};

sim::CoreMeshSizes coarse() {
  return sim::CoreMeshSizes{}.scaled(4);
}

std::string refusal(const std::string& content, double metres = 1e-3) {
  try {
    host::FieldMeshOptions options;
    options.metres = metres;
    host::read_field_mesh(content, "a.msh", options);
  } catch (const host::BadInput& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("the reference core as a mesh file has the flux, the energy and the pull of the core itself") {
  const sim::MagnetDesign design;
  sim::MagnetField core(design, {coarse(), 2, 6e-3, {}});
  core.set_gap(sim::strip_height - design.residual_gap);  // the strip as meshed
  const auto expected = core.at_current(0.4, 0);
  const auto drawn = host::read_field_mesh(
      as_msh(sim::core_mesh(design.shape, coarse(), 6e-3), core_names), "core.msh",
      {1e-3, design.turns, 2 * design.shape.stack, design.steel.stacked(design.shape.stack_factor)});
  const sim::FieldProblem problem(drawn.mesh, drawn.setup);
  CHECK(problem.size() == core.unknowns());
  sim::Newton newton(problem);
  std::vector<double> a(static_cast<std::size_t>(problem.size()) + 1, 0), current;
  CHECK(newton.solve({{false, 0.4, 0}}, a, current).converged);
  const double psi = std::inner_product(a.begin(), a.end(), problem.winding(0).begin(), 0.0);
  CHECK(psi == Approx(core.fluxes(expected).first).epsilon(1e-8));
  CHECK(newton.energy() == Approx(expected.response.energy).epsilon(1e-8));
  // by the layer around the armature instead of the whole strip: the two differ by the error of this mesh
  CHECK(-problem.stress_force(a.data(), drawn.armature) == Approx(expected.response.pull).epsilon(0.03));

  const auto grid = host::field_grid(problem, a);
  CHECK(grid.cells.size() == drawn.mesh.triangle.size());
  CHECK(grid.point_fields.at(0).values.size() * 3 == grid.points.size());
  CHECK(*std::max_element(grid.cell_fields.at(1).values.begin(), grid.cell_fields.at(1).values.end()) ==
        Approx(expected.largest_field).epsilon(0.2));
  CHECK(host::to_vtu(grid).find("Name=\"B [T]\"") != std::string::npos);
}

TEST_CASE("the grid of a core shows its strip at the true gap") {
  sim::MagnetField core({}, {coarse(), 2, 6e-3, {}});
  core.set_gap(4e-3);
  const auto grid = host::field_grid(core.problem(), core.at_current(0.1, 0).a);
  const auto top = [](const host::VtuGrid& g) {
    double y = 0;
    for (std::size_t k = 1; k < g.points.size(); k += 3) y = std::max(y, g.points[k]);
    return y;
  };
  const double before = top(grid);
  core.set_gap(1e-3);
  CHECK(before - top(host::field_grid(core.problem(), core.at_current(0.1, 0).a)) == Approx(3e-3));
}

TEST_CASE("mesh files that cannot be used are refused with the group and what is allowed") {
  const auto mesh = sim::core_mesh({}, coarse(), 6e-3);
  CHECK(refusal(as_msh(mesh, core_names)) == "accepted");
  auto names = core_names;
  names[2] = "iron";
  CHECK_THAT(refusal(as_msh(mesh, names)),
             Catch::StartsWith("a.msh: physical surface 4 = 'iron' names no material; allowed 9smnpb28, air, "
                               "aisi1008, armature, coil+, coil-, lamination, m350-50a"));
  names = core_names;
  names[4] = "air";
  CHECK_THAT(refusal(as_msh(mesh, names)), Catch::Contains("no physical surface 'coil+'"));
  CHECK_THAT(refusal(as_msh(mesh, core_names, false)), Catch::Contains("no physical line 'A=0'"));
  CHECK_THAT(refusal(as_msh(mesh, core_names), 1),
             Catch::Contains("mm wide or high, allowed 5 .. 5000; is --mesh-unit right?"));
  names = core_names;
  names[1] = "steel";
  CHECK_THAT(refusal(as_msh(mesh, names)), Catch::Contains("steel touches the armature"));
  CHECK_THAT(refusal("not a mesh"), Catch::StartsWith("a.msh: line 1"));
  names = core_names;
  names[3] = "team13";  // no armature: no pull, but a field
  const auto still = host::read_field_mesh(as_msh(mesh, names), "a.msh", {});
  CHECK(still.armature.empty());
  CHECK(still.setup.steels.size() == 1 + sim::builtin_steel_names().size());
}
