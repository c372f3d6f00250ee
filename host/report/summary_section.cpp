#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/quantities.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

/// Mean of what is finite.
struct Mean {
  double sum = 0;
  int n = 0;
  void add(double v) {
    if (!std::isfinite(v)) return;
    sum += v;
    ++n;
  }
  double value() const { return n > 0 ? sum / n : unknown; }
};

void tile(Markup& out, std::size_t number, std::string_view label, std::string_view kind) {
  out.open("div", {{"class", number > 0 ? std::string("tile ") + std::string(kind) : std::string("tile")}});
  out.element("b", fmt::format("{}", number)).element("span", label);
  out.close();
}

void limits_table(Markup& out, const ReportInput& input) {
  out.element("h3", "Limits");
  if (input.limits.empty()) {
    out.element("p", "The plan sets none: nothing was judged.", {{"class", "fine"}});
    return;
  }
  out.element("p", decision_text(input.decision), {{"class", "fine"}});
  out.open("table", {{"class", "limits"}}).open("thead").open("tr");
  out.element("th", "Quantity", {{"scope", "col"}, {"colspan", "2"}});
  for (const std::string_view head : {"allowed", "measured, all angles", "result"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  for (const auto& limit : input.limits) {
    const Quantity* quantity = find_quantity(limit.quantity);
    const ReadableUnit unit = readable_unit(quantity != nullptr ? quantity->unit : "");
    Range seen;
    Outcome outcome = Outcome::pass;
    std::string where;
    for (const auto& row : input.comparison.rows) {
      if (row.quantity != limit.quantity) continue;
      seen.include(row.lowest * unit.per_si);
      seen.include(row.highest * unit.per_si);
      if (row.outcome == Outcome::fail || row.outcome == Outcome::not_observed)
        where += fmt::format("{} {}", where.empty() ? "" : ",", angle_text(row.closing_angle));
      outcome = worse(outcome, row.outcome);
    }
    if (seen.empty()) outcome = worse(outcome, Outcome::not_observed);
    out.open("tr").element("th", limit.quantity, {{"scope", "row"}, {"class", "sym"}});
    out.element("td", quantity != nullptr ? quantity->meaning : "", {{"class", "left"}});
    out.element("td", range_text(limit));
    out.element("td", seen.empty() ? std::string(no_value)
                                   : fmt::format("{} to {} {}", fixed(seen.low, unit.decimals),
                                                 fixed(seen.high, unit.decimals), unit.name));
    out.open("td").element("span", name(outcome), {{"class", badge_class(outcome)}});
    if (!where.empty()) out.text(" at").text(where);
    out.close().close();
  }
  out.close().close();
}

/// How far simulation and publication are from the measurement, averaged over the angles.
void agreement_table(Markup& out, const ReportInput& input) {
  out.element("h3", "Agreement over all angles");
  out.open("table", {{"class", "agreement"}}).open("thead").open("tr");
  out.element("th", "Quantity", {{"scope", "col"}, {"colspan", "2"}});
  for (const std::string_view head :
       {"angles", "measured U", "|sim. \xE2\x88\x92 meas.|", "error of simulation", "published: own error"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  for (const auto& quantity : quantity_table) {
    const ReadableUnit unit = readable_unit(quantity.unit);
    Mean expanded, difference, error, published;
    for (const auto& row : input.comparison.rows) {
      if (row.quantity != quantity.symbol) continue;
      expanded.add(row.coverage * row.measured.u * unit.per_si);
      difference.add(std::fabs(row.simulated - row.measured.value) * unit.per_si);
      error.add(relative_error_percent(row.simulated, row.measured.value));
    }
    for (const auto& p : input.published)
      if (p.quantity == quantity.symbol && p.table > 0 && !p.excluded)
        published.add(p.recomputed_error_percent);
    if (difference.n == 0 && expanded.n == 0) continue;
    const auto with_unit = [&](const Mean& m, int decimals) {
      return m.n > 0 ? fmt::format("{} {}", fixed(m.value(), decimals), unit.name) : std::string(no_value);
    };
    const auto percent = [](const Mean& m) {
      return m.n > 0 ? fmt::format("{} %", fixed(m.value(), 1)) : std::string(no_value);
    };
    out.open("tr").element("th", quantity.symbol, {{"scope", "row"}, {"class", "sym"}});
    out.element("td", quantity.meaning, {{"class", "left"}});
    out.element("td", fmt::format("{}", std::max(difference.n, expanded.n)));
    out.element("td", with_unit(expanded, unit.decimals + 1))
        .element("td", with_unit(difference, unit.decimals));
    out.element("td", percent(error), {{"class", "sim"}})
        .element("td", percent(published), {{"class", "pub"}});
    out.close();
  }
  out.close().close();
  out.element(
      "p",
      "Means over the angles. Error: relative to the measured mean; for the publication, its simulation "
      "against its own measurement, recomputed, rows marked as unusable left out.",
      {{"class", "fine"}});
}

void provenance_list(Markup& out, const Provenance& p) {
  out.element("h3", "Provenance");
  out.open("dl", {{"class", "provenance"}});
  const auto item = [&](std::string_view key, const std::string& value) {
    out.open("div")
        .element("dt", key)
        .element("dd", value.empty() ? no_value : std::string_view(value))
        .close();
  };
  item("Program", p.program);
  item("Rig", p.rig);
  item("Firmware", p.firmware);
  item("Calibration", p.calibration);
  item("Plan", p.plan_hash);
  item("Specimen data", p.specimen_hash);
  item("Extraction", p.extraction_hash);
  item("Seed", p.seed);
  item("Order", p.order);
  item("Database", p.database);
  if (!p.operator_name.empty()) item("Operator", p.operator_name);
  for (const auto& [key, value] : p.more) item(key, value);
  out.close();
}

}  // namespace

Markup summary_section(const ReportInput& input) {
  const Counts c = count(input);
  Markup out;
  out.open("section", {{"id", "summary"}});
  out.open("div", {{"class", "tiles"}});
  tile(out, c.planned, "planned", "");
  tile(out, c.done, "measured", "");
  tile(out, c.passed, "inside limits", "good");
  tile(out, c.failed, "outside limits", "bad");
  tile(out, c.not_judged, "not judged", "doubt");
  tile(out, c.not_observed, "not observed", "bad");
  tile(out, c.errors, "no valid measurement", "bad");
  tile(out, c.missing, "not fired", "bad");
  out.close();
  limits_table(out, input);
  agreement_table(out, input);
  provenance_list(out, input.provenance);
  return out.close();
}

}  // namespace powbench::host
