#include <fmt/format.h>

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

std::string angle_text(double angle) {
  return fmt::format("{:.2f} deg", degrees(angle));
}

Case shot_case(const ReportShot& shot) {
  Case c{fmt::format("shot {} at {}", shot.index, angle_text(effective_angle(shot.conditions))), "shots",
         shot.outcome, shot.reason};
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
    if (c.outcome != Outcome::fail) c.outcome = row.outcome;
    if (!c.message.empty()) c.message += "; ";
    c.message += row.outcome == Outcome::fail ? "outside at " : "no measurement at ";
    c.message += angle_text(row.closing_angle);
  }
  if (!seen) c.outcome = Outcome::error, c.message = "no measurement";
  return c;
}

Case completeness_case(const ReportInput& input) {
  const Counts n = count(input);
  Case c{"all planned shots fired", "campaign", Outcome::pass, ""};
  if (n.missing > 0 || n.planned == 0) {
    c.outcome = Outcome::aborted;
    c.message = fmt::format("{} of {} planned shots fired", n.planned - n.missing, n.planned);
  }
  return c;
}

}  // namespace

std::string render_junit(const ReportInput& input) {
  std::vector<Case> cases{completeness_case(input)};
  for (const auto& shot : input.shots) cases.push_back(shot_case(shot));
  for (const auto& limit : input.limits) cases.push_back(limit_case(input, limit));
  std::size_t failures = 0, errors = 0;
  for (const auto& c : cases) {
    failures += c.outcome == Outcome::fail ? 1U : 0U;
    errors += c.outcome != Outcome::fail && c.outcome != Outcome::pass ? 1U : 0U;
  }
  const std::string tests = fmt::format("{}", cases.size()), failed = fmt::format("{}", failures),
                    broken = fmt::format("{}", errors);
  Markup out;
  out.open("testsuites", {{"tests", tests}, {"failures", failed}, {"errors", broken}});
  out.open("testsuite", {{"name", input.campaign},
                         {"tests", tests},
                         {"failures", failed},
                         {"errors", broken},
                         {"skipped", "0"}});
  out.open("properties");
  const auto property = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) out.empty("property", {{"name", key}, {"value", value}});
  };
  const Provenance& p = input.provenance;
  property("specimen", input.specimen);
  property("program", p.program);
  property("rig", p.rig);
  property("firmware", p.firmware);
  property("calibration", p.calibration);
  property("plan_hash", p.plan_hash);
  property("extraction_hash", p.extraction_hash);
  property("seed", p.seed);
  out.close();
  for (const auto& c : cases) {
    out.open("testcase", {{"classname", input.campaign + "." + c.group}, {"name", c.name}});
    if (c.outcome != Outcome::pass)
      out.empty(c.outcome == Outcome::fail ? "failure" : "error",
                {{"type", name(c.outcome)}, {"message", c.message}});
    out.close();
  }
  out.close().close();
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + out.str();
}

}  // namespace powbench::host
