#include "host/export/surface_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/export/colour_scale.h"

namespace powbench::host {
namespace {

struct Point {
  double x, y;
};

/// Shares along x, y, z to the picture.
Point place(double x, double y, double z) {
  constexpr double centre = 225, base = 225, half_width = 155, half_depth = 72, height = 165;
  return {centre + (y - x) * half_width, base + (2 - x - y) * half_depth - z * height};
}

std::string line(Point a, Point b, const char* colour) {
  return fmt::format(
      "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" stroke-width=\"0.8\" fill=\"none\"/>\n", a.x,
      a.y, b.x, b.y, colour);
}

std::string label(Point at, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", at.x, at.y, anchor,
                     text);
}

/// Floor, both walls behind, and lines on them at the ticks.
std::string box(const SurfacePlot& p) {
  constexpr const char *grid = "#ccc", *frame = "#555";
  std::string out;
  for (const double t : p.x.ticks(5)) {
    const double s = p.x.share(t);
    out += line(place(s, 0, 0), place(s, 1, 0), grid) + line(place(s, 1, 0), place(s, 1, 1), grid);
    const Point end = place(s, 0, 0);
    out += line(end, {end.x - 5, end.y + 3}, frame) +
           label({end.x - 8, end.y + 14}, "end", fmt::format("{:g}", t));
  }
  for (const double t : p.y.ticks(5)) {
    const double s = p.y.share(t);
    out += line(place(0, s, 0), place(1, s, 0), grid) + line(place(1, s, 0), place(1, s, 1), grid);
    const Point end = place(0, s, 0);
    out += line(end, {end.x + 5, end.y + 3}, frame) +
           label({end.x + 8, end.y + 14}, "start", fmt::format("{:g}", t));
  }
  for (const double t : p.z.ticks(6)) {
    const double s = p.z.share(t);
    out += line(place(1, 0, s), place(1, 1, s), grid) + line(place(1, 1, s), place(0, 1, s), grid);
    const Point end = place(1, 0, s);
    out +=
        line(end, {end.x - 5, end.y}, frame) + label({end.x - 8, end.y + 4}, "end", fmt::format("{:g}", t));
  }
  const Point left = place(0.5, 0, 0), right = place(0, 0.5, 0), high = place(1, 0, 1);
  out += label({left.x - 42, left.y + 42}, "middle", p.x.label);
  out += label({right.x + 42, right.y + 42}, "middle", p.y.label);
  out += label({high.x - 30, high.y - 12}, "start", p.z.label);
  out += line(place(1, 0, 0), place(0, 0, 0), frame) + line(place(0, 0, 0), place(0, 1, 0), frame) +
         line(place(1, 0, 0), place(1, 0, 1), frame);
  return out;
}

}  // namespace

double SurfaceAxis::share(double v) const {
  return bend > 0 ? std::log1p(std::fmax(0, v) / bend) / std::log1p(high / bend) : (v - low) / (high - low);
}

double SurfaceAxis::value(double s) const {
  return bend > 0 ? bend * std::expm1(s * std::log1p(high / bend)) : low + s * (high - low);
}

std::vector<double> SurfaceAxis::ticks(int most) const {
  std::vector<double> list;
  constexpr double round_off = 1e-9;
  if (bend > 0) {
    list.push_back(0);
    const double apart = 0.8 / most;
    for (int d = static_cast<int>(std::floor(std::log10(bend))) - 1; d <= std::log10(high); ++d)
      for (const double m : {1.0, 2.0, 5.0}) {
        const double v = m * std::pow(10.0, d);
        if (v <= high * (1 + round_off) && share(v) >= share(list.back()) + apart) list.push_back(v);
      }
    return list;
  }
  const double rough = (high - low) / most, power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double m : {5.0, 2.0, 1.0})
    if (m * power >= rough * (1 - round_off)) step = m * power;
  for (double k = std::ceil(low / step - round_off); k * step <= high + round_off * step; ++k)
    list.push_back(k * step + 0.0);  // no -0
  return list;
}

std::string surface_svg(const SurfacePlot& given, double left, double top) {
  SurfacePlot p = given;
  const int n = p.cells;
  std::vector<double> grid;
  p.z.low = 0;
  p.z.high = 1e-300;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double v = p.value(p.x.value(static_cast<double>(i) / n), p.y.value(static_cast<double>(j) / n));
      grid.push_back(std::isfinite(v) ? std::fmax(0, v) : 0);
      p.z.high = std::max(p.z.high, grid.back());
    }
  const auto height = [&](int i, int j) {
    return p.z.share(grid[static_cast<std::size_t>(j * (n + 1) + i)]);
  };
  std::string out = fmt::format("<g transform=\"translate({:.0f},{:.0f})\">\n", left, top) + box(p);
  out += "<g stroke=\"#333\" stroke-width=\"0.35\" stroke-linejoin=\"round\">\n";
  for (int far = 2 * (n - 1); far >= 0; --far)
    for (int i = std::max(0, far - n + 1); i <= std::min(far, n - 1); ++i) {
      const int j = far - i;
      const std::array<std::array<int, 2>, 4> corners{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
      std::string path;
      double mean = 0;
      for (const auto& [a, b] : corners) {
        const Point at = place(static_cast<double>(a) / n, static_cast<double>(b) / n, height(a, b));
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', at.x, at.y);
        mean += height(a, b) / 4;
      }
      out += fmt::format("<path d=\"{}Z\" fill=\"{}\"/>\n", path, scale_colour(0.08 + 0.92 * mean));
    }
  out += "</g>\n" +
         fmt::format("<text x=\"{:.0f}\" y=\"18\" text-anchor=\"middle\" font-weight=\"bold\">{}</text>\n",
                     surface_width / 2, p.title);
  return out + "</g>\n";
}

}  // namespace powbench::host
