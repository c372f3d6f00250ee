#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/report/markup.h"
#include "host/report/report.h"

namespace powbench::host {
namespace {

struct Case {
  std::string name;
  std::string group;
  Outcome outcome = Outcome::pass;
  std::string message;
};

/// What JUnit calls it; "" for a pass.
std::string_view element_of(Outcome o) {
  switch (o) {
    case Outcome::pass:
      return "";
    case Outcome::fail:
    case Outcome::not_observed:
      return "failure";
    case Outcome::not_judged:
      return "skipped";
    default:
      return "error";
  }
}

std::string case_angle(double angle) {
  if (!std::isfinite(angle)) return "an angle not known";
  return fmt::format("{:.2f} deg", degrees(angle));
}

Case shot_case(const ReportShot& shot) {
  Case c{fmt::format("shot {} at {}", shot.index, case_angle(effective_angle(shot.conditions))), "shots",
         shot.outcome, shot.reason};
  if (c.outcome == Outcome::not_judged && c.message.empty()) c.message = "measured; the plan sets no limit";
  if (c.outcome != Outcome::pass && c.message.empty()) c.message = name(c.outcome);
  return c;
}

Case limit_case(const ReportInput& input, const Limit& limit) {
  Case c{limit.quantity + " " + range_text(limit), "limits", Outcome::pass, ""};
  bool seen = false;
  for (const auto& row : input.comparison.rows) {
    if (row.quantity != limit.quantity) continue;
    seen = true;
    if (row.outcome == Outcome::pass) continue;
    c.outcome = worse(c.outcome, row.outcome);
    if (!c.message.empty()) c.message += "; ";
    c.message += row.outcome == Outcome::fail           ? "outside at "
                 : row.outcome == Outcome::not_observed ? "not observed at "
                 : row.outcome == Outcome::not_judged   ? "uncertainty not known at "
                                                        : "no measurement at ";
    c.message += case_angle(row.closing_angle);
  }
  if (!seen) c.outcome = Outcome::error, c.message = "no measurement";
  return c;
}

Case simulation_case(const ReportInput& input) {
  Case c{fmt::format("difference from the simulation \xE2\x89\xA4 {:g} %", input.most_from_simulation * 100),
         "limits", Outcome::not_judged, ""};
  for (const auto& row : input.comparison.rows) {
    if (row.against_simulation == Outcome::pass && c.outcome == Outcome::not_judged)
      c.outcome = Outcome::pass;
    if (row.against_simulation != Outcome::fail) continue;
    c.outcome = Outcome::fail;
    c.message += fmt::format("{}{} at {}", c.message.empty() ? "outside: " : ", ", row.quantity,
                             case_angle(row.closing_angle));
  }
  if (c.outcome == Outcome::not_judged) c.message = "nothing simulated to compare with";
  return c;
}

Case completeness_case(const ReportInput& input) {
  const Counts n = count(input);
  Case c{"all planned shots fired", "campaign", Outcome::pass, ""};
  if (only_computed(input)) {
    c.outcome = Outcome::not_judged;
    c.message = meaning(input.origin);
  } else if (n.missing > 0 || n.planned == 0) {
    c.outcome = Outcome::aborted;
    c.message = fmt::format("{} of {} planned shots fired", n.planned - n.missing, n.planned);
    if (!input.course.empty()) c.message += "; " + last_of_course(input);
  }
  return c;
}

/// Instruments without a last day, and calibrations that came into force later and of which no instrument tells.
std::string without_validity(const ReportInput& input) {
  std::string list;
  const auto add = [&](const std::string& what) { list += (list.empty() ? "" : "; ") + what; };
  std::set<std::string> told;
  for (const std::string& text : input.test.instruments) {
    Instrument i;
    if (!read_instrument(text, i).empty()) continue;
    told.insert(i.certificate);
    if (i.valid_until.empty()) add(i.name + ", certificate " + i.certificate);
  }
  const auto& used = input.provenance.calibrations;
  for (const CalibrationUse& c : used)
    if (used.size() > 1 && !told.contains(c.id))
      add(fmt::format("calibration {} of {} {}", c.id.empty() ? "none" : c.id,
                      c.shots.find(' ') == std::string::npos ? "shot" : "shots", c.shots));
  return list;
}

Case calibration_case(const ReportInput& input) {
  Case c{"calibrations of the instruments in force", "record", Outcome::pass, ""};
  for (const Instrument& i : expired_then(input)) {
    c.outcome = Outcome::not_judged;
    c.message += fmt::format("{}{}, certificate {}, was valid until {}",
                             c.message.empty() ? "expired: " : "; ", i.name, i.certificate, i.valid_until);
  }
  if (c.outcome == Outcome::pass && input.origin == Origin::import && input.test.recorded.empty())
    return {c.name, c.group, Outcome::not_judged, "when the records were taken is not known"};
  const std::string unstated = without_validity(input);
  if (unstated.empty()) return c;
  c.outcome = Outcome::not_judged;
  c.message += (c.message.empty() ? "" : "; ") + ("validity not stated: " + unstated);
  return c;
}

}  // namespace

std::string render_junit(const ReportInput& input) {
  std::vector<Case> cases;
  if (!input.unplanned || input.shots.empty()) cases.push_back(completeness_case(input));
  for (const auto& shot : input.shots) cases.push_back(shot_case(shot));
  for (const auto& limit : input.limits) cases.push_back(limit_case(input, limit));
  if (std::isfinite(input.most_from_simulation)) cases.push_back(simulation_case(input));
  if (!input.test.instruments.empty()) cases.push_back(calibration_case(input));
  std::size_t failures = 0, errors = 0, skips = 0;
  for (const auto& c : cases) {
    const std::string_view e = element_of(c.outcome);
    failures += e == "failure" ? 1U : 0U;
    errors += e == "error" ? 1U : 0U;
    skips += e == "skipped" ? 1U : 0U;
  }
  const std::string tests = fmt::format("{}", cases.size()), failed = fmt::format("{}", failures),
                    broken = fmt::format("{}", errors), skipped = fmt::format("{}", skips);
  Markup out;
  out.open("testsuites", {{"tests", tests}, {"failures", failed}, {"errors", broken}, {"skipped", skipped}});
  out.open("testsuite", {{"name", input.campaign},
                         {"tests", tests},
                         {"failures", failed},
                         {"errors", broken},
                         {"skipped", skipped}});
  out.open("properties");
  const auto property = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) out.empty("property", {{"name", key}, {"value", value}});
  };
  const Provenance& p = input.provenance;
  property("origin", std::string(name(input.origin)));
  property("verdict", std::string(name(verdict(input))));
  property("decision_rule", std::string(decision_text(input.decision)));
  property("specimen", input.specimen);
  property("program", p.program);
  property("rig", p.rig);
  property("firmware", p.firmware);
  property("calibration", calibrations_text(p));
  property("plan_hash", p.plan_hash);
  property("extraction_hash", p.extraction_hash);
  property("seed", p.seed);
  out.close();
  for (const auto& c : cases) {
    out.open("testcase", {{"classname", input.campaign + "." + c.group}, {"name", c.name}});
    const std::string_view element = element_of(c.outcome);
    if (element == "skipped")
      out.empty(element, {{"message", c.message}});
    else if (!element.empty())
      out.empty(element, {{"type", name(c.outcome)}, {"message", c.message}});
    out.close();
  }
  out.close().close();
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + out.str();
}

}  // namespace powbench::host
