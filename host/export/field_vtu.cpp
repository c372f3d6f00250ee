#include "host/export/field_vtu.h"

#include <cmath>
#include <map>
#include <utility>

namespace powbench::host {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

VtuGrid field_grid(const sim::FieldProblem& problem, const std::vector<double>& a) {
  const auto& space = problem.space();
  const auto& mesh = space.mesh;
  const double meshed = problem.setup().strip_height;
  const double more = problem.setup().strip_region >= 0 ? problem.gap() - meshed : 0;
  VtuGrid grid;
  VtuField potential{"A [Wb/m]", 1, {}}, flux{"B [T]", 3, {}}, size{"|B| [T]", 1, {}},
      region{"region", 1, {}};
  const auto add_point = [&](double x, double y, double value) {
    grid.points.insert(grid.points.end(), {x, y + more * std::fmin(std::fmax(y / meshed, 0), 1), 0});
    potential.values.push_back(value);
    return static_cast<std::int64_t>(potential.values.size()) - 1;
  };
  std::map<std::pair<int, int>, std::int64_t> points;  // by the two vertices they lie between, a vertex twice
  for (std::size_t t = 0; t < mesh.triangle.size(); ++t) {
    const auto& v = mesh.triangle[t];
    std::vector<std::int64_t> corners;
    for (int n = 0; n < space.nodes; ++n) {
      const int from = v[index(n % 3)], to = n < 3 ? from : v[index((n + 1) % 3)];
      const auto [place, fresh] = points.try_emplace(std::minmax(from, to), 0);
      if (fresh)
        place->second =
            add_point(0.5 * (mesh.x[index(from)] + mesh.x[index(to)]),
                      0.5 * (mesh.y[index(from)] + mesh.y[index(to)]), a[index(space.unknowns(t)[n])]);
      corners.push_back(place->second);
    }
    grid.add_cell(space.nodes == 6 ? VtkCell::quadratic_triangle : VtkCell::triangle, corners);
    const auto [bx, by] = problem.field(t, {1. / 3, 1. / 3, 1. / 3}, a.data());
    flux.values.insert(flux.values.end(), {bx, by, 0});
    size.values.push_back(std::hypot(bx, by));
    region.values.push_back(mesh.region[t]);
  }
  grid.point_fields = {std::move(potential)};
  grid.cell_fields = {std::move(flux), std::move(size), std::move(region)};
  return grid;
}

}  // namespace powbench::host
