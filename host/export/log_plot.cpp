#include "host/export/log_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/export/log_axis.h"

namespace powbench::host {
namespace {

constexpr double left = 80, right = 700, top = 50, bottom = 420;
constexpr std::array<const char*, 10> colours{"#0b6fa4", "#c2410c", "#15803d", "#7e22ce", "#b45309",
                                              "#0e7490", "#be123c", "#4d7c0f", "#1d4ed8", "#78716c"};

std::string line(const LogLine& l, const LogAxis& x, const LogAxis& y, const char* colour) {
  std::string path;
  std::string marks;
  for (const auto& p : l.points) {
    if (!(p.y > 0) || !std::isfinite(p.y)) continue;
    const double px = left + x.share(p.x) * (right - left);
    const double py = bottom - y.share(p.y) * (bottom - top);
    path += fmt::format("{:.1f},{:.1f} ", px, py);
    if (!l.dashed)
      marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", px, py, colour);
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n", path,
                     colour, l.dashed ? " stroke-dasharray=\"5 4\"" : "") +
         marks;
}

std::string frame(const LogAxis& x, const LogAxis& y, const LogPlot& plot) {
  std::string svg;
  for (const double v : x.ticks()) {
    const double px = left + x.share(v) * (right - left);
    svg += fmt::format("<path d=\"M{0:.1f} {1} V{2}\" stroke=\"#ddd\"/>\n", px, top, bottom);
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>\n", px, bottom + 18, v);
  }
  for (const double v : y.ticks()) {
    const double py = bottom - y.share(v) * (bottom - top);
    svg += fmt::format("<path d=\"M{0} {1:.1f} H{2}\" stroke=\"#ddd\"/>\n", left, py, right);
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n", left - 6, py + 4, v);
  }
  svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>\n",
                     left, top, right - left, bottom - top);
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", (left + right) / 2,
                     bottom + 42, plot.x_label);
  svg += fmt::format("<text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (top + bottom) / 2, plot.y_label);
  return svg;
}

}  // namespace

std::string log_plot_svg(const LogPlot& plot) {
  LogAxis x;
  LogAxis y;
  for (const auto& l : plot.lines) {
    for (const auto& p : l.points) {
      x.include(p.x);
      y.include(p.y);
    }
  }
  x.widen(1.15);
  y.widen(2);
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" height=\"480\" viewBox=\"0 0 900 480\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"900\" height=\"480\" fill=\"#fff\"/>\n";
  svg += fmt::format("<text x=\"{}\" y=\"28\" font-weight=\"bold\" font-size=\"14\">{}</text>\n", left,
                     plot.title);
  svg += frame(x, y, plot);
  double place = top + 20;
  for (const auto& l : plot.lines) {
    const char* colour = colours[static_cast<std::size_t>(l.colour) % colours.size()];
    svg += line(l, x, y, colour);
    if (l.name.empty()) continue;
    svg += fmt::format(
        "<path d=\"M{} {} h22\" stroke=\"{}\" stroke-width=\"2.5\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
        right + 18, place - 4, colour, right + 46, place, l.name);
    place += 20;
  }
  place = bottom + 2 - 16 * static_cast<double>(plot.notes.size());
  for (const auto& note : plot.notes) {
    svg += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"#555\">{}</text>\n", right + 18, place, note);
    place += 16;
  }
  return svg + "</svg>\n";
}

}  // namespace powbench::host
