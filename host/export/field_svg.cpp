#include "host/export/field_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "host/export/field_frame.h"

namespace powbench::host {
namespace {

struct Point {
  double x, y;
};

/// The picture of the mesh, which may be one half of the core; y grows downwards in SVG.
struct FieldPicture {
  const sim::FieldProblem& problem;
  const std::vector<double>& a;
  std::vector<int> shown;  ///< by region: what it is drawn as; below 0: air
  double stretch = 1;      ///< true over meshed height of the strip
  bool half = true;        ///< x < 0 is the mirror image
  double left = 1e9, right = -1e9, bottom = 1e9, top = -1e9;  ///< of the core, m
  std::map<int, std::string> fills = {};
  std::string contours = {};
  double least_a = 0, largest_a = 0;

  double true_y(double y) const {
    if (y <= 0 || stretch == 1) return y;
    return y < sim::strip_height ? y * stretch : y + (stretch - 1) * sim::strip_height;
  }
  Point screen(Point p) const { return {p.x * field_pixels, -p.y * field_pixels}; }

  std::size_t unknown(std::size_t t, int n) const {
    return static_cast<std::size_t>(problem.space().unknowns(t)[n]);
  }

  void measure() {
    const auto& m = problem.space().mesh;
    for (std::size_t t = 0; t < m.triangle.size(); ++t) {
      if (kind(m.region[t]) < 0) continue;
      for (const int v : m.triangle[t]) {
        left = std::min(left, m.x[static_cast<std::size_t>(v)]);
        right = std::max(right, m.x[static_cast<std::size_t>(v)]);
        bottom = std::min(bottom, m.y[static_cast<std::size_t>(v)]);
        top = std::max(top, true_y(m.y[static_cast<std::size_t>(v)]));
      }
    }
    half = *std::min_element(m.x.begin(), m.x.end()) >= 0;
    if (half) left = -right;
    const auto& space = problem.space();
    for (std::size_t u = 0; u < space.node_x.size(); ++u) {
      const double value = space.axisymmetric ? space.node_x[u] * a[u] : a[u];
      least_a = std::min(least_a, value);
      largest_a = std::max(largest_a, value);
    }
  }

  int kind(int region) const { return shown[static_cast<std::size_t>(region)]; }

  /// Four triangles from the corners and the middles of the edges.
  void draw() {
    measure();
    const auto& space = problem.space();
    const auto& m = space.mesh;
    const double reach = field_margin;
    for (std::size_t t = 0; t < m.triangle.size(); ++t) {
      std::array<Point, 6> p{};
      std::array<double, 6> value{};
      for (std::size_t n = 0; n < 3; ++n) {
        const auto v = static_cast<std::size_t>(m.triangle[t][n]);
        p[n] = {m.x[v], true_y(m.y[v])};
      }
      for (std::size_t n = 0; n < 3; ++n)
        p[n + 3] = {0.5 * (p[n].x + p[(n + 1) % 3].x), 0.5 * (p[n].y + p[(n + 1) % 3].y)};
      const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
      const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
      if (x1 < left - reach || x0 > right + reach || y1 < bottom - reach || y0 > top + reach) continue;
      for (int n = 0; n < space.nodes; ++n)  // around an axis r A is even along a line of flux
        value[static_cast<std::size_t>(n)] =
            a[unknown(t, n)] * (space.axisymmetric ? p[static_cast<std::size_t>(n)].x : 1);
      if (space.order == 1)
        for (std::size_t n = 0; n < 3; ++n) value[n + 3] = 0.5 * (value[n] + value[(n + 1) % 3]);
      constexpr std::array<std::array<std::size_t, 3>, 4> parts{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
      constexpr std::array<std::array<double, 3>, 4> middles{{{2. / 3, 1. / 6, 1. / 6},
                                                              {1. / 6, 2. / 3, 1. / 6},
                                                              {1. / 6, 1. / 6, 2. / 3},
                                                              {1. / 3, 1. / 3, 1. / 3}}};
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto [bx, by] = problem.field(t, middles[k], a.data());
        fill(p, parts[k], std::hypot(bx, by));
        trace(p, value, parts[k]);
      }
    }
  }

  void fill(const std::array<Point, 6>& p, const std::array<std::size_t, 3>& part, double b) {
    auto& path = fills[field_shade(b)];
    for (std::size_t k = 0; k < 3; ++k) {
      const Point s = screen(p[part[k]]);
      path += fmt::format("{}{:.1f} {:.1f}", k == 0 ? 'M' : 'L', s.x, s.y);
    }
    path += 'Z';
  }

  void trace(const std::array<Point, 6>& p, const std::array<double, 6>& value,
             const std::array<std::size_t, 3>& part) {
    const int lines = problem.space().axisymmetric ? 12 : 24;  // the outer leg of a pot is thin
    for (int line = 0; line < lines; ++line) {
      const double level = least_a + (largest_a - least_a) * (line + 0.5) / lines;
      std::vector<Point> cuts;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto i = part[k], j = part[(k + 1) % 3];
        if ((value[i] < level) == (value[j] < level)) continue;
        const double s = (level - value[i]) / (value[j] - value[i]);
        cuts.push_back(screen({p[i].x + s * (p[j].x - p[i].x), p[i].y + s * (p[j].y - p[i].y)}));
      }
      if (cuts.size() == 2)
        contours += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", cuts[0].x, cuts[0].y, cuts[1].x, cuts[1].y);
    }
  }

  /// Edges between different regions.
  std::string outlines() const {
    const auto& m = problem.space().mesh;
    std::map<std::pair<int, int>, std::vector<int>> sides;
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        sides[std::minmax(m.triangle[t][k], m.triangle[t][(k + 1) % 3])].push_back(kind(m.region[t]));
      }
    std::string path;
    for (const auto& [ends, regions] : sides) {
      if (regions.size() != 2 || regions[0] == regions[1]) continue;
      const auto i = static_cast<std::size_t>(ends.first), j = static_cast<std::size_t>(ends.second);
      const Point p = screen({m.x[i], true_y(m.y[i])}), q = screen({m.x[j], true_y(m.y[j])});
      path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", p.x, p.y, q.x, q.y);
    }
    return path;
  }
};

/// The picture with its title and scale.
std::string framed(FieldPicture picture, const std::string& title) {
  picture.draw();
  return framed_field({picture.left, picture.right, picture.bottom, picture.top, picture.half, picture.fills,
                       picture.contours, picture.outlines()},
                      title);
}

}  // namespace

std::string field_svg(const sim::MagnetField& field, const sim::FieldPoint& point, const std::string& title) {
  using Region = sim::CoreRegion;
  std::vector<int> shown(Region::count);
  for (int r = 0; r < Region::count; ++r) shown[static_cast<std::size_t>(r)] = r;
  shown[Region::air] = shown[Region::strip] = -1;
  shown[Region::strip_iron] = Region::fixed_iron;  // the strip counts as what it continues
  return framed({field.problem(), point.a, shown, field.problem().gap() / sim::strip_height}, title);
}

std::string field_svg(const sim::DrawnField& field, const sim::FieldPoint& point, const std::string& title) {
  std::vector<int> shown;
  for (const auto& part : field.drawing().parts)
    shown.push_back(part.role == sim::DrawnRole::air || part.role == sim::DrawnRole::stretch
                        ? -1
                        : static_cast<int>(shown.size()));
  return framed({field.problem(), point.a, shown}, title);
}

std::string field_svg(const sim::SolenoidField& field, const sim::FieldPoint& point,
                      const std::string& title) {
  std::vector<int> shown(sim::SolenoidRegion::count);
  for (int r = 0; r < sim::SolenoidRegion::count; ++r) shown[static_cast<std::size_t>(r)] = r;
  shown[sim::SolenoidRegion::air] = -1;
  return framed({field.problem(), point.a, shown}, title);
}

}  // namespace powbench::host
