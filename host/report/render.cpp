#include <algorithm>

#include "host/report/report.h"
#include "host/report/sections.h"

namespace powbench::host {

Counts count(const ReportInput& input) {
  Counts c;
  c.planned = std::max(input.planned, input.shots.size());
  for (const auto& shot : input.shots) {
    c.passed += shot.outcome == Outcome::pass ? 1U : 0U;
    c.failed += shot.outcome == Outcome::fail ? 1U : 0U;
  }
  c.done = c.passed + c.failed;
  c.errors = input.shots.size() - c.done;
  c.missing = c.planned - input.shots.size();
  return c;
}

Outcome verdict(const ReportInput& input) {
  const auto any = [&](Outcome o) {
    return std::any_of(input.shots.begin(), input.shots.end(),
                       [&](const ReportShot& s) { return s.outcome == o; });
  };
  const bool row_failed = std::any_of(input.comparison.rows.begin(), input.comparison.rows.end(),
                                      [](const ComparisonRow& row) { return row.outcome == Outcome::fail; });
  if (any(Outcome::fail) || row_failed) return Outcome::fail;
  for (const Outcome o : {Outcome::error, Outcome::timeout, Outcome::aborted})
    if (any(o)) return o;
  const Counts c = count(input);
  return c.missing > 0 || c.done == 0 ? Outcome::aborted : Outcome::pass;
}

std::string render_html(const ReportInput& input) {
  Markup out;
  out.open("html", {{"lang", "en"}});
  out.open("head");
  out.empty("meta", {{"charset", "utf-8"}});
  out.empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}});
  out.element("title", input.campaign + " \xE2\x80\x93 closing dynamics");
  out.embed(page_style());
  out.close();
  out.open("body").open("main");
  out.embed(header_section(input));
  out.embed(summary_section(input));
  const auto angles = angles_of(input);
  if (!angles.empty()) {
    const Range window = time_window(input);
    out.embed(chart_section(input));
    for (const auto& view : angles) out.embed(angle_section(input, view, window));
  }
  if (input.vibration) out.embed(vibration_section(*input.vibration));
  out.embed(shot_section(input));
  out.embed(definitions_section(input));
  out.open("footer");
  out.element("p", input.provenance.program.empty() ? std::string_view("powbench")
                                                    : std::string_view(input.provenance.program));
  out.close();
  out.close().close().close();
  return "<!DOCTYPE html>\n" + out.str();
}

}  // namespace powbench::host
