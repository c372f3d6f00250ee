#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/cpu_time.h"
#include "core/units.h"
#include "host/cli/percent.h"
#include "host/cli/scene_text.h"
#include "host/cli/study.h"
#include "host/config/bad_input.h"
#include "host/run/campaign.h"
#include "host/run/progress.h"
#include "host/study/fit_text.h"
#include "host/study/scene_fields.h"
#include "sim/models/mechanics.h"

/// `powbench ladder --judge`: every pair of fields and mechanics at every angle, held against one accuracy.

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr double judged_span = 0.06;  ///< s simulated, as `sim` judges

/// Fields and mechanics of the table, cheap ones first.
sim::SceneAxes axes_of(const LadderArgs& args, const sim::Specimen& specimen) {
  sim::SceneAxes axes;
  const auto all = sim::automatic_fields(specimen);
  axes.fields = args.fields.empty() ? all : args.fields;
  if (!all.empty() && sim::place_of_fields(axes.fields.back()) < sim::place_of_fields(all.back()))
    axes.fields_left_out = all.back();
  axes.mechanics = args.mechanics.empty() ? sim::automatic_mechanics({specimen, {}, {}}, args.all)
                                          : std::vector{args.mechanics};
  FieldCache cache;
  cache.folder = args.cache;
  cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  std::vector<sim::FieldRung> fields;
  for (const auto& name : axes.fields) fields.push_back(obtain_field(name, specimen, cache));
  for (const auto& name : axes.mechanics)
    sim::scene_rung(fields.front(), name);  // an unknown name is refused
  axes.rung = [fields, mechanics = axes.mechanics](std::size_t f, std::size_t m) {
    return sim::scene_rung(fields[f], mechanics[m]);
  };
  return axes;
}

/// Of both axes together, us; in brackets where one is known from the rung below alone, "?" for what nothing tells.
std::string model_text(const sim::SceneStep& s, std::size_t q) {
  if (std::isnan(s.model_error[q])) {
    const std::string fields = axis_text(s.fields, q), mechanics = axis_text(s.mechanics, q);
    return fields == mechanics ? "?" : fields == "?" ? mechanics + "+?" : fields + "+?";
  }
  const bool below = std::isnan(s.fields.above[q]) || std::isnan(s.mechanics.above[q]);
  return below ? "(" + us_text(s.model_error[q]) + ")" : us_text(s.model_error[q]);
}

/// What was measured at one angle, and what the fit that held it out missed it by.
struct HeldOut {
  double degrees = 0;
  sim::LadderTimes measured{sim::nan_times}, missed{sim::nan_times};
};

/// Of a fit file and the closings it is about, where they were made at this voltage, frequency and coil temperature.
std::vector<HeldOut> held_out_of(const LadderArgs& args, const Conditions& wanted) {
  std::vector<HeldOut> all;
  if (args.fit_file.empty()) return all;
  FitArgs source;
  source.database = args.database;
  if (args.campaign) source.campaigns = {*args.campaign};
  std::vector<sim::MeasuredClosing> closings = fit_closings(source);
  constexpr double share = 1e-3, kelvin = 1;
  std::erase_if(closings, [&](const auto& closing) {
    const Conditions& c = closing.conditions;
    return std::abs(c.supply_volts - wanted.supply_volts) > share * wanted.supply_volts ||
           std::abs(c.mains_hertz - wanted.mains_hertz) > share * wanted.mains_hertz ||
           std::abs(c.ambient - wanted.ambient) > kelvin;
  });
  for (const FitCell& cell : fit_cells(load_fit_file(args.fit_file), closings)) {
    constexpr std::array<std::string_view, 3> names{"t_ct1", "t_xt1", "t_ct2"};
    const auto q =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), cell.quantity) - names.begin());
    if (q == names.size()) continue;
    const auto same = [&](const HeldOut& h) { return h.degrees == cell.theta_deg; };
    auto at = std::find_if(all.begin(), all.end(), same);
    if (at == all.end()) at = all.insert(at, HeldOut{cell.theta_deg});
    at->measured[q] = cell.measured;
    at->missed[q] = std::abs(cell.held_out.median - cell.measured);
  }
  return all;
}

std::string verdict_text(sim::Reached r) {
  return std::string(sim::reached_names[static_cast<std::size_t>(r)]);
}

struct JudgedAngle {
  double degrees = 0;
  sim::LadderTimes measured{sim::nan_times};
  std::vector<sim::SceneStep> pairs;
  sim::LadderTimes input{};
};

void print_head() {
  fmt::print("{:>5} {:<18} {:>14} {:>9}", "angle", "rung", "setting", "CPU ms");
  for (const auto q : sim::ladder_quantities)
    fmt::print(" | {:>11} {:>8} {:>9} {:>6} {:<9}", fmt::format("{} ms", q), "step us", "model us", "input",
               "verdict");
  fmt::print("\n");
}

void print_angle(const JudgedAngle& a) {
  const bool any = std::any_of(a.measured.begin(), a.measured.end(), [](double t) { return !std::isnan(t); });
  if (any) {
    fmt::print("{:>5g} {:<18} {:>14} {:>9}", a.degrees, "measured", "", "");
    for (const double t : a.measured)
      fmt::print(" | {:>11} {:>8} {:>9} {:>6} {:<9}", std::isnan(t) ? "-" : fmt::format("{:.4f}", t * 1e3),
                 "", "", "", "");
    fmt::print("\n");
  }
  for (const sim::SceneStep& s : a.pairs) {
    fmt::print("{:>5g} {:<18} {:>14} {:>9.2f}", a.degrees, s.name,
               fmt::format("{} {:g}", s.setting_name, s.run.tolerance), s.run.cpu * 1e3);
    for (std::size_t q = 0; q < s.run.times.size(); ++q)
      fmt::print(" | {:>11} {:>8} {:>9} {:>6} {:<9}",
                 std::isnan(s.run.times[q]) ? "-" : fmt::format("{:.4f}", s.run.times[q] * 1e3),
                 us_text(s.step_error[q]), model_text(s, q),
                 std::isnan(a.input[q]) ? "?" : fmt::format("{:.0f}", a.input[q] * 1e6),
                 verdict_text(s.by_time[q]));
    fmt::print("\n");
    if (!s.stopped.empty()) fmt::print("{:>5} not computable: {}\n", "", s.stopped);
  }
}

Json angle_json(const JudgedAngle& a) {
  Json pairs = Json::array();
  for (const sim::SceneStep& s : a.pairs) {
    Json j = Json::parse(step_json(s)), verdicts = Json::array();
    for (const sim::Reached r : s.by_time) verdicts.push_back(verdict_text(r));
    j["verdicts"] = verdicts;
    pairs.push_back(j);
  }
  return {{"angle_deg", a.degrees}, {"measured_s", a.measured}, {"input_error_s", a.input}, {"pairs", pairs}};
}

/// The first run of a pair also makes what all its runs share, such as the modes of its parts. What a closing costs is
/// the cheaper of two more runs; pairs that take seconds keep their only run.
void measure_cost(const sim::SceneAxes& axes, const sim::Case& c, std::vector<sim::SceneStep>& pairs) {
  constexpr double dear = 1;  // s
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    sim::LadderRun& run = pairs[k].run;
    if (run.cpu > dear || !pairs[k].stopped.empty()) continue;
    const sim::Rung rung = axes.rung(k / axes.mechanics.size(), k % axes.mechanics.size());
    run.cpu = sim::run_rung(std::span(&rung, 1), 0, c, judged_span, run.tolerance, thread_cpu_seconds, 2).cpu;
  }
}

/// How many of the verdicts are which, a line for each pair.
void print_sums(const std::vector<JudgedAngle>& angles) {
  fmt::print("\nof {} angles and {} times each:\n", angles.size(), sim::ladder_quantities.size());
  for (std::size_t k = 0; k < angles.front().pairs.size(); ++k) {
    std::array<int, 3> count{};
    for (const JudgedAngle& a : angles)
      for (const sim::Reached r : a.pairs[k].by_time) ++count[static_cast<std::size_t>(r)];
    fmt::print("{:<18} met {:>2}, not met {:>2}, not known {:>2}\n", angles.front().pairs[k].name, count[0],
               count[1], count[2]);
  }
}

}  // namespace

Exit judge_ladder(const LadderArgs& args, const sim::Case& scene) {
  const double wanted = share_option("--judge", args.judge, 1e-9, 0.5, "1e-7% .. 50%");
  std::vector<double> degrees = args.angles_deg;
  if (degrees.empty()) degrees.push_back(scene.conditions.closing_angle * 180 / pi);
  const std::vector<HeldOut> known = held_out_of(args, scene.conditions);
  sim::SceneAxes axes = axes_of(args, scene.specimen);
  const RunOptions usual;
  const std::vector<sim::InputUncertainty> inputs{
      {"supply_volts", usual.supply_u * scene.conditions.supply_volts},
      {"ambient_degC", usual.coil_temperature_u}};
  std::vector<JudgedAngle> judged;
  const std::size_t pairs = axes.fields.size() * axes.mechanics.size();
  Progress progress("pairs", degrees.size() * pairs);
  for (const double angle : degrees) {
    sim::Case c = scene;
    c.conditions.closing_angle = radians(angle);
    JudgedAngle a;
    a.degrees = angle;
    axes.measured = axes.held_out_error = sim::nan_times;
    for (const HeldOut& h : known)
      if (std::abs(std::remainder(h.degrees - angle, 360)) < 1e-3)
        axes.measured = h.measured, axes.held_out_error = h.missed;
    a.measured = axes.measured;
    a.pairs = sim::look_at_all(axes, c, {wanted, wanted, wanted}, judged_span, thread_cpu_seconds,
                               [&](std::size_t done) { progress.update(judged.size() * pairs + done); });
    measure_cost(axes, c, a.pairs);
    const sim::Rung cheapest = axes.rung(0, 0);
    a.input = sim::input_error(cheapest, sim::settings_of(cheapest, 1e-6, 1e-6).front(), c, judged_span,
                               inputs, thread_cpu_seconds);
    judged.push_back(std::move(a));
  }
  progress.finish();
  if (args.json) {
    Json rows = Json::array();
    for (const auto& a : judged) rows.push_back(angle_json(a));
    fmt::print("{}\n", Json{{"specimen", scene.specimen.name},
                            {"wanted", wanted},
                            {"inputs", {{inputs[0].name, inputs[0].u}, {inputs[1].name, inputs[1].u}}},
                            {"input_not_known", numbers_not_known},
                            {"angles", rows}}
                           .dump(2));
    return Exit::pass;
  }
  const std::string evidence =
      known.empty() ? ""
                    : fmt::format(
                          "\nmeasured: {}; of the fields: the distance to it, or that of the fit which "
                          "held it out where larger;",
                          args.database.empty() ? "the published tables" : args.database);
  fmt::print(
      "{}, {:g} V: every pair held against {:g} % of its touch time\n"
      "step: by a finer run; model: to the fields and the mechanics above; in brackets where nothing is "
      "above: to the rung below, which is no proof of the fields' error; ? not known;{}\n"
      "input: us, standard, 0.5 % of the voltage and 2 K of the coil; {}\n",
      scene.specimen.name, scene.conditions.supply_volts, wanted * 100, evidence, numbers_not_known);
  print_head();
  for (const auto& a : judged) print_angle(a);
  print_sums(judged);
  return Exit::pass;
}

}  // namespace powbench::host
