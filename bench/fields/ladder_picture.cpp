#include "bench/fields/ladder_picture.h"

#include <fmt/format.h>

#include <array>

#include "host/export/log_axis.h"

namespace powbench::bench {
namespace {

constexpr double width = 330, height = 300, left = 62, top = 52, pitch = 410;
constexpr std::array<const char*, 5> colours{"#0b6fa4", "#c2410c", "#15803d", "#7e22ce", "#444"};

/// One panel's axes and where its corner lies.
struct Frame {
  host::LogAxis x, y;
  double origin;

  double across(double v) const { return origin + x.share(v) * width; }
  double up(double v) const { return top + height - y.share(v) * height; }
};

Frame frame_of(const LadderPanel& panel, std::size_t number) {
  Frame f{{}, {}, left + pitch * static_cast<double>(number)};
  for (const auto& line : panel.lines)
    for (const auto& p : line.points) {
      f.x.include(p.cost);
      f.y.include(p.to_space);
      f.y.include(p.to_finest);
    }
  f.x.widen(2);
  f.y.widen(2);
  return f;
}

std::string axes(const Frame& f, const LadderPanel& panel) {
  std::string svg =
      fmt::format("<rect x=\"{:.1f}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>\n",
                  f.origin, top, width, height);
  for (const double v : f.x.ticks())
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1} V{2}\" stroke=\"#ddd\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:g}</text>\n",
        f.across(v), top, top + height, top + height + 16, v);
  for (const double v : f.y.ticks())
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1:.1f} H{2:.1f}\" stroke=\"#ddd\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:g}</text>\n",
        f.origin, f.up(v), f.origin + width, f.origin - 5, f.up(v) + 4, v);
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" font-weight=\"bold\">{}</text>\n", f.origin, top - 8,
                     panel.title + ", " + panel.ordinate);
  return svg + fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                           f.origin + width / 2, top + height + 36, panel.abscissa);
}

std::string curve(const Frame& f, const LadderLine& line, double LadderPoint::*value, const char* colour,
                  bool dashed) {
  std::string path, marks;
  for (const auto& p : line.points) {
    if (!(p.*value > 0)) continue;
    const double x = f.across(p.cost), y = f.up(p.*value);
    path += fmt::format("{:.1f},{:.1f} ", x, y);
    marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\" stroke=\"{}\"/>\n", x, y,
                         dashed ? "#fff" : colour, colour);
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"{}/>\n", path,
                     colour, dashed ? " stroke-dasharray=\"5 4\"" : "") +
         marks;
}

}  // namespace

std::string ladder_picture(const std::vector<LadderPanel>& panels, const std::string& title) {
  const double whole = left + pitch * static_cast<double>(panels.size());
  constexpr double bottom = top + height + 84;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n"
      "<text x=\"{2}\" y=\"22\" font-size=\"14\" font-weight=\"bold\">{3}</text>\n",
      whole, bottom, left, title);
  for (std::size_t n = 0; n < panels.size(); ++n) {
    const Frame f = frame_of(panels[n], n);
    svg += axes(f, panels[n]);
    for (std::size_t k = 0; k < panels[n].lines.size(); ++k) {
      const char* colour = colours[k % colours.size()];
      svg += curve(f, panels[n].lines[k], &LadderPoint::to_finest, colour, true);
      svg += curve(f, panels[n].lines[k], &LadderPoint::to_space, colour, false);
    }
  }
  double x = left;
  for (std::size_t k = 0; k < panels.front().lines.size(); ++k) {
    const auto& name = panels.front().lines[k].rung;
    svg += fmt::format(
        "<circle cx=\"{0:.0f}\" cy=\"{1}\" r=\"4\" fill=\"{2}\"/><text x=\"{3:.0f}\" y=\"{4}\">{5}</text>\n",
        x, bottom - 20, colours[k % colours.size()], x + 9, bottom - 16, name);
    x += 30 + 7.5 * static_cast<double>(name.size());
  }
  svg += fmt::format(
      "<text x=\"{:.0f}\" y=\"{}\">full: against the field in three dimensions; dashed: against the finest "
      "of "
      "its kind</text>\n",
      x + 20, bottom - 16);
  return svg + "</svg>\n";
}

}  // namespace powbench::bench
