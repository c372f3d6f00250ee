#include "bench/fields/case_mesh.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {

std::vector<double> even_lines(double from, double to, int cells) {
  std::vector<double> lines;
  for (int k = 0; k <= cells; ++k) lines.push_back(from + (to - from) * k / cells);
  return lines;
}

sim::Mesh quarter_disc(double radius, double far, int cells, int outer_cells) {
  auto lines = even_lines(0, 1, cells);
  const auto outer = even_lines(1, 2, outer_cells);
  lines.insert(lines.end(), outer.begin() + 1, outer.end());
  auto mesh = sim::tensor_mesh(lines, lines, [](double u, double v) { return std::max(u, v) < 1 ? 1 : 0; },
                               {true, true, false, true});
  for (std::size_t k = 0; k < mesh.x.size(); ++k) {
    const double u = mesh.x[k], v = mesh.y[k];
    const double m = std::max({u, v, 1.0});
    const double reach = radius * std::pow(far / radius, m - 1);
    mesh.x[k] = reach * u / m * std::sqrt(1 - v * v / (2 * m * m));
    mesh.y[k] = reach * v / m * std::sqrt(1 - u * u / (2 * m * m));
  }
  return mesh;
}

sim::Mesh disc_wedge(double degrees, const std::vector<double>& radii) {
  auto mesh = sim::tensor_mesh(radii, {0, 1}, [](double, double) { return 0; }, {false, true, false, false});
  // the centre is one point: its two vertices become one, the triangle between them is dropped
  const std::size_t columns = radii.size();
  sim::Mesh wedge = mesh;
  wedge.triangle.clear();
  wedge.region.clear();
  for (auto t : mesh.triangle) {
    for (int& v : t)
      if (static_cast<std::size_t>(v) == columns) v = 0;
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    wedge.triangle.push_back(t);
    wedge.region.push_back(0);
  }
  for (std::size_t k = 0; k < wedge.x.size(); ++k) {
    const double angle = wedge.y[k] * radians(degrees), r = wedge.x[k];
    wedge.x[k] = r * std::cos(angle);
    wedge.y[k] = r * std::sin(angle);
  }
  return wedge;
}

}  // namespace powbench::bench
