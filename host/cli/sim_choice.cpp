#include "host/cli/sim_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/units.h"
#include "host/cli/percent.h"
#include "host/cli/scene_text.h"
#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

/// Fields and mechanics that the wish leaves open, cheap ones first.
sim::SceneAxes axes_of(const Wish& wish, const sim::Case& first, const FieldCache& cache) {
  sim::SceneAxes axes;
  axes.fields = wish.fields == "auto" ? sim::automatic_fields(first.specimen)
                                      : std::vector{wish.fields.empty() ? "circuit" : wish.fields};
  const bool open = wish.mechanics == "auto" || (wish.mechanics.empty() && wish.accuracy);
  if (open)
    axes.mechanics = sim::automatic_mechanics(first, false);
  else
    axes.mechanics = {wish.mechanics.empty() ? "rigid" : wish.mechanics};
  const bool named = axes.mechanics.size() == 1 && !wish.mechanics.empty();
  const auto known =
      std::make_shared<std::map<std::size_t, sim::FieldRung>>();  // built once for all mechanics
  axes.rung = [=, fields = axes.fields, mechanics = axes.mechanics](std::size_t f, std::size_t m) {
    auto field = known->find(f);
    if (field == known->end())
      field = known->emplace(f, obtain_field(fields[f], first.specimen, cache)).first;
    return sim::scene_rung(field->second,
                           named ? mechanics[m] : sim::cheapest_equal(mechanics[m], field->second, first));
  };
  return axes;
}

Json milliseconds(double seconds) {
  return seconds > 0 ? Json(seconds * 1e3) : Json();
}

std::string inputs_text(const sim::SceneChoice& c) {
  std::string out = "input error: standard, from";
  for (const auto& i : c.inputs) out += fmt::format(" {} +- {:.3g}", i.name, i.u);
  return out + "; " + numbers_not_known;
}

/// What the plan says about its inputs, and the defaults of `sim` behind a measurement.
std::vector<sim::InputUncertainty> inputs_of(const Scene& scene) {
  const RunOptions o = run_options(scene.plan);
  return {{"supply_volts", o.supply_u * scene.shots.front().conditions.supply_volts},
          {"ambient_degC", o.coil_temperature_u}};
}

std::string verdict_text(const sim::SceneChoice& c) {
  const auto& last = c.steps.back();
  std::string text(sim::reached_names[static_cast<std::size_t>(c.reached())]);
  if (c.reached() == sim::Reached::not_met)
    return text +
           fmt::format(
               ": what is known of the error is {:.2g} times what is wanted, and nothing above is left",
               last.share);
  if (c.reached() == sim::Reached::met)
    return text + ": step, fields and mechanics together are within what is wanted";
  return text + fmt::format(". Not known are: {}", fmt::join(last.unknown, "; "));
}

/// The verdict of every angle, where there are several.
std::string angles_text(const JudgedAngles& judged) {
  if (judged.others_left_out)
    return fmt::format("judged at {:g} degrees alone: a closing of this model takes seconds\n",
                       judged.all.front().first);
  if (judged.all.size() < 2) return "";
  std::string out;
  for (std::size_t r = 0; r < sim::reached_names.size(); ++r) {
    std::string list;
    for (const auto& [angle, c] : judged.all)
      if (static_cast<std::size_t>(c.reached()) == r)
        list += fmt::format("{}{:g}", list.empty() ? "" : " ", angle);
    if (!list.empty()) out += fmt::format("{}{} at {}", out.empty() ? "" : "; ", sim::reached_names[r], list);
  }
  return "by closing angle, degrees: " + out + "\n";
}

}  // namespace

Wish wish_of(const SimArgs& args, const Plan& plan) {
  Wish w{args.fields.empty() ? plan.fields : args.fields,
         args.mechanics.empty() ? plan.mechanics : args.mechanics, plan.wanted, false};
  const auto check = [](const char* option, const std::string& name, const std::string& names) {
    if (!name.empty() && name != "auto" &&
        (", " + names + ", ").find(", " + name + ", ") == std::string::npos)
      throw BadInput({fmt::format("{} {}: allowed {}, auto", option, name, names)});
  };
  check("--fields", args.fields, sim::names_of(sim::all_fields(), ", "));
  check("--mechanics", args.mechanics, sim::names_of(sim::all_mechanics(), ", "));
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (!args.accuracy.empty())
    w.wanted = {share_option("--accuracy", args.accuracy, 1e-8, 0.5, "1e-6% .. 50%"), none, none};
  for (const double x : w.wanted) w.accuracy = w.accuracy || !std::isnan(x);
  if (!w.accuracy) w.wanted = {1e-3, 1e-3, none};  // a model by name: its step still has to be small
  return w;
}

const sim::SceneChoice& JudgedAngles::taken() const {
  return std::ranges::max_element(
             all, {}, [](const auto& a) { return std::pair(a.second.steps.size(), -a.second.setting); })
      ->second;
}

const std::pair<double, sim::SceneChoice>& JudgedAngles::worst() const {
  return *std::ranges::max_element(all, {}, [](const auto& a) {
    constexpr std::array<int, 3> order{0, 2, 1};  // met, not met, not known
    return std::pair(order[static_cast<std::size_t>(a.second.reached())], a.second.steps.back().share);
  });
}

JudgedAngles choose(const Wish& wish, const Scene& scene, const sim::Supply& bench, const FieldCache& cache,
                    const sim::CpuClock& clock) {
  constexpr double duration = 0.06;  // s: what is judged
  std::map<double, Conditions> angles;
  for (const auto& shot : scene.shots)
    angles.emplace(degrees(shot.conditions.closing_angle), shot.conditions);
  JudgedAngles judged;
  try {
    std::optional<sim::SceneAxes> axes;
    for (const auto& [angle, conditions] : angles) {
      const sim::Case c{scene.specimen, conditions, bench};
      if (!axes) axes = axes_of(wish, c, cache);
      judged.all.emplace_back(angle,
                              sim::choose_scene(*axes, c, wish.wanted, duration, inputs_of(scene), clock));
      judged.others_left_out = judged.all.back().second.rung.costly && angles.size() > 1;
      if (judged.others_left_out || (!wish.accuracy && wish.fields != "auto" && wish.mechanics != "auto"))
        break;
    }
  } catch (const std::invalid_argument& e) {
    throw BadInput({std::string("sim: ") + e.what()});
  }
  return judged;
}

void print_choice(const JudgedAngles& judged, const Wish& wish, const sim::Specimen& specimen) {
  const auto& [angle, c] = judged.worst();
  if (judged.all.size() > 1)
    fmt::print(stderr, "at {:g} degrees, where it is furthest from what is wanted\n", angle);
  fmt::print(stderr, "{:<17} {:>15} {:>8}", "looked at", "setting", "CPU ms");
  for (const auto q : sim::ladder_quantities)
    fmt::print(stderr, " {:>11} {:>9} {:>9} {:>9}", fmt::format("{} ms", q), "step us", "fields us",
               "mech. us");
  fmt::print(stderr, " {:>9}\n", wish.accuracy ? "of wanted" : "");
  for (const auto& s : c.steps) {
    fmt::print(stderr, "{:<17} {:>15} {:>8}", s.name, fmt::format("{} {:g}", s.setting_name, s.run.tolerance),
               s.run.cpu > 0 ? fmt::format("{:.2f}", s.run.cpu * 1e3) : "-");
    for (std::size_t q = 0; q < s.step_error.size(); ++q)
      fmt::print(stderr, " {:>11} {:>9} {:>9} {:>9}",
                 std::isnan(s.run.times[q]) ? "-" : fmt::format("{:.4f}", s.run.times[q] * 1e3),
                 us_text(s.step_error[q]), axis_text(s.fields, q), axis_text(s.mechanics, q));
    fmt::print(stderr, "{}\n", wish.accuracy ? fmt::format(" {:>7.2g} x", s.share) : "");
  }
  fmt::print(stderr,
             "step: by a finer run; fields and mech. (the model error): to the rungs above; in brackets, at "
             "the top, from the one below; ? not known\n");
  const sim::SceneChoice& taken = judged.taken();
  const auto& last = c.steps.back();
  fmt::print(stderr, "taken: {} at {} {:g} ({})", taken.rung.name(), taken.rung.setting, taken.setting,
             taken.rung.meaning);
  double spent = 0;
  for (const auto& a : judged.all) spent += a.second.spent;
  if (spent > 0)
    fmt::print(stderr, "; {:.1f} ms CPU a closing, {:.1f} ms with choosing", taken.steps.back().run.cpu * 1e3,
               spent * 1e3);
  fmt::print(stderr, "\n");
  if (wish.accuracy) fmt::print(stderr, "wanted accuracy: {}\n{}", verdict_text(c), angles_text(judged));
  const bool has_fields = specimen.shaped || specimen.drawn || specimen.in_space;
  if (wish.accuracy && wish.fields.empty() && has_fields)
    fmt::print(stderr, "--fields auto compares the circuit with fields of the specimen's [shape]\n");
  if (wish.fields == "auto" && !has_fields)
    fmt::print(stderr,
               "specimen '{}' has no [shape] with a key in it: only its circuit describes its magnet\n",
               specimen.name);
  fmt::print(stderr, "{:<9} {:>15} {:>15} {:>15}\n", "", "step error us", "model error us", "input error us");
  for (std::size_t q = 0; q < last.step_error.size(); ++q) {
    const bool at_top = std::isnan(last.fields.above[q]) || std::isnan(last.mechanics.above[q]);
    const bool from_below = at_top && !std::isnan(last.model_error[q]);
    fmt::print(stderr, "{:<9} {:>15} {:>15} {:>15}\n", sim::ladder_quantities[q],
               known_or(last.step_error[q]),
               from_below ? "(" + known_or(last.model_error[q]) + ")" : known_or(last.model_error[q]),
               known_or(c.input_error[q]));
  }
  fmt::print(stderr, "{}\n", inputs_text(c));
}

std::string choice_json(const JudgedAngles& judged, bool wanted) {
  const auto& [angle, c] = judged.worst();
  Json by_angle = Json::array();
  for (const auto& [at, of] : judged.all)
    by_angle.push_back({{"angle_deg", at},
                        {"verdict", sim::reached_names[static_cast<std::size_t>(of.reached())]},
                        {"share", of.steps.back().share}});
  Json steps = Json::array();
  for (const auto& s : c.steps) steps.push_back(Json::parse(step_json(s)));
  Json inputs = Json::object();
  for (const auto& i : c.inputs) inputs[i.name] = i.u;
  return Json{{"rung", judged.taken().rung.name()},
              {"setting", judged.taken().setting},
              {"angle_deg", angle},
              {"by_angle", wanted ? by_angle : Json()},
              {"angles_left_out", judged.others_left_out},
              {"verdict", wanted ? Json(sim::reached_names[static_cast<std::size_t>(c.reached())]) : Json()},
              {"step_error_s", c.steps.back().step_error},
              {"model_error_s", c.steps.back().model_error},
              {"input_error_s", c.input_error},
              {"inputs", inputs},
              {"input_not_known", numbers_not_known},
              {"cpu_ms_with_choosing", milliseconds(c.spent)},
              {"looked_at", steps}}
      .dump();
}

}  // namespace powbench::host
