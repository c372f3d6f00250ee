#include "bench/space/picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "bench/space/probe.h"

namespace powbench::bench {
namespace {

constexpr double scale = 9;      // pixels a mm
constexpr double cell = 0.4e-3;  // m, of the picture
constexpr double top_field = 1.8;
constexpr int shades = 36;

/// Blue, green, yellow, red by |B| / top_field on a square-root scale, so that air shows too.
std::string colour(int shade) {
  const double t = static_cast<double>(shade) / (shades - 1);
  constexpr double stops[5][3] = {
      {20, 22, 60}, {33, 102, 172}, {92, 184, 136}, {250, 214, 90}, {190, 30, 45}};
  const double at = 4 * t;
  const int k = std::min(3, static_cast<int>(at));
  char text[8];
  int rgb[3];
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(std::lround(stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c])));
  std::snprintf(text, sizeof text, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text;
}

int shade_of(double b) {
  return std::clamp(static_cast<int>(std::sqrt(b / top_field) * shades), 0, shades - 1);
}

std::string printed(const char* format, double a, double b, double c = 0, double d = 0) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b, c, d);
  return text;
}

struct Panel {
  double left;                                     ///< pixels
  double width, low, high;                         ///< m: horizontally from 0; vertically
  std::function<sim::Vec3(double, double)> point;  ///< of the plane's coordinates
};

void paint(std::string& svg, const Panel& panel, const bench::Probe& probe) {
  const double height = panel.high - panel.low;
  const int columns = static_cast<int>(panel.width / cell), rows = static_cast<int>(height / cell);
  const double pixel = cell * 1e3 * scale;
  for (int r = 0; r < rows; ++r) {
    const double z = panel.high - (r + 0.5) * cell;
    int run_shade = -1, run_from = 0;
    for (int c = 0; c <= columns; ++c) {  // equal neighbours become one rectangle
      int shade = -2;
      if (c < columns) {
        const auto b = probe.at(panel.point((c + 0.5) * cell, z)).b;
        shade = shade_of(std::hypot(b[0], b[1], b[2]));
      }
      if (shade == run_shade) continue;
      if (run_shade >= 0)
        svg += printed("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' ", panel.left + run_from * pixel,
                       60 + r * pixel, (c - run_from) * pixel + 0.3, pixel + 0.3) +
               "fill='" + colour(run_shade) + "'/>\n";
      run_shade = shade;
      run_from = c;
    }
  }
}

/// Outline of a box in the panel.
void frame(std::string& svg, const Panel& p, double x1, double x2, double z1, double z2, const char* style) {
  svg += printed("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' ", p.left + x1 * 1e3 * scale,
                 60 + (p.high - z2) * 1e3 * scale, (x2 - x1) * 1e3 * scale, (z2 - z1) * 1e3 * scale) +
         "fill='none' " + style + "/>\n";
}

void label(std::string& svg, double x, double y, const std::string& text, const char* more = "") {
  svg += printed("<text x='%.1f' y='%.1f' ", x, y) + more + ">" + text + "</text>\n";
}

void legend(std::string& svg, double x, double y) {
  for (int k = 0; k < shades; ++k)
    svg += printed("<rect x='%.1f' y='%.1f' width='16' height='%.1f' ", x, y + (shades - 1 - k) * 9.0, 9.3) +
           "fill='" + colour(k) + "'/>\n";
  for (const double b : {0.0, 0.05, 0.2, 0.5, 1.0, 1.4, 1.8})
    label(svg, x + 22, y + shades * 9 * (1 - std::sqrt(b / top_field)) + 4, printed("%.2f T", b, 0));
}

}  // namespace

std::string core_picture(const sim::space::MagnetField& field, const sim::space::FieldPoint& point,
                         const sim::MagnetDesign& design, double gap) {
  const auto& s = design.shape;
  const bench::Probe probe(field.function(), point.solution.state);
  const double bottom = -s.fixed_window - s.yoke, strip = gap + design.residual_gap;
  const double top = strip + s.moving_window + s.yoke, air = 6e-3;
  const double x1 = s.centre_width / 2, x2 = x1 + s.window_width, x3 = x2 + s.outer_width;
  const double coil = x1 + (s.window_width - s.coil_width) / 2, middle = x1 + s.window_width / 2;
  const double head = s.stack / 2 + coil - x1;
  const Panel side{20, x3 + air, bottom - air, top + air, [](double x, double z) {
                     return sim::Vec3{x, 1e-6, z};
                   }};
  const double second = 20 + side.width * 1e3 * scale + 40;
  const Panel end{second, head + s.coil_width + air, bottom - air, top + air, [middle](double y, double z) {
                    return sim::Vec3{middle, y, z};
                  }};
  const double wide = second + end.width * 1e3 * scale + 110,
               high = 80 + (top - bottom + 2 * air) * 1e3 * scale;
  std::string svg =
      printed("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' ", wide, high) +
      "font-family='sans-serif' font-size='13'>\n<rect width='100%' height='100%' fill='white'/>\n";
  char title[200];
  std::snprintf(title, sizeof title, "|B| at gap %.1f mm, %.2f A: pull %.1f N, %.3f Wb", gap * 1e3,
                point.response.current, point.response.pull, point.psi);
  label(svg, 20, 24, title, "font-size='15'");
  label(svg, side.left, 50, "middle of the stack: x from the axis, z up");
  label(svg, end.left, 50, "middle of the window: y along the stack, z up");
  paint(svg, side, probe);
  paint(svg, end, probe);
  const char* iron = "stroke='white' stroke-width='1.6'";
  const char* copper = "stroke='white' stroke-width='1.2' stroke-dasharray='5 3'";
  frame(svg, side, 0, x3, bottom, bottom + s.yoke, iron);
  frame(svg, side, 0, x1, bottom + s.yoke, -s.centre_gap, iron);
  frame(svg, side, x2, x3, bottom + s.yoke, 0, iron);
  frame(svg, side, 0, x1, strip, strip + s.moving_window, iron);
  frame(svg, side, x2, x3, strip, strip + s.moving_window, iron);
  frame(svg, side, 0, x3, top - s.yoke, top, iron);
  const double coil_low = bottom + s.yoke + s.coil_offset;
  frame(svg, side, coil, coil + s.coil_width, coil_low, coil_low + s.coil_height, copper);
  frame(svg, end, 0, s.stack / 2, bottom, bottom + s.yoke, iron);
  frame(svg, end, 0, s.stack / 2, top - s.yoke, top, iron);
  frame(svg, end, 0, head + s.coil_width, coil_low, coil_low + s.coil_height, copper);
  legend(svg, wide - 95, 80);
  return svg + "</svg>\n";
}

}  // namespace powbench::bench
