#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/counted.h"
#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/report/best_angle.h"
#include "host/report/number.h"
#include "host/report/sections.h"

/// The first page's answers: verdict, best angle, agreement, and the times themselves.

namespace powbench::host {
namespace {

constexpr std::size_t most_ranked = 5, most_angles = 12;

void answer(Markup& out, std::string_view question, std::string_view main, const std::string& detail) {
  out.open("div", {{"class", "answer"}});
  out.element("h3", question).element("p", main, {{"class", "main"}});
  if (!detail.empty()) out.element("p", detail, {{"class", "fine"}});
  out.close();
}

void verdict_answer(Markup& out, const ReportInput& input) {
  const Counts c = count(input);
  std::string detail = only_computed(input) ? std::string("no closing was measured")
                       : input.unplanned
                           ? fmt::format("{} measured, none was planned", counted(c.done, "closing"))
                           : fmt::format("{} of {} measured", c.done, counted(c.planned, "planned closing"));
  const auto add = [&](std::size_t n, std::string_view what) {
    if (n > 0) detail += fmt::format(", {} {}", n, what);
  };
  if (!input.limits.empty()) add(c.passed, "inside the limits");
  add(c.failed, "outside");
  add(c.not_observed, "not observed");
  add(c.not_judged, "not judged");
  add(c.errors, "without a valid measurement");
  add(c.missing, "not fired");
  detail += ". ";
  if (const std::string why = verdict_reason(input); !why.empty()) detail += "Why: " + why + ". ";
  detail +=
      input.limits.empty() && !std::isfinite(input.most_from_simulation)
          ? std::string(only_computed(input)            ? meaning(input.origin)
                        : c.failed + c.not_observed > 0 ? "The plan sets no limit on a quantity."
                        : input.angle_tolerance > 0
                            ? "The plan sets no limit on a quantity; only the closing angle has a tolerance."
                            : "The plan sets no limit, so nothing was judged.")
          : std::string(decision_text(input.decision));
  answer(out, "Verdict", name(verdict(input)), detail);
}

void best_answer(Markup& out, const ReportInput& input) {
  const BestAngle b = best_angle(input.comparison);
  const bool bounced =
      std::any_of(input.comparison.rows.begin(), input.comparison.rows.end(),
                  [](const auto& r) { return r.quantity == "t_ct_bon" && r.measured.known(); });
  if (b.angles == 0 && bounced)
    return answer(out, "Best closing angle", "not known",
                  "Bounce was measured, but the closing angle of none of these closings is known.");
  if (b.angles == 0)
    return answer(out, "Best closing angle", "not observed",
                  b.unsettled > 0 ? "At no angle did every closing settle." : "No bounce time was measured.");
  const std::string bounce = with_uncertainty(b.bounce, b.coverage, 1e3, 2) + " ms of contact bounce";
  if (b.angles == 1)
    return answer(out, "Best closing angle", "not known",
                  fmt::format("Only {} was measured: {}.", angle_text(b.angle), bounce));
  std::string sure = "How sure that is, is not known: it takes two closings at each angle.";
  if (std::isfinite(b.confidence))
    sure = b.confidence < 0.5
               ? fmt::format("Not told apart from {} (confidence below 50 %).", angle_text(b.runner_up))
               : fmt::format(
                     "Confidence {}{:.0f} % that none of the other {} is better; next is {}.",
                     b.confidence > 0.995 ? "above " : "", std::min(99.0, std::floor(b.confidence * 100)),
                     b.angles == 2 ? "measured angle" : fmt::format("{} measured angles", b.angles - 1),
                     angle_text(b.runner_up));
  for (const ComparisonRow& row : input.comparison.rows)
    if (same_angle(row.closing_angle, b.angle) && row.outcome == Outcome::fail) {
      sure += fmt::format(" But {} is outside its limit there.", row.quantity);
      break;
    }
  if (b.two_modes) sure += " The repeats there fall into two groups.";
  if (b.unsettled > 0)
    sure += fmt::format(" {} left out: not every closing there settled.", counted(b.unsettled, "angle"));
  answer(out, "Best closing angle", fmt::format("{}: {}", angle_text(b.angle), bounce),
         fmt::format("{} Closing at random among them bounces {} ms longer on average ({} %).", sure,
                     with_uncertainty(b.gain, b.gain_coverage, 1e3, 2),
                     fixed(100 * b.gain.value / (b.bounce.value + b.gain.value), 0)));
}

std::string times_text(double E) {
  return E < 9.995 ? fixed(E, 2) : fixed(E, 0);
}

/// What the simulations are of, where it is not the conditions that the closings had.
std::string simulated_of(const ReportInput& input) {
  const auto all = input.simulated.size();
  const auto count = [&](bool SimulatedClosing::*is) {
    return static_cast<std::size_t>(
        std::count_if(input.simulated.begin(), input.simulated.end(), [&](const auto& s) { return s.*is; }));
  };
  std::string text;
  if (const auto n = count(&SimulatedClosing::nominal); n > 0)
    text += fmt::format(
        " Simulated {}at the conditions that the plan asks for, not those of the closings; the simulation's "
        "uncertainty is not known.",
        n < all ? fmt::format("in {} of {} angles ", n, all) : "");
  if (const auto n = count(&SimulatedClosing::outdated); n > 0)
    text += fmt::format(
        " {} of {} simulations {} older than closings of {} angle: run powbench sim again, it renews them.",
        n, all, n == 1 ? "is" : "are", n == 1 ? "its" : "their");
  return text;
}

/// Quantities that are simulated off to one side at every angle, whether each is within U or not. Scatter alone does
/// so at six angles once in 32 for each quantity; what all angles share, such as the scale of a channel, does it
/// every time: so it is told, not judged.
std::string one_sided(const ReportInput& input) {
  constexpr int fewest = 6;
  std::string text;
  for (const std::string_view quantity : {"t_ct1", "t_ct_bon", "t_xt1", "i_peak"}) {
    int above = 0, below = 0;
    double sum = 0;
    std::string_view si;
    for (const ComparisonRow& row : input.comparison.rows) {
      const double off = row.simulated - row.measured.value;
      if (row.quantity != quantity || !std::isfinite(off)) continue;
      (off > 0 ? above : below) += off != 0 ? 1 : 0;
      sum += off;
      si = row.unit;
    }
    const int n = above + below;
    if (n < fewest || (above > 0 && below > 0)) continue;
    const ReadableUnit unit = readable_unit(si);
    const double mean = sum / n * unit.per_si;
    text += fmt::format(" {} is simulated {} at all {} angles, by {} {} on average.", quantity,
                        above > 0 ? "higher" : "lower", n,
                        fixed(std::fabs(mean), decimals_for(std::fabs(mean), unit.decimals)), unit.name);
  }
  return text;
}

std::string largest_difference(const ComparisonRow& worst) {
  const ReadableUnit unit = readable_unit(worst.unit);
  return fmt::format("Largest difference over U: {} at {}, measured {} {}, simulated {} {}: {} U.",
                     worst.quantity, angle_text(worst.closing_angle),
                     with_uncertainty(worst.measured, worst.coverage, unit.per_si, unit.decimals), unit.name,
                     simulated_text(worst), unit.name, times_text(worst.difference_over_U()));
}

/// "t_ct1 at 60° is measured and not simulated (and 2 more)"; empty: none.
std::string seen_in_one(const Comparison& comparison) {
  std::string first;
  int more = 0;
  for (const ComparisonRow& r : comparison.rows) {
    if (!r.seen_in_one) continue;
    if (first.empty())
      first = fmt::format("{} at {} is {}", r.quantity, angle_text(r.closing_angle),
                          r.measured.known() ? "measured and not simulated" : "simulated and not measured");
    else
      ++more;
  }
  return more > 0 ? first + fmt::format(" (and {} more)", more) : first;
}

void agreement_answer(Markup& out, const ReportInput& input, const std::vector<const ComparisonRow*>& rows) {
  const std::string one = seen_in_one(input.comparison);
  if (!one.empty())
    return answer(out, "Measurement and simulation", "differ",
                  one + ". " + (rows.empty() ? "" : largest_difference(*rows.front())) + one_sided(input) +
                      simulated_of(input));
  if (rows.empty())
    return answer(out, "Measurement and simulation", "not known",
                  input.simulated.empty() ? "Nothing was simulated." : "No uncertainty is known.");
  const auto agree = static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const auto* r) { return r->difference_over_U() <= 1; }));
  answer(out, "Measurement and simulation",
         agree == rows.size()
             ? std::string("agree")
             : fmt::format("differ in {} of {} comparisons", rows.size() - agree, rows.size()),
         largest_difference(*rows.front()) + one_sided(input) + simulated_of(input));
}

void ranking(Markup& out, const std::vector<const ComparisonRow*>& rows) {
  if (rows.empty()) return;
  out.element("h3", "Where simulation and measurement differ");
  const ComparisonRow& largest = *rows.front();
  if (largest.difference_over_U() <= 1) {
    out.element(
        "p",
        fmt::format("Nowhere among the values that both have: the largest difference is {} U, of {} at {}.",
                    times_text(largest.difference_over_U()), largest.quantity,
                    angle_text(largest.closing_angle)),
        {{"class", "fine"}});
    return;
  }
  out.open("table", {{"class", "ranking"}}).open("thead").open("tr");
  for (const std::string_view head : {"quantity", "angle", "measured \xC2\xB1 U", "simulated",
                                      "simulated \xE2\x88\x92 measured", "its U", "difference / U"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  for (std::size_t i = 0; i < std::min(most_ranked, rows.size()); ++i) {
    const ComparisonRow& r = *rows[i];
    const ReadableUnit unit = readable_unit(r.unit);
    const double E = r.difference_over_U();
    if (!(E > 1)) break;
    out.open("tr");
    out.element("th", fmt::format("{} / {}", r.quantity, unit.name), {{"scope", "row"}, {"class", "sym"}});
    out.element("td", angle_text(r.closing_angle));
    out.element("td", with_uncertainty(r.measured, r.coverage, unit.per_si, unit.decimals),
                {{"class", "key"}});
    out.element("td", simulated_text(r), {{"class", "sim"}});
    out.element("td", signed_fixed((r.simulated - r.measured.value) * unit.per_si,
                                   decimals_for(r.expanded_difference() * unit.per_si, unit.decimals)));
    const double U = r.expanded_difference() * unit.per_si;
    out.element("td", fixed(U, decimals_for(U, unit.decimals)));
    out.element("td", times_text(E), {{"class", "warn"}});
    out.close();
  }
  out.close().close();
  const auto differ = static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const auto* r) { return r->difference_over_U() > 1; }));
  std::string note =
      "Its U has k by the degrees of freedom of both together, so it can be less than the measured U. ";
  if (differ > most_ranked)
    note += fmt::format("The {} largest; {} more differ. The tables of the figures show all.", most_ranked,
                        differ - most_ranked);
  out.element("p", note, {{"class", "fine"}});
}

/// The files of the imported records were made within their calibration, by a day that was told later.
bool in_force_then(const TestRecord& test) {
  return std::any_of(test.instruments.begin(), test.instruments.end(), [&](const std::string& text) {
    Instrument i;
    return read_instrument(text, i).empty() && i.name == waveform_calibration && !test.recorded.empty() &&
           test.recorded <= i.valid_until;
  });
}

/// Of how many measured closings the scales are taken on trust; said beside their U.
void calibration_warning(Markup& out, const ReportInput& input) {
  if (input.origin == Origin::import && in_force_then(input.test)) return;
  std::size_t measured = 0, without = 0;
  for (const auto& shot : input.shots) {
    if (!shot.events) continue;
    ++measured;
    if ((shot.events->flags & flag_no_calibration) != 0) ++without;
  }
  if (without > 0)
    out.element(
        "p",
        fmt::format("No valid calibration for {}: the scales of {} channels are taken on trust, and no U "
                    "of this report holds what they may be off by.",
                    measured == 1         ? "this record"
                    : without == measured ? "these records"
                                          : fmt::format("{} of {} records", without, measured),
                    without == 1 ? "its" : "their"),
        {{"class", "warn"}});
}

void times(Markup& out, const ReportInput& input) {
  std::vector<double> angles;
  for (const auto& row : input.comparison.rows)
    if (row.quantity == "t_ct1") angles.push_back(row.closing_angle);
  if (angles.empty()) return;
  out.element("h3", "Measured \xC2\xB1 U, in ms");
  out.open("table", {{"class", "times"}}).open("thead").open("tr");
  for (const std::string_view head : {"closing angle", "closings", "touch t_ct1", "simulated",
                                      "bounce t_ct_bon", "simulated", "core seat t_xt1", "simulated"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  const std::size_t step = (angles.size() + most_angles - 1) / most_angles;
  const double best = best_angle(input.comparison).angles > 1 ? best_angle(input.comparison).angle : unknown;
  bool without_u = false;
  Range k;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    if (i % step != 0 && angles[i] != best) continue;
    out.open("tr", {{"class", angles[i] == best ? "best" : ""}});
    out.element("th", std::isfinite(angles[i]) ? angle_text(angles[i]) : "not known", {{"scope", "row"}});
    bool counted = false;
    for (const std::string_view quantity : {"t_ct1", "t_ct_bon", "t_xt1"}) {
      const ComparisonRow* row = row_at(input.comparison, quantity, angles[i]);
      if (!counted)
        out.element("td", row->repeats < row->closings ? fmt::format("{} of {}", row->repeats, row->closings)
                                                       : fmt::format("{}", row->repeats));
      counted = true;
      out.element("td", with_uncertainty(row->measured, row->coverage, 1e3, 2), {{"class", "key"}});
      out.element("td", simulated_text(*row), {{"class", "sim"}});
      without_u = without_u || row->u_simulated_unknown;
      if (row->measured.known()) k.include(row->coverage);
    }
    out.close();
  }
  out.close().close();
  std::string note = fmt::format(
      "U: 95.45 %, of the scatter of the repeats and of how sharply an event shows in the record, k by their "
      "degrees of freedom{}. It holds neither the scale of a channel nor what another supply voltage or coil "
      "temperature would change",
      k.empty() ? "" : ", here " + range_of(k.low, k.high, 2));
  const auto& all = input.comparison.rows;
  const bool shown =
      std::any_of(all.begin(), all.end(), [](const auto& r) { return std::isfinite(r.u_simulated); });
  note += shown ? "; the simulated \xC2\xB1 shows how much those do. " : ". ";
  if (step > 1)
    note += fmt::format("One in {} of {} angles, and the best; the figures show all. ", step, angles.size());
  if (without_u)
    note +=
        "\xC2\xB1 ?: within the uncertainty of its inputs the simulation comes to another number of events, "
        "so "
        "how far it moves is not known.";
  if (!note.empty()) out.element("p", note, {{"class", "fine"}});
}

}  // namespace

std::string last_of_course(const ReportInput& input) {
  if (input.course.empty()) return {};
  const CourseEntry& last = input.course.back();
  // a program that was killed notes nothing
  return fmt::format("{} ({}){}", last.what, time_text(last.when),
                     last.what.starts_with("stopped") ? "" : "; how that ended is not noted");
}

/// Why a difference from the simulation is beyond its limit; guarded, U counts too.
static std::string simulation_reason(const ComparisonRow& row, const ReportInput& input) {
  const ReadableUnit unit = readable_unit(row.unit);
  const double off = std::fabs(row.simulated - row.measured.value), whole = std::fabs(row.measured.value);
  const bool share = whole > 0;
  const auto text = [&](double x) {
    return share ? fixed(100 * x / whole, 1) + " %"
                 : fmt::format("{} {}", fixed(x * unit.per_si, unit.decimals), unit.name);
  };
  const bool by_guard = off <= input.most_from_simulation * whole;
  return fmt::format(
      "{} at {}: simulation and measurement differ by {}{}, allowed {:g} % of the measured mean",
      row.quantity, angle_text(row.closing_angle), text(off),
      by_guard ? ", with U = " + text(row.expanded_difference()) + " more" : "",
      100 * input.most_from_simulation);
}

std::string verdict_reason(const ReportInput& input) {
  const Outcome is = verdict(input);
  if (is == Outcome::pass || is == Outcome::not_judged) return {};
  std::string first;
  std::size_t more = 0;
  const auto add = [&](const std::string& reason) {
    if (first.empty())
      first = reason;
    else
      ++more;
  };
  for (const auto& shot : input.shots)
    if (shot.outcome == is && !shot.reason.empty()) add(fmt::format("shot {}: {}", shot.index, shot.reason));
  for (const auto& row : input.comparison.rows)
    if (is == Outcome::fail && row.against_simulation == Outcome::fail) add(simulation_reason(row, input));
  if (is == Outcome::aborted && first.empty() && !input.course.empty()) add(last_of_course(input));
  if (first.empty()) return {};
  return first + (more > 0 ? fmt::format(" (and {} more)", more) : "");
}

std::string simulated_text(const ComparisonRow& row) {
  const ReadableUnit unit = readable_unit(row.unit);
  if (std::isfinite(row.u_simulated))
    return with_uncertainty({row.simulated, row.u_simulated}, 2, unit.per_si, unit.decimals);
  const std::string value = fixed(row.simulated * unit.per_si,
                                  decimals_for(row.coverage * row.measured.u * unit.per_si, unit.decimals));
  return row.u_simulated_unknown && std::isfinite(row.simulated) ? value + " \xC2\xB1 ?" : value;
}

Markup answers_section(const ReportInput& input) {
  const auto rows = ranked(input.comparison);
  Markup out;
  out.open("section", {{"id", "answers"}});
  out.open("div", {{"class", "answers"}});
  verdict_answer(out, input);
  best_answer(out, input);
  agreement_answer(out, input, rows);
  out.close();
  calibration_warning(out, input);
  times(out, input);
  ranking(out, rows);
  return out.close();
}

}  // namespace powbench::host
