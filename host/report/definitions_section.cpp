#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "core/quantities.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

void term(Markup& out, std::string_view word, std::string_view meaning) {
  out.element("dt", word).element("dd", meaning);
}

std::string joined(const std::set<std::string>& words) {
  std::string all;
  for (const auto& w : words) all += (all.empty() ? "" : ", ") + w;
  return all.empty() ? std::string(no_value) : all;
}

/// Which channel the contact times of each shot come from, with what that channel can resolve.
std::string timing_channels(const ReportInput& input) {
  std::set<std::string> seen;
  for (const auto& shot : input.shots) {
    if (!shot.events) continue;
    const ContactTrain& train = timing_train(*shot.events);
    const Events& e = *shot.events;
    const std::string channel = e.contact_voltage.present ? "contact voltage"
                                : e.pole.by_force.present ? "both forces, closed while both breaks are"
                                : e.pvdf_a.present ? "force A of one break alone: the pole may close later"
                                                   : "force B of one break alone: the pole may close later";
    seen.insert(
        fmt::format("{} (shortest opening resolved: {:.0f} \xC2\xB5s)", channel, train.resolution * 1e6));
  }
  return joined(seen);
}

/// 6.0000000000000002e-05 reads 6e-05: the shortest text of the same number.
std::string shortest(const std::string& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end ? fmt::format("{}", value) : text;
}

/// `hertz_given`: somebody said what the mains frequency was; else the value is where the search for it begins.
void parameter_table(Markup& out, const std::string& text, bool hertz_given) {
  out.element("h3", "Extraction parameters");
  out.open("div", {{"class", "columns"}}).open("table", {{"class", "parameters"}}).open("tbody");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto equal = line.find('=');
    if (equal == std::string::npos) continue;
    out.open("tr").element("th", line.substr(0, equal), {{"scope", "row"}});
    const bool assumed = !hertz_given && line.substr(0, equal) == "mains_hertz";
    out.element("td", shortest(line.substr(equal + 1)) + (assumed ? ", assumed: not given" : "")).close();
  }
  out.close().close().close();
}

}  // namespace

Markup definitions_section(const ReportInput& input) {
  std::set<std::string> methods, hashes;
  for (const auto& shot : input.shots) {
    if (!shot.events) continue;
    if (!shot.events->method.empty()) methods.insert(shot.events->method);
    if (!shot.events->parameters_hash.empty()) hashes.insert(shot.events->parameters_hash);
  }
  Markup out;
  out.open("section", {{"id", "definitions"}});
  out.element("h2", "Definitions and method");
  out.open("dl");
  term(out, "Closing angle",
       "Phase of the coil voltage at switch-on; 0\xC2\xB0 is its rising zero crossing, sine reference.");
  term(out, "Time zero",
       "Switch-on is the step of the coil voltage. Where the record does not tell it from its own time 0 by "
       "20 "
       "\xC2\xB5s and three u, or has no coil voltage, times count from there: the gate edge, the rig's "
       "command to "
       "the coil switch, or the zero of the file that was imported.");
  for (const auto& q : quantity_table)
    term(out, q.symbol, fmt::format("{} ({})", q.meaning, readable_unit(q.unit).name));
  term(out, "Contact closed",
       "The measured pole is closed while both its breaks are closed. Openings too short for the channel are "
       "not "
       "resolved. Pulsation of the force after settling, at twice the mains frequency, is not bounce.");
  term(out, "Contact times from", timing_channels(input));
  term(out, "Extraction", fmt::format("{}; parameters {}", joined(methods), joined(hashes)));
  term(
      out, "Uncertainty U",
      "U = k u with the standard uncertainty u combined from the scatter of the mean (type A, s / "
      "\xE2\x88\x9An) and the "
      "events' own uncertainty, taken as common to all repeats (type B). k is the two-sided 95.45 % quantile "
      "of Student's "
      "t at the effective degrees of freedom after Welch and Satterthwaite: 2.000 where they are infinite. "
      "s: standard deviation of the "
      "repeats.");
  term(out, "Limits",
       fmt::format("{} Every single repeat counts; of one shot U = 2 u. A quantity without a limit is NOT "
                   "JUDGED, a limited one "
                   "that a record does not show is NOT OBSERVED, and neither is a pass.",
                   decision_text(input.decision)));
  term(out, "agrees, differs",
       "Simulation and measurement agree where their difference is at most its expanded uncertainty U, and "
       "differ beyond. The simulation of an angle runs under the means of what its closings had: angle "
       "reached, "
       "supply voltage, frequency; its \xC2\xB1 is what their uncertainties and that of the coil's "
       "temperature move a closing of the lumped circuit by, whatever model the value is of. "
       "\xE2\x80\x9Cs to sim.\xE2\x80\x9D: standard deviation of the repeats, each less the simulation "
       "at the angle, voltage and frequency that it reached itself; smaller than s where those explain the "
       "scatter, larger where the simulation depends on them more than the device. "
       "Errors of the model are not in it. Without a \xC2\xB1 the inputs do not move it, or the simulation "
       "ran under "
       "the conditions asked for, and U is that of the measurement alone.");
  term(out, "Best closing angle",
       "The measured angle with the smallest mean bounce time; angles at which a closing did not settle are "
       "left "
       "out. Confidence: one minus the sum, over the other "
       "angles, of the "
       "probability that theirs is smaller (Student's t of the difference). Random closing: each measured "
       "angle equally likely.");
  if (!input.published.empty())
    term(out, "Published values",
         fmt::format("Tables 1 and 2 of \xE2\x80\x9C{}\xE2\x80\x9D: another device, single shots, "
                     "thresholds not printed. Shown for orientation.",
                     paper_closing));
  term(out, "two groups",
       "The repeats fall into two separate groups, as happens near a closing angle where the device "
       "just fails to close within one half-wave; their mean describes neither.");
  out.close();
  if (!input.extraction_parameters.empty())
    parameter_table(out, input.extraction_parameters,
                    std::all_of(input.shots.begin(), input.shots.end(),
                                [](const ReportShot& s) { return std::isfinite(s.conditions.mains_hertz); }));
  return out.close();
}

}  // namespace powbench::host
