#include "host/report/view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/compare.h"

namespace powbench::host {
namespace {

AngleView& view_at(std::vector<AngleView>& views, double angle) {
  for (auto& v : views)
    if (same_angle(v.angle, angle)) return v;
  views.push_back({angle, {}, nullptr});
  return views.back();
}

}  // namespace

std::vector<AngleView> angles_of(const ReportInput& input) {
  std::vector<AngleView> views;
  for (const auto& shot : input.shots)
    view_at(views, effective_angle(shot.conditions)).shots.push_back(&shot);
  for (const auto& s : input.simulated) view_at(views, s.closing_angle).simulated = &s;
  std::sort(views.begin(), views.end(), [](const AngleView& a, const AngleView& b) {
    return std::isfinite(a.angle) && (!std::isfinite(b.angle) || a.angle < b.angle);
  });
  return views;
}

std::vector<CurveRow> curve_rows(const AngleView& view) {
  std::vector<CurveRow> rows;
  if (view.simulated == nullptr) return rows;
  const auto last = [](const Events& e) {
    return std::fmax(find_quantity("t_ct2")->of(e).value, find_quantity("t_xt2")->of(e).value);
  };
  const auto curve = [](const Waveform& w) { return Curve{w.t0, w.dt, w.values}; };
  constexpr double after = 2e-3;  // s
  const std::pair<const char*, const char*> shown[] = {{"i_m", "coil_current"}, {"x_m", "laser"}};
  for (const auto& [quantity, channel] : shown) {
    const Waveform* simulated = find_waveform(view.simulated->waveforms, channel);
    if (simulated == nullptr) continue;
    std::vector<CurveDeviation> repeats;
    for (const ReportShot* shot : view.shots) {
      const Waveform* measured = find_waveform(shot->waveforms, channel);
      if (measured == nullptr || !shot->events) continue;
      const double end = std::fmax(last(*shot->events), last(view.simulated->events)) + after;
      if (std::isfinite(end)) repeats.push_back(curve_deviation(curve(*measured), curve(*simulated), end));
    }
    rows.push_back(curve_row(quantity, simulated->unit, view.angle, std::move(repeats)));
  }
  std::erase_if(rows, [](const CurveRow& r) { return r.repeats == 0; });
  return rows;
}

const ComparisonRow* row_at(const Comparison& comparison, std::string_view quantity, double angle) {
  for (const auto& row : comparison.rows)
    if (row.quantity == quantity && same_angle(row.closing_angle, angle)) return &row;
  return nullptr;
}

const PublishedRow* published_at(const ReportInput& input, std::string_view quantity, double angle) {
  for (const auto& row : input.published)
    if (row.quantity == quantity && std::isfinite(row.theta_deg) && same_angle(radians(row.theta_deg), angle))
      return &row;
  return nullptr;
}

const Waveform* find_waveform(const std::vector<Waveform>& all, std::string_view channel) {
  for (const auto& w : all)
    if (w.channel == channel && !w.values.empty() && w.dt > 0) return &w;
  return nullptr;
}

Range time_window(const ReportInput& input) {
  Range settled;
  const auto look = [&](const Events& e) { settled.include(find_quantity("t_ct2")->of(e).value * 1e3); };
  for (const auto& shot : input.shots)
    if (shot.events) look(*shot.events);
  for (const auto& s : input.simulated) look(s.events);
  const double end = settled.empty() ? 40 : settled.high + 6;
  return {-2.0, 5 * std::ceil(end / 5)};
}

Range channel_range(const ReportInput& input, std::string_view channel, const Range& window_ms) {
  Range range;
  const auto look = [&](const std::vector<Waveform>& all) {
    const Waveform* w = find_waveform(all, channel);
    if (w == nullptr) return;
    for (std::size_t i = 0; i < w->values.size(); ++i) {
      const double ms = (w->t0 + static_cast<double>(i) * w->dt) * 1e3;
      if (ms >= window_ms.low && ms <= window_ms.high) range.include(static_cast<double>(w->values[i]));
    }
  };
  for (const auto& shot : input.shots) look(shot.waveforms);
  for (const auto& s : input.simulated) look(s.waveforms);
  return range;
}

}  // namespace powbench::host
