#include "host/export/space_vtu.h"

#include <cmath>
#include <utility>

namespace powbench::host {

VtuGrid space_grid(const sim::space::Coenergy& function, const sim::space::State& state) {
  const auto& mesh = function.problem().mesh;
  const auto potential = function.nodal(state);
  VtuGrid grid;
  for (const auto& n : mesh.nodes) grid.points.insert(grid.points.end(), {n.x, n.y, n.z});
  VtuField flux{"B [T]", 3, {}}, size{"|B| [T]", 1, {}}, region{"region", 1, {}};
  constexpr int order[10] = {0, 1, 2, 3, 4,
                             5, 6, 7, 9, 8};  // of VTK, whose last two edges are the other way round
  const int middle = sim::space::cell_rule(mesh.cell).points / 2;
  for (int c = 0; c < mesh.count(); ++c) {
    std::vector<std::int64_t> nodes;
    for (const int k : order) nodes.push_back(mesh.cells[static_cast<std::size_t>(10 * c + k)]);
    grid.add_cell(VtkCell::quadratic_tetrahedron, nodes);
    const sim::Vec3 b = function.law(c).at(function.field(c, middle, potential, state)).b;
    flux.values.insert(flux.values.end(), {b.x, b.y, b.z});
    size.values.push_back(std::sqrt(dot(b, b)));
    region.values.push_back(mesh.region[static_cast<std::size_t>(c)]);
  }
  grid.point_fields = {{"u [A]", 1, potential}};
  grid.cell_fields = {std::move(flux), std::move(size), std::move(region)};
  return grid;
}

}  // namespace powbench::host
