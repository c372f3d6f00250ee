#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/counted.h"
#include "core/quantities.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr std::string_view dagger = " \xE2\x80\xA0";

/// A published value in the unit of the row, with a dagger when it cannot serve as a reference.
std::string published_text(const PublishedRow* p, double si_value, const ReadableUnit& unit) {
  if (!std::isfinite(si_value)) return std::string(no_value);
  return fixed(si_value * unit.per_si, unit.decimals) +
         (p != nullptr && p->excluded ? std::string(dagger) : "");
}

void event_row(Markup& out, const ReportInput& input, const Quantity& quantity, const ComparisonRow& row) {
  const ReadableUnit unit = readable_unit(quantity.unit);
  const PublishedRow* published = published_at(input, quantity.symbol, row.closing_angle);
  const bool failed = row.outcome == Outcome::fail;
  out.open("tr", {{"class", failed ? "bad" : ""}});
  out.element("th", quantity.symbol, {{"scope", "row"}, {"class", "sym"}});
  out.open("td", {{"class", "left"}}).text(quantity.meaning);
  if (row.two_modes) out.element("span", " two groups", {{"class", "warn"}});
  if (failed) out.element("span", " outside limit", {{"class", "warn"}});
  out.close();
  out.element("td", unit.name, {{"class", "unit"}});
  out.element("td", with_uncertainty(row.measured, row.coverage, unit.per_si, unit.decimals),
              {{"class", "key"}});
  out.element("td", fmt::format("{}", row.repeats));
  out.element("td", fixed(row.scatter * unit.per_si, unit.decimals + 1));
  out.element("td", fixed(row.unexplained * unit.per_si, unit.decimals + 1));
  const double E = row.difference_over_U();
  out.element("td", simulated_text(row), {{"class", "sim"}});
  out.element("td", signed_fixed((row.simulated - row.measured.value) * unit.per_si,
                                 decimals_for(row.expanded_difference() * unit.per_si, unit.decimals)));
  out.element("td", fixed(E, E < 9.995 ? 2 : 0));
  out.element("td", std::isfinite(row.simulated) ? agreement(E) : no_value,
              {{"class", E > 1 ? "warn" : "unit"}});
  out.open("td").element("span", name(row.outcome), {{"class", badge_class(row.outcome)}}).close();
  if (!input.published.empty()) {
    out.element("td", published_text(published, row.published_measurement, unit), {{"class", "pub"}});
    out.element("td", published_text(published, row.published_simulation, unit), {{"class", "pub"}});
  }
  out.close();
}

Markup event_table(const ReportInput& input, const AngleView& view) {
  Markup out;
  out.open("table", {{"class", "events"}});
  out.open("thead").open("tr");
  out.element("th", "Quantity", {{"scope", "col"}, {"colspan", "3"}});
  for (const std::string_view head : {"measured \xC2\xB1 U", "n", "s", "s to sim.", "simulated",
                                      "sim. \xE2\x88\x92 meas.", "/ U", "", "limits"})
    out.element("th", head, {{"scope", "col"}});
  if (!input.published.empty()) {
    out.element("th", "published meas.", {{"scope", "col"}});
    out.element("th", "published sim.", {{"scope", "col"}});
  }
  out.close().close().open("tbody");
  bool daggered = false;
  for (const auto& quantity : quantity_table) {
    const ComparisonRow* row = row_at(input.comparison, quantity.symbol, view.angle);
    if (row == nullptr) continue;
    event_row(out, input, quantity, *row);
    const PublishedRow* p = published_at(input, quantity.symbol, view.angle);
    daggered = daggered || (p != nullptr && p->excluded);
  }
  out.close().close();
  if (daggered)
    out.element(
        "p",
        "\xE2\x80\xA0 Impossible as printed: the core would land before the contacts touch. Not used as a "
        "reference.",
        {{"class", "fine"}});
  return out;
}

Markup curve_table(const std::vector<CurveRow>& rows) {
  Markup out;
  out.open("table", {{"class", "events"}});
  out.open("thead").open("tr");
  out.element("th", "Simulated curve against measured", {{"scope", "col"}, {"colspan", "3"}});
  for (const std::string_view head : {"largest difference", "n", "at / ms", "measured there",
                                      "simulated there", "share / %", "rms / %", "late / ms"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  for (const CurveRow& r : rows) {
    const ReadableUnit unit = readable_unit(r.unit);
    const CurveDeviation& d = r.median;
    out.open("tr");
    out.element("th", r.quantity, {{"scope", "row"}, {"class", "sym"}});
    out.element("td", r.quantity == "i_m" ? "coil current" : "travel of the core", {{"class", "left"}});
    out.element("td", unit.name, {{"class", "unit"}});
    out.element("td", fixed(d.largest * unit.per_si, unit.decimals), {{"class", "key"}});
    out.element("td", fmt::format("{}", r.repeats));
    out.element("td", fixed(d.at * 1e3, 1));
    out.element("td", fixed(d.measured * unit.per_si, unit.decimals));
    out.element("td", fixed(d.simulated * unit.per_si, unit.decimals), {{"class", "sim"}});
    out.element("td", fixed(d.share() * 100, 1));
    out.element("td", fixed(d.rms_share * 100, 2));
    out.element("td", signed_fixed(d.late * 1e3, 3));
    out.close();
  }
  out.close().close();
  out.element("p",
              "Where the curves, averaged over 0.1 ms, differ most until 2 ms after the last landing; shot "
              "with the median "
              "difference, of the closings that are drawn. Each curve less its mean over the 2 ms before. "
              "Share: of the measured value there, large near a zero. Rms: of the difference, "
              "over the span "
              "of the measured curve. Late: how much later the simulated curve comes.",
              {{"class", "fine"}});
  return out;
}

}  // namespace

Markup angle_section(const ReportInput& input, const AngleView& view, const Range& window_ms) {
  Markup out;
  out.open("section", {{"class", "angle"},
                       {"id", std::isfinite(view.angle) ? fmt::format("angle-{:.2f}", degrees(view.angle))
                                                        : "angle-unknown"}});
  out.open("h2")
      .text("Closing angle ")
      .text(std::isfinite(view.angle) ? angle_text(view.angle) : "not known");
  int valid = 0;
  for (const auto* shot : view.shots) valid += shot->events.has_value() ? 1 : 0;
  out.element("span", fmt::format(" {} of {} measured", valid, counted(view.shots.size(), "shot")),
              {{"class", "aside"}});
  out.close();
  const bool drawn =
      (view.simulated != nullptr && !view.simulated->waveforms.empty()) ||
      std::any_of(view.shots.begin(), view.shots.end(), [](const auto* s) { return !s->waveforms.empty(); });
  if (!drawn) {
    out.embed(event_table(input, view));
    return out.close();
  }
  out.open("figure").embed(waveform_figure(input, view, window_ms));
  out.element(
      "figcaption",
      std::string(
          view.simulated == nullptr
              ? "Blue: measured. Vertical lines: mean instants. "
              : "Blue: measured. Orange, and the column simulated: one simulation for the angle, " +
                    (view.simulated->basis.empty() ? "under the same conditions" : view.simulated->basis) +
                    ", through simulated sensors and the same extraction; its band: what the uncertainties "
                    "of "
                    "its inputs move it by "
                    "(k = 2). Vertical lines: mean instants, measured solid, simulated dashed. ") +
          "Pale blue: pole closed in the first measured shot. Dotted grey: shape of the mains.");
  out.close();
  out.embed(event_table(input, view));
  if (const auto curves = curve_rows(view); !curves.empty()) out.embed(curve_table(curves));
  return out.close();
}

}  // namespace powbench::host
