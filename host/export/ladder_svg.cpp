#include "host/export/ladder_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace powbench::host {
namespace {

constexpr double left = 80, right = 700, top = 50, bottom = 420;
constexpr std::array<const char*, 4> colours{"#0b6fa4", "#c2410c", "#15803d", "#7e22ce"};

/// A logarithmic axis: whole decades, or steps of 1, 2, 5 where the span is short.
struct LogAxis {
  double low = 1e300, high = 0;

  void include(double v) {
    if (!(v > 0) || !std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  void widen(double factor) {
    if (high < low) low = high = 1;
    low /= factor;
    high *= factor;
  }
  double share(double v) const { return std::log(v / low) / std::log(high / low); }
  std::vector<double> ticks() const {
    std::vector<double> list;
    const bool dense = high / low < 200;
    for (int d = static_cast<int>(std::floor(std::log10(low))); d <= std::log10(high); ++d)
      for (const double m : {1.0, 2.0, 5.0}) {
        const double v = m * std::pow(10.0, d);
        if ((m == 1 || dense) && v >= low && v <= high) list.push_back(v);
      }
    return list;
  }
};

struct Point {
  double cost, error, estimate;  // ms, us, us
};

std::string line(const std::vector<Point>& points, double Point::*value, const LogAxis& x, const LogAxis& y,
                 const char* colour, bool dashed) {
  std::string path;
  std::string marks;
  for (const auto& p : points) {
    const double v = p.*value;
    if (!(v > 0) || !std::isfinite(v)) continue;
    const double px = left + x.share(p.cost) * (right - left);
    const double py = bottom - y.share(v) * (bottom - top);
    path += fmt::format("{:.1f},{:.1f} ", px, py);
    if (!dashed)
      marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", px, py, colour);
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n", path,
                     colour, dashed ? " stroke-dasharray=\"5 4\"" : "") +
         marks;
}

std::string frame(const LogAxis& x, const LogAxis& y) {
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
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">CPU time of a closing, ms</text>\n",
                     (left + right) / 2, bottom + 42);
  svg += fmt::format(
      "<text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">worst of touch, seat, "
      "settled, "
      "us</text>\n",
      (top + bottom) / 2);
  return svg;
}

}  // namespace

std::string ladder_svg(const sim::Ladder& ladder, std::span<const sim::Rung> rungs,
                       const std::string& title) {
  LogAxis x;
  LogAxis y;
  std::vector<std::vector<Point>> lines(rungs.size());
  for (const auto& row : ladder.rows) {
    const Point p{row.run.cpu * 1e3, sim::largest(row.error) * 1e6, sim::largest(row.estimate) * 1e6};
    lines[row.run.rung].push_back(p);
    x.include(p.cost);
    y.include(p.error);
    y.include(p.estimate);
  }
  x.widen(1.15);
  y.widen(2);
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"720\" height=\"480\" viewBox=\"0 0 720 480\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"720\" height=\"480\" fill=\"#fff\"/>\n";
  svg +=
      fmt::format("<text x=\"{}\" y=\"28\" font-weight=\"bold\" font-size=\"14\">{}</text>\n", left, title);
  svg += frame(x, y);
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    const char* colour = colours[r % colours.size()];
    svg += line(lines[r], &Point::error, x, y, colour, false);
    svg += line(lines[r], &Point::estimate, x, y, colour, true);
    svg += fmt::format(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{}\">{}: error, dashed its estimate</text>\n",
        right - 10, top + 20 + 18 * static_cast<double>(r), colour, rungs[r].name());
  }
  return svg + "</svg>\n";
}

}  // namespace powbench::host
