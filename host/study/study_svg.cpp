#include "host/study/study_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/counted.h"
#include "core/units.h"
#include "host/export/xml_text.h"
#include "host/report/plot.h"
#include "host/study/sweep_text.h"
#include "sim/study/modes.h"

namespace powbench::host {
namespace {

constexpr double width = 720, left = 70, inner = 620;

/// A panel over the whole width; grid and axes drawn, ready for data.
Plot panel(double top, double height, Range x, Range y, std::string_view x_title, std::string_view y_title,
           double angle_step = 0) {
  Plot p({left, top, inner, height}, x, y);
  const Ticks across = angle_step > 0 ? ticks_every(x, angle_step) : nice_ticks(x, 8), up = nice_ticks(y, 5);
  p.grid(across, up);
  p.frame();
  if (!x_title.empty()) p.x_labels(across, x_title);
  p.y_labels(up, y_title);
  return p;
}

/// A figure that also stands in a file of its own.
std::string file_of(double height, const std::string& title, const std::vector<Markup>& panels) {
  std::string svg = figure(width, height, title, panels).str();
  const std::string in_page = "class=\"plot\"";
  svg.replace(svg.find(in_page), in_page.size(), "font-family=\"sans-serif\" font-size=\"12\"");
  const auto body = svg.find('>', svg.find("<svg")) + 1;
  svg.insert(body, fmt::format("<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/><text x=\"{2}\" y=\"22\" "
                               "font-size=\"14\" font-weight=\"bold\" font-family=\"sans-serif\">{3}</text>",
                               width, height, left, escaped(title)));
  return svg;
}

std::size_t metric_number(std::string_view name) {
  for (std::size_t k = 0; k < sim::metric_table.size(); ++k)
    if (sim::metric_table[k].name == name) return k;
  return 0;
}

}  // namespace

std::string sweep_svg(const sim::Design& design, const std::vector<std::vector<double>>& rows) {
  std::size_t axis = 0;
  for (std::size_t k = 0; k < design.axes().size(); ++k)
    if (design.axes()[k].variable.name == "angle_deg") axis = k;
  const std::string& variable = design.axes()[axis].variable.name;
  std::vector<Markup> panels;
  double top = 50;
  for (const char* name : {"touch", "bounce"}) {
    const std::size_t metric = metric_number(name);
    Range x, y;
    std::vector<XY> points;
    for (std::size_t n = 0; n < rows.size(); ++n) {
      const XY p{design.point(static_cast<std::int64_t>(n))[axis],
                 rows[n][metric] * sim::metric_table[metric].per_si};
      if (!std::isfinite(p.y)) continue;
      points.push_back(p);
      x.include(p.x);
      y.include(p.y);
    }
    const bool last = std::string_view(name) == "bounce";
    Plot p = panel(top, 170, x.padded(0.02), y.padded(0.05), last ? variable : "",
                   fmt::format("{} / ms", name), variable == "angle_deg" && x.span() > 60 ? 30 : 0);
    for (const auto& at : points)
      p.point(at, {Shape::circle, last ? colour::simulated : colour::measured, 2.2, true, 0.6});
    panels.push_back(p.finish());
    top += 200;
  }
  return file_of(480, fmt::format("{} over {}", counted(rows.size(), "closing"), variable), panels);
}

std::string sensitivity_svg(std::span<const sim::Sensitivity> rows, const sim::MetricInfo& metric) {
  std::map<std::string, std::vector<double>> changes;
  std::vector<std::string> order;
  std::map<std::string, double> step;
  for (const auto& r : rows) {
    if (!changes.contains(r.name)) order.push_back(r.name);
    step[r.name] = r.step;
    auto& list = changes[r.name];
    for (const double v : {r.low, r.high})
      if (std::isfinite(v - r.centre)) list.push_back(std::fabs(v - r.centre) * metric.per_si);
  }
  Range x;
  x.include(0);
  for (auto& [name, list] : changes) {
    std::sort(list.begin(), list.end());
    if (!list.empty()) x.include(list.back());
  }
  const double count = static_cast<double>(order.size()), height = 36 * count;
  Plot p({left + 130, 60, inner - 130, height}, {0, x.high * 1.05}, {0, count});
  const Ticks ticks = nice_ticks({0, x.high * 1.05}, 6);
  p.grid(ticks, {});
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double y = count - 0.5 - static_cast<double>(k);
    const auto& list = changes[order[k]];
    p.text_left(y, order[k]);
    if (list.empty()) continue;
    p.bar(0, list.back(), y - 0.3, y + 0.3, colour::measured, 0.35);
    p.bar(0, sim::quantile_of_sorted(list, 0.5), y - 0.3, y + 0.3, colour::measured, 0.9);
  }
  p.frame();
  p.x_labels(ticks, fmt::format("change of {} / {}: dark median, pale largest over all angles and both sides",
                                metric.name, metric.unit));
  return file_of(height + 130, fmt::format("What moves the {}", metric.meaning), {p.finish()});
}

std::string best_angle_svg(const sim::BestAngle& best, const sim::MetricInfo& metric) {
  Range x{0, 180}, y;
  std::vector<XY> mean, low, high;
  for (std::size_t k = 0; k < best.angles.size(); ++k) {
    if (best.closed[k] == 0) continue;
    const double at = degrees(best.angles[k]);
    mean.push_back({at, best.mean[k] * metric.per_si});
    low.push_back({at, best.low[k] * metric.per_si});
    high.push_back({at, best.high[k] * metric.per_si});
    for (const double v : {low.back().y, high.back().y}) y.include(v);
  }
  Plot p({left, 60, inner, 300}, x, y.padded(0.08));
  const Ticks across = ticks_every(x, 30), up = nice_ticks(y.padded(0.08), 6);
  const double half = 90.0 / static_cast<double>(best.angles.size());
  for (std::size_t k = 0; k < best.angles.size(); ++k)
    if (const double at = degrees(best.angles[k]); best.mode_count[k] > 1)
      p.shade_x(at - half, at + half, colour::simulated, 0.18);
  p.grid(across, up);
  for (std::size_t k = 0; k < mean.size(); ++k)
    p.error_bar(mean[k], 0.5 * (high[k].y - low[k].y), {colour::frame, 1.5, 1.0, ""});
  p.line(mean, {colour::measured, 2.0, 1.0, ""});
  p.vertical(degrees(best.angles[best.best]), {colour::published, 1.5, 1.0, "5 4"});
  p.horizontal(best.random_mean * metric.per_si, {colour::soft, 1.2, 1.0, "2 3"});
  p.frame();
  p.x_labels(across,
             "closing angle / deg; shaded: more than one mode; dotted: closing at random; dashed: best");
  p.y_labels(up, fmt::format("{} / {}", metric.name, metric.unit));
  return file_of(430,
                 fmt::format("Best closing angle {:.0f} deg, {:.0f} % below closing at random",
                             degrees(best.angles[best.best]), 100 * best.gain),
                 {p.finish()});
}

std::string fit_svg(const std::vector<FitCell>& cells, const std::string& title) {
  std::vector<Markup> panels;
  double top = 60;
  const std::pair<const char*, const char*> rows[] = {{"t_ct1", "touch / ms"},
                                                      {"t_ct_bon", "bounce / ms"},
                                                      {"t_ct2", "settled / ms"},
                                                      {"t_xt1", "seat / ms"}};
  for (const auto& [quantity, name] : rows) {
    Range x, y;
    for (const auto& c : cells) {
      x.include(c.theta_deg);
      if (c.quantity != quantity) continue;
      // a fitted closing that never calms down would squeeze all others into one line
      for (const double v : {c.measured, c.held_out.low, c.held_out.high}) y.include(v * 1e3);
      if (std::isfinite(c.measured) && c.fitted < 1.5 * c.measured) y.include(c.fitted * 1e3);
    }
    const bool last = std::string_view(quantity) == "t_xt1";
    Plot p =
        panel(top, 120, x.padded(0.06, 15), y.padded(0.15, 0.5), last ? "closing angle / deg" : "", name, 30);
    for (const auto& c : cells) {
      if (c.quantity != quantity) continue;
      const double middle = 0.5 * (c.held_out.low + c.held_out.high),
                   half = 0.5 * (c.held_out.high - c.held_out.low);
      if (std::isfinite(middle))
        p.error_bar({c.theta_deg + 2, middle * 1e3}, half * 1e3, {colour::published, 1.5, 1.0, ""});
      p.point({c.theta_deg + 2, c.held_out.median * 1e3}, {Shape::triangle, colour::published, 4.5, true, 1});
      p.point({c.theta_deg, c.fitted * 1e3}, {Shape::square, colour::simulated, 4.0, false, 1});
      p.point({c.theta_deg, c.measured * 1e3}, {Shape::circle, colour::measured, 4.0, true, 1});
    }
    if (top < 100)
      p.legend(
          {{"measured", {}, false, {Shape::circle, colour::measured, 4, true, 1}, true},
           {"fitted", {}, false, {Shape::square, colour::simulated, 4, false, 1}, true},
           {"held out, band 16 .. 84 %", {}, false, {Shape::triangle, colour::published, 4, true, 1}, true}},
          14);
    panels.push_back(p.finish());
    top += 145;
  }
  return file_of(top + 40, title, panels);
}

}  // namespace powbench::host
