#include <fmt/format.h>

#include "core/units.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

/// "230 V, 50 Hz" from the shots; every value that occurs.
std::string conditions_text(const ReportInput& input) {
  Range volts, hertz, kelvin, measured_volts, measured_hertz;
  for (const auto& s : input.shots) {
    volts.include(s.conditions.supply_volts);
    hertz.include(s.conditions.mains_hertz);
    kelvin.include(s.conditions.ambient);
    if (!s.events) continue;
    measured_volts.include(s.events->coil.supply_volts.value);
    measured_hertz.include(s.events->coil.mains_hertz.value);
  }
  const auto text = [](const Range& asked, const Range& found, std::string_view unit, std::string_view what) {
    const Range& r = asked.empty() ? found : asked;
    if (r.empty()) return fmt::format("{} not known", what);
    const auto read = [&](const Range& of) {
      return fixed(of.high, 2) == fixed(of.low, 2)
                 ? fmt::format("{:.6g} {}", of.low, unit)
                 : fmt::format("{:.5g} to {:.5g} {}", of.low, of.high, unit);
    };
    if (asked.empty()) return read(r) + " measured";
    return found.empty() || read(found) == read(asked)
               ? read(asked)
               : fmt::format("{} ({} measured)", read(asked), read(found));
  };
  if (input.shots.empty()) return "";
  const std::string ambient = kelvin.empty() ? ""
                                             : fmt::format(
                                                   ", {:.3g} \xC2\xB0"
                                                   "C ambient",
                                                   kelvin.low - zero_celsius);
  return fmt::format("{}, {}{}", text(volts, measured_volts, "V", "supply voltage"),
                     text(hertz, measured_hertz, "Hz", "mains frequency"), ambient);
}

constexpr std::size_t day_length = 10, second_length = 19;  // of an ISO time

/// Both as `time_text`; the day once where both are of one day.
std::string time_span(const std::string& from, const std::string& to) {
  if (from.size() <= second_length || to.size() <= second_length || to == from) return time_text(from);
  const std::string end = time_text(to);
  return time_text(from).substr(0, second_length) + " to " +
         (to.substr(0, day_length) == from.substr(0, day_length) ? end.substr(day_length + 1) : end);
}

}  // namespace

std::string time_text(const std::string& iso) {
  if (iso.size() <= second_length) return iso;
  return iso.substr(0, day_length) + " " + iso.substr(day_length + 1, second_length - day_length - 1) +
         " UTC";
}

std::string_view badge_class(Outcome o) {
  return o == Outcome::pass         ? "badge pass"
         : o == Outcome::fail       ? "badge fail"
         : o == Outcome::not_judged ? "badge open"
                                    : "badge error";
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
  std::string span = time_span(input.provenance.started, input.provenance.finished);
  if (input.origin == Origin::import)  // when the record was taken only its owner knows
    span = fmt::format("recorded: {}; imported on {}",
                       input.test.recorded.empty() ? "not known" : input.test.recorded,
                       input.provenance.started.substr(0, 10));
  if (!span.empty()) line += "  \xC2\xB7  " + span;
  out.element("p", line, {{"class", "subtitle"}});
  out.open("p", {{"class", "origin"}}).element("b", name(input.origin));
  out.text(fmt::format(" {}", meaning(input.origin)));
  if (input.origin == Origin::import)
    out.text(input.test.source.empty() ? " What they were taken from is not said."
                                       : fmt::format(" Taken from: {}.", input.test.source));
  out.close();
  out.close();
  out.element("div", name(result),
              {{"class", result == Outcome::pass         ? "verdict pass"
                         : result == Outcome::fail       ? "verdict fail"
                         : result == Outcome::not_judged ? "verdict open"
                                                         : "verdict error"}});
  return out.close();
}

}  // namespace powbench::host
