#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/quantities.h"
#include "host/report/number.h"
#include "host/report/plot.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr double page_width = 1000, left = 74, right = 14;
constexpr double zoom_height = 150;
constexpr double top = 62, gap = 12, bottom = 46;
constexpr double strip_row = 11;
constexpr std::size_t drawn_shots = 5;      // more traces than this hide each other
constexpr std::size_t trace_buckets = 320;  // two points each, 3 px

struct Panel {
  std::string_view channel;
  std::string_view title;
  double scale;  ///< from SI
  double height;
};

constexpr std::array panels{Panel{"pvdf_a", "force A / N", 1, 128}, Panel{"pvdf_b", "force B / N", 1, 128},
                            Panel{"laser", "travel / mm", 1e3, 104},
                            Panel{"coil_current", "coil current / A", 1, 104},
                            Panel{"contact_a", "contact / V", 1, 66}};

/// Instants marked in every panel.
struct Mark {
  std::string_view quantity;
  std::string_view label;
};
constexpr std::array marks{Mark{"t_ct1", "touch"}, Mark{"t_xt1", "core seat"}, Mark{"t_ct2", "settled"}};

const Stroke measured_line{colour::measured, 0.9, 0.85};
const Stroke simulated_line{colour::simulated, 2.8, 0.55};

std::vector<const ReportShot*> shots_to_draw(const AngleView& view) {
  std::vector<const ReportShot*> drawn;
  for (const auto* shot : view.shots)
    if (!shot->waveforms.empty() && drawn.size() < drawn_shots) drawn.push_back(shot);
  return drawn;
}

double mark_ms(const ReportInput& input, const AngleView& view, std::string_view quantity, bool simulated) {
  const ComparisonRow* row = row_at(input.comparison, quantity, view.angle);
  if (row == nullptr) return unknown;
  return (simulated ? row->simulated : row->measured.value) * 1e3;
}

/// The closed intervals of the measured pole as bars, one row a closing.
void draw_closed(Plot& plot, const Events& events, double row, double end_ms, std::string_view color,
                 double opacity) {
  for (const auto& c : timing_train(events).contacts) {
    const double to = c.release.known() ? after_switch_on(events, c.release).value * 1e3 : end_ms;
    plot.bar(after_switch_on(events, c.touch).value * 1e3, to, row + 0.12, row + 0.88, color, opacity);
  }
}

struct Label {
  double at;  ///< ms
  std::string_view text, color;
  int row;  ///< above the strip, from 0
};

/// The marked instants by name, each in the lowest row in which it stands clear of the others.
std::vector<Label> mark_labels(const ReportInput& input, const AngleView& view, const Range& window) {
  std::vector<Label> labels;
  for (const auto& mark : marks) {
    const double measured = mark_ms(input, view, mark.quantity, false);
    const double simulated = mark_ms(input, view, mark.quantity, true);
    if (std::isfinite(measured))
      labels.push_back({measured, mark.label, colour::measured, 0});
    else if (std::isfinite(simulated))
      labels.push_back({simulated, mark.label, colour::simulated, 0});
  }
  std::sort(labels.begin(), labels.end(), [](const Label& a, const Label& b) { return a.at < b.at; });
  const double close = 66 * window.span() / (page_width - left - right);
  for (auto label = labels.begin(); label != labels.end(); ++label)
    while (std::any_of(labels.begin(), label, [&](const Label& before) {
      return before.row == label->row && label->at - before.at < close;
    }))
      ++label->row;
  return labels;
}

/// Height of the rows of names beyond the two that there is always room for.
double more_rows(const std::vector<Label>& labels) {
  int most = 1;
  for (const Label& label : labels) most = std::max(most, label.row);
  return 15.0 * (most - 1);
}

Markup strip(const AngleView& view, const Range& window, double y, const std::vector<Label>& labels,
             double* height) {
  std::vector<const ReportShot*> rows;
  for (const auto* shot : view.shots)
    if (shot->events && rows.size() < 2 * drawn_shots) rows.push_back(shot);
  const double count = static_cast<double>(rows.size()) + (view.simulated != nullptr ? 1 : 0);
  *height = std::max(count, 1.0) * strip_row;
  Plot plot({left, y, page_width - left - right, *height}, window, {0, std::max(count, 1.0)});
  double row = count;
  for (const auto* shot : rows) draw_closed(plot, *shot->events, --row, window.high, colour::measured, 0.75);
  if (view.simulated != nullptr)
    draw_closed(plot, view.simulated->events, 0, window.high, colour::simulated, 0.65);
  plot.frame();
  plot.text_left(std::max(count, 1.0) / 2, "closed");
  for (const Label& label : labels) plot.note(label.at, label.text, label.color, label.row);
  std::vector<Plot::LegendEntry> legend;
  if (!view.shots.empty())
    legend.push_back({fmt::format("measured ({} of {})", shots_to_draw(view).size(), view.shots.size()),
                      {colour::measured, 1.6}});
  if (view.simulated != nullptr) legend.push_back({"simulated", simulated_line});
  plot.legend(legend, 44 + more_rows(labels));
  return plot.finish();
}

void draw_traces(Plot& plot, const Panel& panel, const AngleView& view, const Range& window) {
  const auto draw = [&](const std::vector<Waveform>& all, const Stroke& stroke) {
    const Waveform* w = find_waveform(all, panel.channel);
    if (w == nullptr) return;
    auto points = decimate(w->values, w->t0 * 1e3, w->dt * 1e3, window.low, window.high, trace_buckets);
    plot.trace(points, panel.scale, stroke);
  };
  if (view.simulated != nullptr) draw(view.simulated->waveforms, simulated_line);
  for (const auto* shot : shots_to_draw(view)) draw(shot->waveforms, measured_line);
}

/// What the uncertainty of its inputs leaves open of the simulated curve: k = 2.
void draw_spread(Plot& plot, const Panel& panel, const AngleView& view, const Range& window) {
  if (view.simulated == nullptr) return;
  const Waveform* u = find_waveform(view.simulated->spread, panel.channel);
  const Waveform* curve = find_waveform(view.simulated->waveforms, panel.channel);
  if (u == nullptr || curve == nullptr) return;
  std::vector<XY> points;
  std::vector<double> half;
  for (std::size_t k = 0; k < u->values.size(); ++k) {
    const double t = u->t0 + (static_cast<double>(k) + 0.5) * u->dt, at = (t - curve->t0) / curve->dt;
    if (t * 1e3 < window.low || t * 1e3 > window.high || at < 0 ||
        at >= static_cast<double>(curve->values.size()))
      continue;
    points.push_back(
        {t * 1e3, static_cast<double>(curve->values[static_cast<std::size_t>(at)]) * panel.scale});
    half.push_back(2 * static_cast<double>(u->values[k]) * panel.scale);
  }
  plot.band(points, half, colour::simulated, 0.22);
}

/// The mains behind the coil current, scaled to the panel: shows the closing angle at a glance.
void draw_mains(Plot& plot, const AngleView& view, const Range& window, const Range& panel_range) {
  const auto shots = shots_to_draw(view);
  const Waveform* w = shots.empty() ? nullptr : find_waveform(shots.front()->waveforms, "mains_voltage");
  if (w == nullptr) return;
  float peak = 0;
  for (const float v : w->values)
    if (std::isfinite(v)) peak = std::max(peak, std::fabs(v));
  if (!(peak > 0)) return;
  const double reach = 0.92 * std::min(std::fabs(panel_range.low), std::fabs(panel_range.high));
  const auto points = decimate(w->values, w->t0 * 1e3, w->dt * 1e3, window.low, window.high, 150);
  plot.trace(points, (reach > 0 ? reach : panel_range.high) / static_cast<double>(peak),
             {"#9aa5b1", 1.0, 0.9, "2 3"});
}

struct Placed {
  Range window;       ///< ms
  Range values;       ///< SI
  double y = 0;       ///< of the box's upper edge
  bool axis = false;  ///< carries the labels of the time axis
};

Markup panel_plot(const ReportInput& input, const AngleView& view, const Panel& panel, const Placed& place) {
  const auto& [window, values, y, last] = place;
  const Range range = Range{values.low * panel.scale, values.high * panel.scale}.padded(0.06, 1e-3);
  Plot plot({left, y, page_width - left - right, panel.height}, window, range);
  const Ticks x_ticks = nice_ticks(window, 14);
  const Ticks y_ticks = nice_ticks(range, panel.height > 80 ? 5 : 2);
  plot.grid(x_ticks, y_ticks);
  const Events* shaded = nullptr;
  for (const auto* shot : view.shots)
    if (shaded == nullptr && shot->events) shaded = &*shot->events;
  if (shaded == nullptr && view.simulated != nullptr) shaded = &view.simulated->events;
  if (shaded != nullptr)
    for (const auto& c : timing_train(*shaded).contacts)
      plot.shade_x(after_switch_on(*shaded, c.touch).value * 1e3,
                   c.release.known() ? after_switch_on(*shaded, c.release).value * 1e3 : window.high,
                   colour::measured, 0.06);
  if (panel.channel == "coil_current") draw_mains(plot, view, window, range);
  plot.vertical(0, {colour::soft, 1});
  draw_spread(plot, panel, view, window);
  draw_traces(plot, panel, view, window);
  for (const auto& mark : marks) {
    plot.vertical(mark_ms(input, view, mark.quantity, true), {colour::simulated, 1.1, 0.9, "5 3"});
    plot.vertical(mark_ms(input, view, mark.quantity, false), {colour::measured, 1.1, 0.9});
  }
  plot.frame();
  plot.y_labels(y_ticks, panel.title);
  if (last) plot.x_labels(x_ticks, "time after switch-on / ms");
  return plot.finish();
}

/// The bouncing alone, on a wider time axis: from just before the first touch to just after the last.
Range bounce_window(const ReportInput& input, const AngleView& view) {
  Range bounce;
  for (const std::string_view quantity : {"t_ct1", "t_ct2"}) {
    bounce.include(mark_ms(input, view, quantity, false));
    bounce.include(mark_ms(input, view, quantity, true));
  }
  return bounce.empty() ? bounce : Range{bounce.low - 0.5, bounce.high + 1.0};
}

}  // namespace

Markup waveform_figure(const ReportInput& input, const AngleView& view, const Range& window,
                       bool short_form) {
  std::vector<std::pair<Panel, Range>> shown;
  for (const auto& panel : panels) {
    const auto has = [&](const std::vector<Waveform>& all) {
      return find_waveform(all, panel.channel) != nullptr;
    };
    const bool here = (view.simulated != nullptr && has(view.simulated->waveforms)) ||
                      std::any_of(view.shots.begin(), view.shots.end(),
                                  [&](const ReportShot* s) { return has(s->waveforms); });
    const Range values = here ? channel_range(input, panel.channel, window) : Range{};
    if (!values.empty()) shown.emplace_back(panel, values);
  }
  std::vector<Markup> drawn;
  const std::vector<Label> labels = mark_labels(input, view, window);
  double y = top + more_rows(labels), height = 0;
  drawn.push_back(strip(view, window, y, labels, &height));
  y += height + gap;
  for (const auto& [panel, values] : shown) {
    const bool last = &panel == &shown.back().first;
    drawn.push_back(panel_plot(input, view, panel, {window, values, y, last}));
    y += panel.height + (last ? bottom : gap);
  }
  const Range bounce = bounce_window(input, view);
  if (!short_form && !bounce.empty() && !shown.empty() &&
      shown.front().first.channel == panels.front().channel) {
    Panel panel = panels.front();
    panel.title = "force A, bounce / N";
    panel.height = zoom_height;
    drawn.push_back(
        panel_plot(input, view, panel, {bounce, channel_range(input, panel.channel, bounce), y, true}));
    y += zoom_height + bottom;
  }
  return figure(page_width, y, fmt::format("Measured and simulated signals {}", at_angle(view.angle)), drawn);
}

}  // namespace powbench::host
