#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/report/report.h"
#include "host/report/sections.h"

namespace powbench::host {

bool only_computed(const ReportInput& input) {
  return input.origin == Origin::simulation && input.shots.empty();
}

Counts count(const ReportInput& input) {
  Counts c;
  c.planned = only_computed(input) ? 0 : std::max(input.planned, input.shots.size());
  for (const auto& shot : input.shots) {
    c.passed += shot.outcome == Outcome::pass ? 1U : 0U;
    c.failed += shot.outcome == Outcome::fail ? 1U : 0U;
    c.not_judged += shot.outcome == Outcome::not_judged ? 1U : 0U;
    c.not_observed += shot.outcome == Outcome::not_observed ? 1U : 0U;
  }
  c.done = c.passed + c.failed + c.not_judged + c.not_observed;
  c.errors = input.shots.size() - c.done;
  c.missing = c.planned - input.shots.size();
  return c;
}

Outcome verdict(const ReportInput& input) {
  if (only_computed(input)) return Outcome::not_judged;
  const Counts c = count(input);
  if (c.planned == 0) return Outcome::aborted;
  Outcome worst = c.missing > 0 ? Outcome::aborted : Outcome::pass;
  for (const auto& shot : input.shots) worst = worse(worst, shot.outcome);
  bool simulation_judged = false;
  for (const auto& row : input.comparison.rows) {
    const bool limited = std::any_of(input.limits.begin(), input.limits.end(),
                                     [&](const Limit& l) { return l.quantity == row.quantity; });
    if (limited && row.outcome != Outcome::error)
      worst = worse(worst, row.outcome);  // of an error the shots say more
    simulation_judged = simulation_judged || row.against_simulation == Outcome::pass;
    if (row.against_simulation == Outcome::fail) worst = Outcome::fail;
  }
  // without limits on the quantities, the one on the difference from the simulation may have been judged
  if (worst == Outcome::not_judged && input.limits.empty() && simulation_judged) return Outcome::pass;
  // a limit that nothing was held against is no limit that was kept
  if (std::isfinite(input.most_from_simulation) && !simulation_judged)
    return worse(worst, Outcome::not_judged);
  return worst;
}

/// On paper each page says what it is of. A text of CSS: what could end it is written as its code.
static std::string running_foot(const ReportInput& input) {
  std::string said;
  const std::string order = input.test.order.empty() ? "" : ", order " + input.test.order;
  for (const char c : fmt::format("{}{}, {}, {}", input.campaign, order, name(input.origin),
                                  input.provenance.started.substr(0, 10))) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) != 0 || byte >= 0x80 ||
                       std::string_view(" .,:-_()/").find(c) != std::string_view::npos;
    said += plain ? std::string(1, c) : fmt::format("\\{:x} ", byte);
  }
  return fmt::format("@page {{ @bottom-left {{ content: \"{}\"; }} }}", said);
}

std::string render_html(const ReportInput& input) {
  Markup out;
  out.open("html", {{"lang", "en"}});
  out.open("head");
  out.empty("meta", {{"charset", "utf-8"}});
  out.empty("meta", {{"name", "color-scheme"}, {"content", "light dark"}});
  out.empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}});
  out.element("title", input.campaign + " \xE2\x80\x93 closing dynamics");
  out.embed(page_style());
  out.verbatim("style", running_foot(input));
  out.close();
  out.open("body").open("main");
  out.embed(header_section(input));
  out.embed(answers_section(input));
  out.embed(record_section(input));
  out.embed(limits_section(input));
  const auto angles = angles_of(input);
  // of one angle alone its own page shows all of it
  const bool over_angles = angles.size() > 1 || !input.published.empty();
  if (over_angles) out.embed(chart_section(input));
  if (!angles.empty()) out.embed(closer_section(input));
  // on paper one closing and where everything comes from share a page
  out.open("div", {{"class", "together"}});
  if (over_angles && !angles.empty()) out.embed(typical_section(input));
  out.embed(provenance_section(input));
  out.close();
  out.open("h2", {{"class", "appendix"}}).text("Appendix").close();
  const Range window = time_window(input);
  for (const auto& view : angles) out.embed(angle_section(input, view, window));
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
