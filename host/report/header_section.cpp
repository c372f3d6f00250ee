#include <fmt/format.h>

#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

/// "230 V, 50 Hz" from the shots; every value that occurs.
std::string conditions_text(const ReportInput& input) {
  Range volts, hertz;
  for (const auto& s : input.shots) {
    volts.include(s.conditions.supply_volts);
    hertz.include(s.conditions.mains_hertz);
  }
  const auto text = [](const Range& r, std::string_view unit) {
    return r.empty()      ? std::string()
           : r.span() > 0 ? fmt::format("{:g}..{:g} {}", r.low, r.high, unit)
                          : fmt::format("{:g} {}", r.low, unit);
  };
  if (volts.empty()) return "";
  return fmt::format("{}, {}", text(volts, "V"), text(hertz, "Hz"));
}

}  // namespace

std::string_view badge_class(Outcome o) {
  return o == Outcome::pass ? "badge pass" : o == Outcome::fail ? "badge fail" : "badge error";
}

Markup header_section(const ReportInput& input) {
  const Outcome result = verdict(input);
  Markup out;
  out.open("header");
  out.open("div", {{"class", "title"}});
  out.element("p", "Closing dynamics, measured and simulated", {{"class", "kicker"}});
  out.element(
      "h1", input.campaign.empty() ? std::string_view("unnamed campaign") : std::string_view(input.campaign));
  std::string line =
      fmt::format("Specimen {}", input.specimen.empty() ? no_value : std::string_view(input.specimen));
  const std::string conditions = conditions_text(input);
  if (!conditions.empty()) line += fmt::format("  \xC2\xB7  {}", conditions);
  if (!input.provenance.started.empty()) line += fmt::format("  \xC2\xB7  {}", input.provenance.started);
  if (!input.provenance.finished.empty()) line += fmt::format(" to {}", input.provenance.finished);
  out.element("p", line, {{"class", "subtitle"}});
  out.close();
  out.element("div", name(result),
              {{"class", result == Outcome::pass   ? "verdict pass"
                         : result == Outcome::fail ? "verdict fail"
                                                   : "verdict error"}});
  return out.close();
}

}  // namespace powbench::host
