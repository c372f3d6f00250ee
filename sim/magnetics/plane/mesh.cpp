#include "sim/magnetics/plane/mesh.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace powbench::sim {

double twice_area(const Mesh& m, const std::array<int, 3>& t) {
  const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
             c = static_cast<std::size_t>(t[2]);
  return (m.x[b] - m.x[a]) * (m.y[c] - m.y[a]) - (m.x[c] - m.x[a]) * (m.y[b] - m.y[a]);
}

double region_area(const Mesh& m, int region) {
  double sum = 0;
  for (std::size_t k = 0; k < m.triangle.size(); ++k)
    if (m.region[k] == region) sum += 0.5 * twice_area(m, m.triangle[k]);
  return sum;
}

void check_mesh(Mesh& m) {
  const std::size_t vertices = m.x.size();
  if (m.y.size() != vertices || m.zero.size() != vertices || m.region.size() != m.triangle.size() ||
      m.triangle.empty())
    throw std::invalid_argument(
        "mesh: the arrays of vertices or of triangles differ in length, or are empty");
  for (std::size_t k = 0; k < m.triangle.size(); ++k) {
    auto& t = m.triangle[k];
    for (const int v : t)
      if (v < 0 || static_cast<std::size_t>(v) >= vertices)
        throw std::invalid_argument("mesh: triangle " + std::to_string(k) + " names vertex " +
                                    std::to_string(v) + ", there are " + std::to_string(vertices));
    const double doubled = twice_area(m, t);
    if (doubled == 0 || !std::isfinite(doubled))
      throw std::invalid_argument("mesh: triangle " + std::to_string(k) + " has no area");
    if (doubled < 0) std::swap(t[1], t[2]);
  }
}

}  // namespace powbench::sim
