// How many triangles of a drawing lie between the faces.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sim/magnetics/plane/drawn_magnet.h"

namespace powbench::sim {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

bool is_air(DrawnRole role) {
  return role == DrawnRole::air || role == DrawnRole::stretch;
}

/// What a vertical line crosses, from below.
struct Crossed {
  double low = 0, high = 0;
  DrawnRole role = DrawnRole::air;
};

std::vector<Crossed> crossed(const DrawnMagnet& d, double x) {
  const Mesh& m = d.mesh;
  std::vector<Crossed> out;
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = at(m.triangle[t][k]), b = at(m.triangle[t][(k + 1) % 3]);
      if ((m.x[a] < x) == (m.x[b] < x)) continue;
      const double y = m.y[a] + (m.y[b] - m.y[a]) * (x - m.x[a]) / (m.x[b] - m.x[a]);
      low = std::min(low, y), high = std::max(high, y);
    }
    if (low < high) out.push_back({low, high, d.parts[at(m.region[t])].role});
  }
  std::sort(out.begin(), out.end(), [](const Crossed& a, const Crossed& b) { return a.low < b.low; });
  return out;
}

/// x near the middle of each edge between the armature and air that is not along the motion.
std::vector<double> face_places(const DrawnMagnet& d) {
  const Mesh& m = d.mesh;
  std::map<std::pair<int, int>, std::pair<bool, bool>> edges;  // beside the armature, beside air
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const auto role = d.parts[at(m.region[t])].role;
    if (role != DrawnRole::armature && !is_air(role)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      auto& beside = edges[std::minmax(m.triangle[t][k], m.triangle[t][(k + 1) % 3])];
      (role == DrawnRole::armature ? beside.first : beside.second) = true;
    }
  }
  std::vector<double> out;
  for (const auto& [edge, beside] : edges) {
    const double from = m.x[at(edge.first)], wide = m.x[at(edge.second)] - from,
                 high = m.y[at(edge.second)] - m.y[at(edge.first)];
    // not the very middle: there a regular mesh has vertices
    if (beside.first && beside.second && std::fabs(wide) > 1e-3 * std::fabs(high))
      out.push_back(from + 0.47 * wide);
  }
  return out;
}

}  // namespace

int triangles_across_gap(const DrawnMagnet& d) {
  struct Gap {
    double width;
    int triangles;
  };
  std::vector<Gap> gaps;
  const bool quarter = d.copies == 4;
  for (const double x : face_places(d)) {
    const auto line = crossed(d, x);
    Gap gap{0, 0};
    bool from_iron = quarter;
    for (const auto& c : line) {
      if (is_air(c.role)) {
        gap.width += c.high - c.low;
        ++gap.triangles;
        continue;
      }
      if (c.role == DrawnRole::armature && from_iron && gap.triangles > 0)
        gaps.push_back(quarter ? Gap{2 * gap.width, 2 * gap.triangles} : gap);
      from_iron = c.role == DrawnRole::fixed;
      gap = {0, 0};
    }
  }
  constexpr double same = 1.25;  // what is wider is not between the faces
  double least = std::numeric_limits<double>::infinity();
  for (const auto& g : gaps) least = std::min(least, g.width);
  int fewest = 0;
  for (const auto& g : gaps)
    if (g.width <= same * least) fewest = fewest == 0 ? g.triangles : std::min(fewest, g.triangles);
  return fewest;
}

}  // namespace powbench::sim
