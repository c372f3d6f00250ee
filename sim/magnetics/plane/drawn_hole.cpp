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

}  // namespace

std::optional<std::pair<double, double>> unmeshed_place(const Mesh& m) {
  const auto point = [&](int v) {
    return Point{m.x[static_cast<std::size_t>(v)], m.y[static_cast<std::size_t>(v)]};
  };
  std::map<std::pair<int, int>, int> triangles;
  for (const auto& t : m.triangle)
    for (std::size_t k = 0; k < 3; ++k) ++triangles[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<Point> ends;
  for (const auto& [edge, count] : triangles)
    if (count == 1) ends.insert(ends.end(), {point(edge.first), point(edge.second)});
  const auto hull = hull_of(ends);
  const auto extent = [&](auto member) {
    const auto [low, high] = std::minmax_element(
        ends.begin(), ends.end(), [&](const Point& a, const Point& b) { return a.*member < b.*member; });
    return (*high).*member - (*low).*member;
  };
  const double little = 1e-6 * std::max(extent(&Point::first), extent(&Point::second));
  std::vector<int> parent(m.x.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[static_cast<std::size_t>(v)] != v) v = parent[static_cast<std::size_t>(v)];
    return v;
  };
  std::vector<int> inner;  // vertices of such edges
  for (const auto& [edge, count] : triangles) {
    const auto [a, b] = edge;
    if (count != 1 || (m.zero[static_cast<std::size_t>(a)] && m.zero[static_cast<std::size_t>(b)])) continue;
    if (on_hull(hull, point(a), point(b), little)) continue;
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
