#include "host/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/report/number.h"

namespace powbench::host {
namespace {

/// A length with one decimal: a tenth of a user unit is finer than any printer.
std::string len(double v) {
  std::string s = fmt::format("{:.1f}", v);
  if (s.ends_with(".0")) s.resize(s.size() - 2);
  return s == "-0" ? "0" : s;
}

std::string pair(double x, double y) {
  return len(x) + " " + len(y);
}

/// Of a text in UTF-8.
std::ptrdiff_t characters(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

void draw_marker(Markup& out, double x, double y, const Marker& m) {
  const double r = m.size;
  const std::string_view fill = m.filled ? m.color : std::string_view("#ffffff");
  const std::string opacity = fmt::format("{:.2f}", m.opacity);
  std::string d;
  switch (m.shape) {
    case Shape::circle:
      out.empty("circle", {{"cx", len(x)},
                           {"cy", len(y)},
                           {"r", len(r)},
                           {"fill", fill},
                           {"stroke", m.color},
                           {"stroke-width", "1.3"},
                           {"opacity", opacity}});
      return;
    case Shape::square:
      d = fmt::format("M{}h{}v{}h{}Z", pair(x - r, y - r), len(2 * r), len(2 * r), len(-2 * r));
      break;
    case Shape::triangle:
      d = fmt::format("M{}L{}L{}Z", pair(x, y - 1.2 * r), pair(x + 1.1 * r, y + 0.8 * r),
                      pair(x - 1.1 * r, y + 0.8 * r));
      break;
    case Shape::diamond:
      d = fmt::format("M{}L{}L{}L{}Z", pair(x, y - 1.3 * r), pair(x + 1.3 * r, y), pair(x, y + 1.3 * r),
                      pair(x - 1.3 * r, y));
      break;
  }
  out.empty("path",
            {{"d", d}, {"fill", fill}, {"stroke", m.color}, {"stroke-width", "1.3"}, {"opacity", opacity}});
}

}  // namespace

Plot::Plot(Box box, Range x, Range y)
    : box_(box),
      x_(x.empty() || !(x.span() > 0) ? x.padded(0) : x),
      y_(y.empty() || !(y.span() > 0) ? y.padded(0) : y) {}

double Plot::px(double x) const {
  const double p = box_.left + (x - x_.low) / x_.span() * box_.width;
  return std::clamp(p, box_.left - box_.width, box_.left + 2 * box_.width);
}

double Plot::py(double y) const {
  const double p = box_.top + box_.height - (y - y_.low) / y_.span() * box_.height;
  return std::clamp(p, box_.top - box_.height, box_.top + 2 * box_.height);
}

bool Plot::visible(double x) const {
  return x >= x_.low && x <= x_.high;
}

void Plot::path(std::string_view d, const Stroke& s) {
  inside_.empty("path", {{"d", d},
                         {"fill", "none"},
                         {"stroke", s.color},
                         {"stroke-width", fmt::format("{:.2f}", s.width)},
                         {"stroke-opacity", fmt::format("{:.2f}", s.opacity)},
                         {"stroke-dasharray", s.dash.empty() ? std::string_view("none") : s.dash},
                         {"stroke-linejoin", "round"}});
}

void Plot::grid(const Ticks& x_ticks, const Ticks& y_ticks) {
  std::string d;
  for (const double x : x_ticks.at) d += fmt::format("M{}v{}", pair(px(x), box_.top), len(box_.height));
  for (const double y : y_ticks.at) d += fmt::format("M{}h{}", pair(box_.left, py(y)), len(box_.width));
  path(d, {colour::grid, 1});
}

void Plot::bar(double x0, double x1, double y0, double y1, std::string_view color, double opacity) {
  if (!std::isfinite(x0) || !std::isfinite(x1) || !std::isfinite(y0) || !std::isfinite(y1)) return;
  inside_.empty("rect", {{"x", len(px(std::min(x0, x1)))},
                         {"y", len(py(std::max(y0, y1)))},
                         {"width", len(std::fabs(px(x1) - px(x0)))},
                         {"height", len(std::fabs(py(y1) - py(y0)))},
                         {"fill", color},
                         {"fill-opacity", fmt::format("{:.2f}", opacity)}});
}

void Plot::shade_x(double from, double to, std::string_view color, double opacity) {
  bar(from, to, y_.low, y_.high, color, opacity);
}

void Plot::shade_y(double from, double to, std::string_view color, double opacity) {
  bar(x_.low, x_.high, from, to, color, opacity);
}

void Plot::vertical(double x, const Stroke& stroke) {
  if (std::isfinite(x)) path(fmt::format("M{}v{}", pair(px(x), box_.top), len(box_.height)), stroke);
}

void Plot::horizontal(double y, const Stroke& stroke) {
  if (std::isfinite(y)) path(fmt::format("M{}h{}", pair(box_.left, py(y)), len(box_.width)), stroke);
}

void Plot::trace(const std::vector<TracePoint>& points, double y_scale, const Stroke& stroke) {
  std::string d;
  for (const auto& p : points) {
    if (!std::isfinite(p.t) || !std::isfinite(p.value)) continue;
    d += p.starts || d.empty() ? "M" : " ";
    d += pair(px(p.t), py(p.value * y_scale));
  }
  if (!d.empty()) path(d, stroke);
}

void Plot::line(const std::vector<XY>& points, const Stroke& stroke) {
  std::string d;
  for (const auto& p : points)
    if (std::isfinite(p.x) && std::isfinite(p.y))
      d += fmt::format("{}{}", d.empty() ? "M" : "L", pair(px(p.x), py(p.y)));
  if (!d.empty()) path(d, stroke);
}

void Plot::band(const std::vector<XY>& points, const std::vector<double>& half, std::string_view color,
                double opacity) {
  std::string d, back;
  const auto close = [&] {
    if (!back.empty()) d += back + "Z";
    back.clear();
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const XY& p = points[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(half[i])) {
      close();
      continue;
    }
    d += (back.empty() ? "M" : "L") + pair(px(p.x), py(p.y + half[i]));
    back = "L" + pair(px(p.x), py(p.y - half[i])) + back;
  }
  close();
  if (!d.empty())
    inside_.empty("path", {{"d", d}, {"fill", color}, {"fill-opacity", fmt::format("{:.2f}", opacity)}});
}

void Plot::error_bar(XY at, double half_height, const Stroke& stroke) {
  if (!std::isfinite(at.x) || !std::isfinite(at.y) || !(half_height > 0) || !std::isfinite(half_height))
    return;
  constexpr double cap = 3.5;
  const double x = px(at.x), top = box_.top, bottom = box_.top + box_.height;
  const double high = py(at.y + half_height), low = py(at.y - half_height);
  // an end outside of the frame is an arrow at the frame
  const auto end = [&](double y, double edge, double inwards) {
    return (y - edge) * inwards >= 0 ? fmt::format("M{}h{}", pair(x - cap, y), len(2 * cap))
                                     : fmt::format("M{}L{}L{}", pair(x - cap, edge + 2 * inwards * cap),
                                                   pair(x, edge), pair(x + cap, edge + 2 * inwards * cap));
  };
  path(end(high, top, 1) + fmt::format("M{}V{}", pair(x, std::max(high, top)), len(std::min(low, bottom))) +
           end(low, bottom, -1),
       stroke);
}

void Plot::point(XY at, const Marker& marker) {
  if (std::isfinite(at.x) && std::isfinite(at.y)) draw_marker(inside_, px(at.x), py(at.y), marker);
}

void Plot::frame() {
  outside_.empty("rect", {{"x", len(box_.left)},
                          {"y", len(box_.top)},
                          {"width", len(box_.width)},
                          {"height", len(box_.height)},
                          {"fill", "none"},
                          {"stroke", colour::frame}});
}

void Plot::x_labels(const Ticks& ticks, std::string_view title, std::string_view suffix) {
  const double y = box_.top + box_.height + 17;
  for (const double x : ticks.at)
    outside_.element("text", fixed(x, ticks.decimals) + std::string(suffix),
                     {{"x", len(px(x))}, {"y", len(y)}, {"text-anchor", "middle"}});
  outside_.element(
      "text", title,
      {{"x", len(box_.left + box_.width)}, {"y", len(y + 18)}, {"text-anchor", "end"}, {"class", "t"}});
}

void Plot::y_labels(const Ticks& ticks, std::string_view title) {
  std::ptrdiff_t longest = 1;
  for (const double y : ticks.at) longest = std::max(longest, characters(fixed(y, ticks.decimals)));
  constexpr double room = 5;  // characters beside the title; more are made smaller
  const std::string size = fmt::format("{:.0f}%", 100 * std::min(1.0, room / static_cast<double>(longest)));
  outside_.open("g", {{"text-anchor", "end"}, {"font-size", size}});
  for (const double y : ticks.at)
    outside_.element("text", fixed(y, ticks.decimals), {{"x", len(box_.left - 8)}, {"y", len(py(y) + 4)}});
  outside_.close();
  const double x = box_.left - 50, y = box_.top + box_.height / 2;
  outside_.element("text", title,
                   {{"transform", fmt::format("translate({} {}) rotate(-90)", len(x), len(y))},
                    {"text-anchor", "middle"},
                    {"class", "t"}});
}

void Plot::note(double x, std::string_view text, std::string_view color, int row) {
  if (!std::isfinite(x) || !visible(x)) return;
  outside_.element("text", text,
                   {{"x", len(px(x))},
                    {"y", len(box_.top - 6 - 15 * row)},
                    {"text-anchor", "middle"},
                    {"style", fmt::format("fill: {}", color)}});
}

void Plot::text_left(double y, std::string_view text) {
  outside_.element("text", text, {{"x", len(box_.left - 8)}, {"y", len(py(y) + 4)}, {"text-anchor", "end"}});
}

void Plot::legend(const std::vector<LegendEntry>& entries, double height_above) {
  constexpr double per_character = 7.6, sample = 24, space = 18;
  double width = 0;
  for (const auto& e : entries)
    width += sample + 6 + per_character * static_cast<double>(characters(e.text)) + space;
  double x = box_.left + box_.width - width + space;
  const double y = box_.top - height_above;
  for (const auto& e : entries) {
    if (e.has_line)
      outside_.empty(
          "path", {{"d", fmt::format("M{}h{}", pair(x, y - 4), len(sample))},
                   {"stroke", e.stroke.color},
                   {"stroke-width", fmt::format("{:.2f}", e.stroke.width)},
                   {"stroke-opacity", fmt::format("{:.2f}", e.stroke.opacity)},
                   {"stroke-dasharray", e.stroke.dash.empty() ? std::string_view("none") : e.stroke.dash}});
    if (e.has_marker) draw_marker(outside_, x + sample / 2, y - 4, e.marker);
    outside_.element("text", e.text, {{"x", len(x + sample + 6)}, {"y", len(y)}});
    x += sample + 6 + per_character * static_cast<double>(characters(e.text)) + space;
  }
}

Markup Plot::finish() const {
  Markup out;
  // An inner <svg> clips to its own box without needing a name that is unique in the page.
  out.open("svg",
           {{"x", len(box_.left)},
            {"y", len(box_.top)},
            {"width", len(box_.width)},
            {"height", len(box_.height)},
            {"viewBox", fmt::format("{} {}", pair(box_.left, box_.top), pair(box_.width, box_.height))}});
  out.embed(inside_).close();
  out.open("g").embed(outside_).close();
  return out;
}

Markup figure(double width, double height, std::string_view title, const std::vector<Markup>& panels) {
  Markup out;
  out.open("svg", {{"xmlns", "http://www.w3.org/2000/svg"},
                   {"viewBox", fmt::format("0 0 {}", pair(width, height))},
                   {"role", "img"},
                   {"class", "plot"}});
  out.element("title", title);
  for (const auto& panel : panels) out.embed(panel);
  out.close();
  return out;
}

std::string standing_alone(std::string svg, std::string_view about) {
  Markup line;
  line.open("text", {{"x", "74"}, {"y", "16"}, {"font-size", "13"}, {"fill", colour::ink}});
  line.text(about);
  line.close();
  svg.insert(svg.rfind("</svg>"), line.str());
  return svg.insert(svg.find(' '),
                    " font-family=\"Arial, Liberation Sans, DejaVu Sans, sans-serif\" font-size=\"12\" "
                    "style=\"background:#fff\"");
}

}  // namespace powbench::host
