#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr std::size_t day_length = 10;  // of an ISO time

/// How the closings kept to the angle that was asked for.
struct AngleKept {
  Range seen;  ///< deg: reached less asked; empty where no tolerance was given or no angle is known
  std::size_t closings = 0, off = 0;
  std::string where;  ///< shots that did not pass
  Outcome worst = Outcome::pass;
};

AngleKept angle_kept(const ReportInput& input) {
  constexpr std::size_t most_named = 5;
  AngleKept kept;
  for (const auto& shot : input.shots) {
    const double asked = effective_angle(shot.conditions);
    if (!(input.angle_tolerance > 0) || !shot.events || !std::isfinite(asked)) continue;
    const Measured& reached = shot.events->coil.closing_angle;
    if (!reached.known()) continue;
    kept.seen.include(degrees(wrap_half_turn(reached.value - asked)));
    ++kept.closings;
    const Outcome judged = judge_angle(reached, asked, input.angle_tolerance, input.decision);
    if (judged == Outcome::pass) continue;
    kept.worst = worse(kept.worst, judged);
    if (++kept.off <= most_named) kept.where += fmt::format("{} {}", kept.off > 1 ? "," : "", shot.index);
  }
  if (kept.off > most_named) kept.where += fmt::format(" and {} more", kept.off - most_named);
  return kept;
}

std::string span_text(const Range& degrees) {
  const std::string low = signed_fixed(degrees.low, 2), high = signed_fixed(degrees.high, 2);
  return low == high ? low : low + " to " + high;
}

/// Decimals at which both ends of what was measured read on the side of the limit on which they are; 6 at most.
int deciding_decimals(const Limit& limit, const Range& seen, const ReadableUnit& unit) {
  const auto side = [&](double v) {
    return (v < limit.low * unit.per_si ? 1 : 0) + (v > limit.high * unit.per_si ? 2 : 0);
  };
  const auto told = [&](double value, int decimals) {
    return side(std::stod(fmt::format("{:.{}f}", value, decimals))) == side(value);
  };
  int decimals = unit.decimals;
  while (decimals < 6 && !(told(seen.low, decimals) && told(seen.high, decimals))) ++decimals;
  return decimals;
}

void angle_row(Markup& out, const AngleKept& angle, double tolerance) {
  out.open("tr").element("th", "\xCE\xB1", {{"scope", "row"}, {"class", "sym"}});
  out.element("td", "closing angle reached, less the one asked for", {{"class", "left"}});
  out.element("td", fmt::format("\xC2\xB1{:g}\xC2\xB0", degrees(tolerance)));
  out.element("td", span_text(angle.seen) + "\xC2\xB0");
  out.open("td");
  if (angle.off == 0)
    out.text(angle.closings == 1 ? std::string("kept") : fmt::format("kept by all {}", angle.closings));
  else
    out.element("span", name(angle.worst), {{"class", badge_class(angle.worst)}})
        .text(std::string(angle.off == 1 ? " shot" : " shots") + angle.where);
  out.close().close();
}

/// The limit on the difference from the simulation: how many values it was held against, and what came out.
void simulation_row(Markup& out, const ReportInput& input) {
  int judged = 0, comparable = 0;
  Outcome worst = Outcome::pass;
  double largest = 0;
  std::string where;
  for (const auto& row : input.comparison.rows) {
    if (!row.measured.known() && !std::isfinite(row.simulated)) continue;
    ++comparable;
    if (row.against_simulation != Outcome::pass && row.against_simulation != Outcome::fail) continue;
    ++judged;
    worst = worse(worst, row.against_simulation);
    largest = std::max(largest, std::fabs(row.simulated / row.measured.value - 1));
    if (row.against_simulation == Outcome::fail)
      where +=
          fmt::format("{} {} at {}", where.empty() ? "" : ",", row.quantity, angle_text(row.closing_angle));
  }
  if (judged == 0) worst = Outcome::not_judged;
  out.open("tr").element("th", "sim.", {{"scope", "row"}, {"class", "sym"}});
  out.element("td",
              fmt::format("simulated less measured, of the measured mean; judged for {} of {} values", judged,
                          comparable),
              {{"class", "left"}});
  out.element("td", fmt::format("\xE2\x89\xA4 {:g} %", 100 * input.most_from_simulation));
  out.element("td", judged == 0 ? std::string(no_value) : fixed(100 * largest, 1) + " %");
  out.open("td").element("span", name(worst), {{"class", badge_class(worst)}});
  if (!where.empty()) out.text(where);
  out.close().close();
}

void limits_table(Markup& out, const ReportInput& input) {
  out.element("h3", "Limits");
  const AngleKept angle = angle_kept(input);
  const bool simulation = std::isfinite(input.most_from_simulation);
  if (input.limits.empty()) {
    out.element("p",
                angle.seen.empty() && !simulation ? "The plan sets none: nothing was judged."
                                                  : "The plan sets none on a quantity.",
                {{"class", "fine"}});
    if (angle.seen.empty() && !simulation) return;
  } else {
    out.element("p", decision_text(input.decision), {{"class", "fine"}});
  }
  out.open("table", {{"class", "limits"}}).open("thead").open("tr");
  out.element("th", "quantity", {{"scope", "col"}});
  out.element("th", "meaning", {{"scope", "col"}, {"class", "left"}});
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
                                   : range_of(seen.low, seen.high, deciding_decimals(limit, seen, unit)) +
                                         " " + std::string(unit.name));
    out.open("td").element("span", name(outcome), {{"class", badge_class(outcome)}});
    if (!where.empty()) out.text(" at").text(where);
    out.close().close();
  }
  if (!angle.seen.empty()) angle_row(out, angle, input.angle_tolerance);
  if (simulation) simulation_row(out, input);
  out.close().close();
}

void provenance_list(Markup& out, const ReportInput& input) {
  const Provenance& p = input.provenance;
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
  item("Calibration", calibrations_text(p));
  item("Plan", p.plan_hash);
  item("Specimen data", p.specimen_hash);
  item("Extraction", p.extraction_hash);
  item("Seed", p.seed);
  item("Order", p.order);
  item("Database", p.database);
  for (const auto& [key, value] : p.more) item(key, value);
  std::string course;
  for (const CourseEntry& e : input.course)
    course += fmt::format("{}{}: {}", course.empty() ? "" : "; ", time_text(e.when), e.what);
  if (!course.empty()) item("Course", course);
  out.close();
}

}  // namespace

Markup limits_section(const ReportInput& input) {
  Markup out;
  out.open("section", {{"id", "limits"}});
  limits_table(out, input);
  return out.close();
}

std::string calibrations_text(const Provenance& p) {
  if (p.calibrations.size() == 1) return p.calibrations[0].id;
  std::string text;
  for (const CalibrationUse& c : p.calibrations)
    text += fmt::format("{}{} ({} {})", text.empty() ? "" : ", ", c.id.empty() ? "none" : c.id,
                        c.shots.find(' ') == std::string::npos ? "shot" : "shots", c.shots);
  return text;
}

/// The last day on which the instrument was used.
static std::string last_day(const ReportInput& input, const Instrument& i) {
  if (input.origin == Origin::import) return input.test.recorded;
  const Provenance& p = input.provenance;
  for (const CalibrationUse& c : p.calibrations)
    if (c.id == i.certificate) return c.last_day;
  return std::max(p.started, p.finished).substr(0, day_length);
}

std::vector<Instrument> expired_then(const ReportInput& input) {
  std::vector<Instrument> list;
  for (const std::string& text : input.test.instruments) {
    Instrument i;
    if (!read_instrument(text, i).empty() || i.valid_until.empty()) continue;
    if (i.valid_until < last_day(input, i)) list.push_back(i);
  }
  return list;
}

/// "the test began on 2030-12-31" where it had expired before that.
static std::string when_used(const ReportInput& input, const Instrument& i) {
  if (input.origin == Origin::import) return "recorded on " + input.test.recorded;
  const std::string began = input.provenance.started.substr(0, day_length);
  return i.valid_until < began ? "the test began on " + began : "used until " + last_day(input, i);
}

/// Empty if no entry was given: an empty form would look like a completed one.
Markup record_section(const ReportInput& input) {
  Markup out;
  const TestRecord& test = input.test;
  const bool imported = input.origin == Origin::import;
  bool told = !test.instruments.empty();
  for (const RecordField& f : record_fields) told = told || !(test.*f.place).empty();
  out.open("section", {{"id", "record"}}).element("h3", "Test record");
  if (!told) {
    out.element(
        "p",
        "None: the plan has no section [test], and nothing was added later (`powbench annotate`, or 'Add to "
        "the report' of the live bench).",
        {{"class", "fine"}});
    return out.close();
  }
  for (const Instrument& i : expired_then(input))
    out.element("p",
                fmt::format("Calibration expired: {}, certificate {}, was valid until {}; {}.", i.name,
                            i.certificate, i.valid_until, when_used(input, i)),
                {{"class", "warn"}});
  if (imported && test.recorded.empty() && !test.instruments.empty())
    out.element(
        "p",
        "Whether the calibrations were in force cannot be judged: when the records were taken is not known.",
        {{"class", "fine"}});
  out.open("dl", {{"class", "provenance"}});
  const auto item = [&](std::string_view key, std::string_view value) {
    out.open("div").element("dt", key).element("dd", value).close();
  };
  for (const RecordField& f : record_fields)
    if (!(test.*f.place).empty()) item(f.label, test.*f.place);
  for (const std::string& text : test.instruments) {
    Instrument i;
    if (!read_instrument(text, i).empty()) continue;
    item("Instrument",
         fmt::format("{}, certificate {}{}", i.name, i.certificate,
                     i.valid_until.empty() ? ", validity not stated" : ", valid until " + i.valid_until));
  }
  out.close();
  if (input.annotations > 0)
    out.element(
        "p",
        fmt::format("Completed by {} annotation{}, the last of {}; the plan as it was fired is unchanged.",
                    input.annotations, input.annotations == 1 ? "" : "s", input.annotated),
        {{"class", "fine"}});
  return out.close();
}

Markup provenance_section(const ReportInput& input) {
  Markup out;
  out.open("section", {{"id", "provenance"}});
  provenance_list(out, input);
  out.open("div", {{"class", "sign"}});
  for (const std::string_view line : {"Tested by", "Approved by", "Date of issue"}) out.element("p", line);
  out.close();
  return out.close();
}

}  // namespace powbench::host
