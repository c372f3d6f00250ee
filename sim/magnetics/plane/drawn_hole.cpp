// Where the mesh of a drawing has a hole.

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "sim/magnetics/plane/drawn_magnet.h"

namespace powbench::sim {
namespace {

using Point = std::pair<double, double>;

/// Twice the area of a, b, c.
double turned(const Point& a, const Point& b, const Point& c) {
  return (b.first - a.first) * (c.second - a.second) - (b.second - a.second) * (c.first - a.first);
}

/// Corners of the convex hull, counter-clockwise.
std::vector<Point> hull_of(std::vector<Point> p) {
  std::sort(p.begin(), p.end());
  std::vector<Point> out;
  for (int half = 0; half < 2; ++half) {
    const auto from = out.size();
    for (const auto& q : p) {
      while (out.size() >= from + 2 && turned(out[out.size() - 2], out.back(), q) <= 0) out.pop_back();
      out.push_back(q);
    }
    out.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return out;
}

/// Whether all corners of the hull lie on one side of a line.
bool on_hull(const std::vector<Point>& hull, const Point& a, const Point& b, double little) {
  const double length = std::hypot(b.first - a.first, b.second - a.second);
  double low = 0, high = 0;
  for (const auto& p : hull) {
    const double distance = turned(a, b, p) / length;
    low = std::min(low, distance);
    high = std::max(high, distance);
  }
  return std::min(-low, high) <= little;
}

/// The edges of one triangle only, and the hull of the mesh.
struct MeshOutline {
  std::vector<std::pair<int, int>> edges;
  std::vector<Point> hull;
  double little = 0;  ///< m: less is no distance

  explicit MeshOutline(const Mesh& mesh) : m(mesh) {
    std::map<std::pair<int, int>, int> triangles;
    for (const auto& t : m.triangle)
      for (std::size_t k = 0; k < 3; ++k) ++triangles[std::minmax(t[k], t[(k + 1) % 3])];
    std::vector<Point> ends;
    for (const auto& [edge, count] : triangles) {
      if (count != 1) continue;
      edges.push_back(edge);
      ends.insert(ends.end(), {point(edge.first), point(edge.second)});
    }
    hull = hull_of(ends);
    const auto extent = [&](auto member) {
      const auto [low, high] = std::minmax_element(
          ends.begin(), ends.end(), [&](const Point& a, const Point& b) { return a.*member < b.*member; });
      return (*high).*member - (*low).*member;
    };
    little = 1e-6 * std::max(extent(&Point::first), extent(&Point::second));
  }
  Point point(int v) const { return {m.x[static_cast<std::size_t>(v)], m.y[static_cast<std::size_t>(v)]}; }
  bool zero(const std::pair<int, int>& e) const {
    return m.zero[static_cast<std::size_t>(e.first)] != 0 && m.zero[static_cast<std::size_t>(e.second)] != 0;
  }
  bool outer(const std::pair<int, int>& e) const {
    return on_hull(hull, point(e.first), point(e.second), little);
  }

  const Mesh& m;
};

}  // namespace

std::optional<std::pair<double, double>> open_edge(const Mesh& m, bool quarter) {
  const MeshOutline outline(m);
  const double low = *std::min_element(m.y.begin(), m.y.end());
  for (const auto& e : outline.edges) {
    if (outline.zero(e) || !outline.outer(e)) continue;
    const auto [x0, y0] = outline.point(e.first);
    const auto [x1, y1] = outline.point(e.second);
    if (quarter && std::max(y0, y1) <= low + outline.little) continue;
    return Point{0.5 * (x0 + x1), 0.5 * (y0 + y1)};
  }
  return std::nullopt;
}

std::optional<std::pair<double, double>> unmeshed_place(const Mesh& m) {
  const MeshOutline outline(m);
  const auto point = [&](int v) { return outline.point(v); };
  std::vector<int> parent(m.x.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[static_cast<std::size_t>(v)] != v) v = parent[static_cast<std::size_t>(v)];
    return v;
  };
  std::vector<int> inner;  // vertices of such edges
  for (const auto& edge : outline.edges) {
    const auto [a, b] = edge;
    if (outline.zero(edge) || outline.outer(edge)) continue;
    inner.insert(inner.end(), {a, b});
    parent[static_cast<std::size_t>(root(a))] = root(b);
  }
  if (inner.empty()) return std::nullopt;
  Point low = point(inner.front()), high = low;
  for (const int v : inner) {
    if (root(v) != root(inner.front())) continue;
    const auto [x, y] = point(v);
    low = {std::min(low.first, x), std::min(low.second, y)};
    high = {std::max(high.first, x), std::max(high.second, y)};
  }
  return Point{0.5 * (low.first + high.first), 0.5 * (low.second + high.second)};
}

}  // namespace powbench::sim
