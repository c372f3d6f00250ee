#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/report/number.h"
#include "host/report/plot.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr double width = 620, height = 316;
constexpr Plot::Box box{62, 34, 546, 232};

/// A quantity in a chart over the closing angle.
struct Series {
  std::string_view quantity;
  std::string_view name;
  Shape shape;
  std::string_view dash;
};

/// Closing angles on the axis, degrees.
Range angle_axis(const ReportInput& input) {
  Range x;
  for (const auto& view : angles_of(input)) x.include(degrees(view.angle));
  for (const auto& row : input.published) x.include(row.theta_deg);
  return x.empty() ? Range{0, 180} : Range{x.low - 8, x.high + 8};
}

Ticks angle_ticks(const Range& x) {
  return ticks_every(x, x.span() > 220 ? 45 : x.span() > 100 ? 30 : x.span() > 25 ? 10 : 5);
}

/// Rows of one quantity, in order of angle.
std::vector<const ComparisonRow*> rows_of(const ReportInput& input, std::string_view quantity) {
  std::vector<const ComparisonRow*> rows;
  for (const auto& row : input.comparison.rows)
    if (row.quantity == quantity) rows.push_back(&row);
  return rows;
}

Range values_of(const ReportInput& input, const std::vector<Series>& all) {
  Range y;
  for (const auto& series : all) {
    for (const auto* row : rows_of(input, series.quantity))
      for (const double v : {row->measured.value, row->lowest, row->highest, row->simulated})
        y.include(v * 1e3);
    for (const auto* row : rows_of(input, series.quantity))
      for (const double side : {-1.0, 1.0})
        y.include((row->measured.value + side * row->coverage * row->measured.u) * 1e3);
    for (const auto& p : input.published)
      if (p.quantity == series.quantity && p.table > 0 && !p.excluded)
        for (const double v : {p.measurement, p.simulation}) y.include(v);
  }
  // the bar of a simulation that a small change of its inputs turns into another closing may leave the chart
  const Range points = y;
  if (points.empty()) return y.padded(0.09, 0.5);
  for (const auto& series : all)
    for (const auto* row : rows_of(input, series.quantity))
      for (const double side : {-1.0, 1.0})
        y.include(std::clamp((row->simulated + side * 2 * row->u_simulated) * 1e3,
                             points.low - points.span() / 2, points.high + points.span() / 2));
  return y.padded(0.09, 0.5);
}

void draw_series(Plot& plot, const ReportInput& input, const Series& series) {
  const auto rows = rows_of(input, series.quantity);
  std::vector<XY> simulated;
  for (const auto* row : rows) simulated.push_back({degrees(row->closing_angle), row->simulated * 1e3});
  plot.line(simulated, {colour::simulated, 2.2, 0.6, series.dash});
  for (const auto* row : rows)
    if (std::isfinite(row->u_simulated))
      plot.error_bar({degrees(row->closing_angle), row->simulated * 1e3}, 2 * row->u_simulated * 1e3,
                     {colour::simulated, 1.3, 0.6});
  for (const auto& p : simulated) plot.point(p, {series.shape, colour::simulated, 2.6, true, 0.8});
  for (const auto& p : input.published) {
    if (p.quantity != series.quantity || p.table == 0 || p.excluded) continue;
    plot.point({p.theta_deg + 2.2, p.simulation}, {Shape::triangle, colour::published, 4, false});
    plot.point({p.theta_deg + 2.2, p.measurement}, {Shape::triangle, colour::published, 4, true});
  }
  for (const auto* row : rows) {
    const double x = degrees(row->closing_angle);
    plot.line({{x, row->lowest * 1e3}, {x, row->highest * 1e3}}, {colour::measured, 5, 0.18});
    plot.error_bar({x, row->measured.value * 1e3}, row->coverage * row->measured.u * 1e3,
                   {colour::measured, 1.3});
    plot.point({x, row->measured.value * 1e3}, {series.shape, colour::measured, 4});
  }
}

std::vector<Plot::LegendEntry> legend_of(const ReportInput& input, const std::vector<Series>& all) {
  std::vector<Plot::LegendEntry> legend;
  for (const auto& series : all) {
    const auto rows = rows_of(input, series.quantity);
    const bool simulated =
        std::any_of(rows.begin(), rows.end(), [](const auto* r) { return std::isfinite(r->simulated); });
    const std::string name = all.size() > 1 ? fmt::format("{}, ", series.name) : std::string();
    legend.push_back({name + "measured", {}, false, {series.shape, colour::measured, 4}, true});
    if (simulated)
      legend.push_back({name + "simulated",
                        {colour::simulated, 2.2, 0.6, series.dash},
                        true,
                        {series.shape, colour::simulated, 2.6},
                        true});
  }
  if (!input.published.empty()) {
    legend.push_back({"published measurement", {}, false, {Shape::triangle, colour::published, 4}, true});
    legend.push_back(
        {"published simulation", {}, false, {Shape::triangle, colour::published, 4, false}, true});
  }
  return legend;
}

Markup angle_chart(const ReportInput& input, std::string_view title, std::string_view axis,
                   const std::vector<Series>& all) {
  const Range x = angle_axis(input), y = values_of(input, all);
  Plot plot(box, x, y);
  const Ticks x_ticks = angle_ticks(x), y_ticks = nice_ticks(y, 5);
  plot.grid(x_ticks, y_ticks);
  for (const auto& series : all) draw_series(plot, input, series);
  plot.frame();
  plot.x_labels(x_ticks, "closing angle", "\xC2\xB0");
  plot.y_labels(y_ticks, axis);
  plot.legend(legend_of(input, all), 14);
  return figure(width, height, title, {plot.finish()});
}

Markup reached_chart(const ReportInput& input) {
  const double tolerance = degrees(input.angle_tolerance);
  const auto deviation = [](const ReportShot& s) {
    return degrees(wrap_half_turn(s.events->coil.closing_angle.value - effective_angle(s.conditions)));
  };
  Range y;
  if (tolerance > 0) y = {-tolerance, tolerance};
  for (const auto& s : input.shots)
    if (s.events && s.events->coil.closing_angle.known()) y.include(deviation(s));
  y.include(0);
  y = y.padded(0.12, 0.1);
  const Range x = angle_axis(input);
  Plot plot(box, x, y);
  const Ticks x_ticks = angle_ticks(x), y_ticks = nice_ticks(y, 5);
  plot.grid(x_ticks, y_ticks);
  if (tolerance > 0) plot.shade_y(-tolerance, tolerance, colour::published, 0.08);
  plot.horizontal(0, {colour::soft, 1});
  constexpr std::size_t most_points = 600;  // more hide each other, and make the page long
  const bool each = input.shots.size() <= most_points;
  for (const auto& view : angles_of(input)) {
    const double n = static_cast<double>(view.shots.size());
    if (!each) {
      Range seen;
      double sum = 0, known = 0;
      for (const ReportShot* s : view.shots) {
        if (!s->events || !s->events->coil.closing_angle.known()) continue;
        seen.include(deviation(*s));
        sum += deviation(*s), ++known;
      }
      if (!(known > 0)) continue;
      const double at = degrees(view.angle);
      plot.bar(at - 1, at + 1, seen.low, seen.high, colour::measured, 0.25);
      plot.point({at, sum / known}, {Shape::circle, colour::measured, 3});
      continue;
    }
    for (std::size_t i = 0; i < view.shots.size(); ++i) {
      const ReportShot& s = *view.shots[i];
      if (!s.events || !s.events->coil.closing_angle.known()) continue;
      const double spread = std::min(1.6, 8.0 / n);  // repeats side by side, in executed order
      const XY at{degrees(view.angle) + spread * (static_cast<double>(i) - (n - 1) / 2), deviation(s)};
      plot.error_bar(at, 2 * degrees(s.events->coil.closing_angle.u), {colour::measured, 1.0, 0.8});
      plot.point(at, {Shape::circle, colour::measured, 3});
    }
  }
  plot.frame();
  plot.x_labels(x_ticks, "commanded closing angle", "\xC2\xB0");
  plot.y_labels(y_ticks, "reached \xE2\x88\x92 commanded / \xC2\xB0");
  std::vector<Plot::LegendEntry> legend{{each ? "one shot, bar: 2 u" : "mean; column: smallest to largest",
                                         {},
                                         false,
                                         {Shape::circle, colour::measured, 3},
                                         true}};
  if (tolerance > 0)
    legend.push_back({fmt::format("band: tolerance {}", angle_text(input.angle_tolerance)),
                      {colour::published, 8, 0.2},
                      true});
  plot.legend(legend, 14);
  return figure(width, height, "Closing angle reached minus commanded", {plot.finish()});
}

void chart(Markup& out, std::string_view title, const Markup& drawing) {
  out.open("figure");
  out.element("h3", title);
  out.embed(drawing);
  out.close();
}

/// A value at a known angle: without one a chart would be axes alone.
bool shows(const ReportInput& input, std::string_view quantity) {
  const auto rows = rows_of(input, quantity);
  return std::any_of(rows.begin(), rows.end(), [](const ComparisonRow* r) {
    return std::isfinite(r->closing_angle) && (r->measured.known() || std::isfinite(r->simulated));
  });
}

bool shows_angles(const ReportInput& input) {
  return std::any_of(input.shots.begin(), input.shots.end(), [](const ReportShot& s) {
    return s.events && s.events->coil.closing_angle.known() && std::isfinite(effective_angle(s.conditions));
  });
}

/// The angle whose bounce time is the median of the angles', and there the shot nearest to its mean.
AngleView typical(const ReportInput& input) {
  std::vector<const ComparisonRow*> rows;
  for (const auto* row : rows_of(input, "t_ct_bon"))
    if (row->measured.known()) rows.push_back(row);
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* a, const auto* b) { return a->measured.value < b->measured.value; });
  const auto views = angles_of(input);
  AngleView chosen = views.front();
  const ComparisonRow* row = rows.empty() ? nullptr : rows[rows.size() / 2];
  for (const auto& view : views)
    if (row != nullptr && same_angle(view.angle, row->closing_angle)) chosen = view;
  const auto distance = [&](const ReportShot* s) {
    const double bounce = s->events ? find_quantity("t_ct_bon")->of(*s->events).value : unknown;
    const double d = row != nullptr ? std::fabs(bounce - row->measured.value) : unknown;
    return s->waveforms.empty() || !std::isfinite(d) ? 1e9 : d;
  };
  const auto nearest =
      std::min_element(chosen.shots.begin(), chosen.shots.end(),
                       [&](const auto* a, const auto* b) { return distance(a) < distance(b); });
  if (nearest != chosen.shots.end()) chosen.shots = {*nearest};
  return chosen;
}

}  // namespace

Markup typical_section(const ReportInput& input) {
  const AngleView view = typical(input);
  Markup out;
  if (view.shots.empty() || view.shots.front()->waveforms.empty()) return out;
  out.open("section", {{"id", "typical"}});
  out.element(
      "h2", fmt::format("One typical closing: shot {} {}", view.shots.front()->index, at_angle(view.angle)));
  out.open("figure").embed(waveform_figure(input, view, time_window(input), true));
  out.element(
      "figcaption",
      "Blue: measured. Orange: simulated, through simulated sensors and the same extraction; its band: what "
      "the uncertainties of its inputs move it by (k = 2). Vertical lines: mean "
      "instants of the angle, measured solid, simulated dashed. Pale blue: pole closed. Dotted grey: "
      "shape of the mains.");
  out.close();
  return out.close();
}

Markup chart_section(const ReportInput& input) {
  Markup out;
  const bool angles = shows_angles(input);
  if (!shows(input, "t_ct_bon") && !shows(input, "t_ct1") && !shows(input, "t_xt1") && !angles) return out;
  out.open("section", {{"id", "angles"}});
  out.element("h2", "Behaviour over the closing angle");
  out.open("div", {{"class", "grid"}});
  if (shows(input, "t_ct_bon"))
    chart(out, "Contact bounce time t_ct_bon",
          angle_chart(input, "Contact bounce time over closing angle", "ms",
                      {{"t_ct_bon", "bounce", Shape::circle, ""}}));
  if (shows(input, "t_ct1"))
    chart(out, "First contact touch t_ct1",
          angle_chart(input, "First touch over closing angle", "ms after switch-on",
                      {{"t_ct1", "touch", Shape::circle, ""}}));
  if (shows(input, "t_xt1"))
    chart(out, "Core seat t_xt1",
          angle_chart(input, "Core seat over closing angle", "ms after switch-on",
                      {{"t_xt1", "seat", Shape::diamond, ""}}));
  if (angles) chart(out, "Closing angle: reached minus commanded", reached_chart(input));
  out.close();
  out.element("p",
              "Points: mean of the repeats; bar: expanded uncertainty U (95.45 %); pale column: smallest to "
              "largest repeat; bar of the simulation: what its inputs' uncertainty moves it by (k = 2). The "
              "angle reached is fitted to the recorded mains and read at the step of the coil voltage.",
              {{"class", "fine"}});
  return out.close();
}

}  // namespace powbench::host
