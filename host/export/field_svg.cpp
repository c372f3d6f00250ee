#include "host/export/field_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

namespace powbench::host {
namespace {

constexpr double pixels_per_mm = 6, margin_mm = 8, largest_b = 2.4;
constexpr int shades = 32, lines = 24;

struct Point {
  double x, y;
};

/// Light to dark, 0 .. 1.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 6> stops{
      {{247, 251, 255}, {198, 219, 239}, {107, 174, 214}, {65, 182, 140}, {240, 180, 60}, {165, 15, 21}}};
  const double at = std::clamp(share, 0.0, 1.0) * (stops.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double t = at - static_cast<double>(k);
  const auto mix = [&](std::size_t c) {
    return static_cast<int>(stops[k][c] + t * (stops[k + 1][c] - stops[k][c]) + 0.5);
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2));
}

/// The picture of one half; y grows downwards in SVG.
struct FieldPicture {
  const sim::MagnetField& field;
  const std::vector<double>& a;
  double stretch;                         ///< true over meshed height of the strip
  double right = 0, bottom = 0, top = 0;  ///< of the core, m
  std::map<int, std::string> fills = {};
  std::string contours = {};
  double largest_a = 0;

  double true_y(double y) const {
    if (y <= 0) return y;
    return y < sim::strip_height ? y * stretch : y + (stretch - 1) * sim::strip_height;
  }
  Point screen(Point p) const { return {p.x * 1e3 * pixels_per_mm, -p.y * 1e3 * pixels_per_mm}; }

  std::size_t unknown(std::size_t t, int n) const {
    return static_cast<std::size_t>(field.problem().space().unknowns(t)[n]);
  }

  void measure() {
    const auto& m = field.problem().space().mesh;
    for (std::size_t t = 0; t < m.triangle.size(); ++t) {
      if (m.region[t] == sim::CoreRegion::air || m.region[t] == sim::CoreRegion::strip) continue;
      for (const int v : m.triangle[t]) {
        right = std::max(right, m.x[static_cast<std::size_t>(v)]);
        bottom = std::min(bottom, m.y[static_cast<std::size_t>(v)]);
        top = std::max(top, true_y(m.y[static_cast<std::size_t>(v)]));
      }
    }
    for (const double value : a) largest_a = std::max(largest_a, std::fabs(value));
  }

  /// Four triangles from the corners and the middles of the edges.
  void draw() {
    measure();
    const auto& space = field.problem().space();
    const auto& m = space.mesh;
    const double reach = margin_mm * 1e-3;
    for (std::size_t t = 0; t < m.triangle.size(); ++t) {
      std::array<Point, 6> p{};
      std::array<double, 6> value{};
      for (std::size_t n = 0; n < 3; ++n) {
        const auto v = static_cast<std::size_t>(m.triangle[t][n]);
        p[n] = {m.x[v], true_y(m.y[v])};
      }
      for (std::size_t n = 0; n < 3; ++n)
        p[n + 3] = {0.5 * (p[n].x + p[(n + 1) % 3].x), 0.5 * (p[n].y + p[(n + 1) % 3].y)};
      if (p[0].x > right + reach || p[0].y < bottom - reach || p[0].y > top + reach) continue;
      for (int n = 0; n < space.nodes; ++n) value[static_cast<std::size_t>(n)] = a[unknown(t, n)];
      if (space.order == 1)
        for (std::size_t n = 0; n < 3; ++n) value[n + 3] = 0.5 * (value[n] + value[(n + 1) % 3]);
      constexpr std::array<std::array<std::size_t, 3>, 4> parts{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
      constexpr std::array<std::array<double, 3>, 4> middles{{{2. / 3, 1. / 6, 1. / 6},
                                                              {1. / 6, 2. / 3, 1. / 6},
                                                              {1. / 6, 1. / 6, 2. / 3},
                                                              {1. / 3, 1. / 3, 1. / 3}}};
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto [bx, by] = field.problem().field(t, middles[k], a.data());
        fill(p, parts[k], std::hypot(bx, by));
        trace(p, value, parts[k]);
      }
    }
  }

  void fill(const std::array<Point, 6>& p, const std::array<std::size_t, 3>& part, double b) {
    const int shade = std::min(shades, static_cast<int>(b / largest_b * shades));
    auto& path = fills[shade];
    for (std::size_t k = 0; k < 3; ++k) {
      const Point s = screen(p[part[k]]);
      path += fmt::format("{}{:.1f} {:.1f}", k == 0 ? 'M' : 'L', s.x, s.y);
    }
    path += 'Z';
  }

  void trace(const std::array<Point, 6>& p, const std::array<double, 6>& value,
             const std::array<std::size_t, 3>& part) {
    for (int line = 0; line < lines; ++line) {
      const double level = largest_a * (line + 0.5) / lines;
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

  /// Edges between different regions; the strip counts as air.
  std::string outlines() const {
    const auto& m = field.problem().space().mesh;
    std::map<std::pair<int, int>, std::vector<int>> sides;
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const int region = m.region[t] == sim::CoreRegion::strip ? sim::CoreRegion::air : m.region[t];
        sides[std::minmax(m.triangle[t][k], m.triangle[t][(k + 1) % 3])].push_back(region);
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

std::string legend(double x, double y) {
  std::string out;
  constexpr double width = 14, height = 180;
  for (int k = 0; k < shades; ++k)
    out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.2f}\" fill=\"{}\"/>\n", x,
                       y + height * (shades - 1 - k) / shades, width, height / shades + 0.3,
                       colour((k + 0.5) / shades));
  for (const double b : {0.0, 0.6, 1.2, 1.8, 2.4})
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{:.1f} T</text>\n", x + width + 5,
                       y + height * (1 - b / largest_b) + 4, b);
  return out;
}

/// A surface over a square, seen from above the corner of small values.
struct Surface {
  double left, base;
  static constexpr double side = 190, height = 230;

  Point at(double u, double v, double w) const {
    return {left + (u - v) * side * 0.87 + side * 0.87, base + (u + v) * side * 0.42 - w * height};
  }
};

std::string surface_svg(const Surface& s, int cells, const std::function<double(double, double)>& value,
                        const char* title, const char* u_name, const char* v_name, const std::string& top) {
  std::vector<double> grid;
  double largest = 1e-300;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      grid.push_back(value(static_cast<double>(i) / cells, static_cast<double>(j) / cells));
      largest = std::max(largest, grid.back());
    }
  const auto w = [&](int i, int j) {
    return std::max(0.0, grid[static_cast<std::size_t>(j * (cells + 1) + i)] / largest);
  };
  std::string out;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const double n = cells;
      out += "<path d=\"";
      const std::array<std::array<int, 2>, 4> corners{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
      for (std::size_t k = 0; k < 4; ++k) {
        const auto [ci, cj] = corners[k];
        const Point p = s.at(ci / n, cj / n, w(ci, cj));
        out += fmt::format("{}{:.1f} {:.1f}", k == 0 ? 'M' : 'L', p.x, p.y);
      }
      out += fmt::format("Z\" fill=\"{}\" stroke=\"#444\" stroke-width=\"0.3\"/>\n",
                         colour((w(i, j) + w(i + 1, j) + w(i, j + 1) + w(i + 1, j + 1)) / 4));
    }
  const double front = s.base + 2 * Surface::side * 0.42;
  out +=
      fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">left edge: {}</text>\n", s.left + 10, front + 26, u_name);
  out +=
      fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">right edge: {}</text>\n", s.left + 10, front + 44, v_name);
  const Point top_of = s.at(0.5, 0.5, 0);
  out += fmt::format(
      "<text x=\"{:.0f}\" y=\"52\" text-anchor=\"middle\" font-weight=\"bold\">{}, up to {}</text>\n",
      top_of.x, title, fmt::format(fmt::runtime(top), largest));
  return out;
}

}  // namespace

std::string field_svg(const sim::MagnetField& field, const sim::FieldPoint& point, const std::string& title) {
  FieldPicture half{field, point.a, field.problem().gap() / sim::strip_height};
  half.draw();
  const double x = (half.right * 1e3 + margin_mm) * pixels_per_mm,
               y = (half.top * 1e3 + margin_mm) * pixels_per_mm;
  const double height = ((half.top - half.bottom) * 1e3 + 2 * margin_mm) * pixels_per_mm;
  std::string body = "<g id=\"half\">\n";
  for (const auto& [shade, path] : half.fills) {
    const auto c = colour((shade + 0.5) / shades);
    body += fmt::format("<path d=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"0.4\"/>\n", path, c, c);
  }
  body += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#222\" stroke-width=\"0.7\"/>\n", half.contours);
  body += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.3\"/>\n</g>\n",
                      half.outlines());
  const double top_room = 34, legend_room = 80;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"{2:.0f} {3:.0f} {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"13\">\n",
      2 * x + legend_room, height + top_room, -x, -y - top_room);
  svg += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n", -x,
                     -y - top_room);
  svg += fmt::format(
      "<clipPath id=\"frame\"><rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" "
      "height=\"{:.0f}\"/></clipPath>\n",
      -x, -y, 2 * x, height);
  svg += "<g clip-path=\"url(#frame)\">\n" + body +
         "<use xlink:href=\"#half\" transform=\"scale(-1,1)\"/>\n</g>\n";
  svg +=
      fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" font-weight=\"bold\">{}</text>\n", -x + 8, -y - 12, title);
  svg += legend(x + 14, -y + 20);
  return svg + "</svg>\n";
}

std::string table_svg(const sim::TablePotential& t, const std::string& title) {
  constexpr int cells = 40;
  const double psi = t.table().psi.back(), gap = t.table().gap.back();
  const auto state = [&](double u, double v) {
    // the ring flux in step with the coil's
    const double ring = t.has_ring() ? t.table().ring.back() * u : 0;
    return t.at({psi * u, ring, gap * (1 - v)});
  };
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"780\" height=\"520\" viewBox=\"0 0 780 520\" "
      "font-family=\"sans-serif\" "
      "font-size=\"12\">\n<rect width=\"780\" height=\"520\" fill=\"#fff\"/>\n";
  svg += fmt::format("<text x=\"12\" y=\"22\" font-weight=\"bold\" font-size=\"14\">{}</text>\n", title);
  const std::string psi_name = fmt::format("flux linkage, 0 .. {:.3g} Wb", psi);
  const std::string gap_name = fmt::format("gap, {:.3g} mm (behind) .. 0", gap * 1e3);
  svg += surface_svg(
      {20, 300}, cells, [&](double u, double v) { return std::log1p(state(u, v).current / 0.02); },
      "log(1 + i / 20 mA)", psi_name.c_str(), gap_name.c_str(), "{:.2f}");
  svg += surface_svg(
      {410, 300}, cells, [&](double u, double v) { return state(u, v).pull; }, "pull", psi_name.c_str(),
      gap_name.c_str(), "{:.0f} N");
  return svg + "</svg>\n";
}

}  // namespace powbench::host
