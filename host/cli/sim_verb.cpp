#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/counted.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "host/cli/percent.h"
#include "host/cli/scene_text.h"
#include "host/cli/solenoid_verb.h"
#include "host/cli/threads.h"
#include "host/cli/verbs.h"
#include "host/config/solenoid_file.h"
#include "host/gather/scene.h"
#include "host/run/simulate.h"
#include "host/run/stop.h"
#include "host/study/bounce_text.h"
#include "host/study/scene_fields.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/models/mechanics.h"
#include "sim/study/scene_choice.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

/// What is asked of the simulation; nothing: the plant of the simulated rig.
struct Wish {
  std::string fields, mechanics;
  sim::WantedTimes wanted{};
  bool accuracy = false;
  bool any() const { return accuracy || !fields.empty() || !mechanics.empty(); }
};

Wish wish_of(const SimArgs& args, const Plan& plan) {
  Wish w{args.fields.empty() ? plan.fields : args.fields,
         args.mechanics.empty() ? plan.mechanics : args.mechanics, plan.wanted, false};
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (!args.accuracy.empty())
    w.wanted = {share_option("--accuracy", args.accuracy, 1e-8, 0.5, "1e-6% .. 50%"), none, none};
  for (const double x : w.wanted) w.accuracy = w.accuracy || !std::isnan(x);
  if (!w.accuracy) w.wanted = {1e-3, 1e-3, none};  // a model by name: its step still has to be small
  return w;
}

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

/// Where points are kept no time is: it is not a function of the point.
double no_clock() {
  return 0;
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

void print_choice(const sim::SceneChoice& c, const Wish& wish, const sim::Specimen& specimen) {
  fmt::print(stderr, "{:<17} {:>15} {:>8}", "looked at", "setting", "CPU ms");
  for (const auto q : sim::ladder_quantities)
    fmt::print(stderr, " {:>11} {:>9} {:>9} {:>9}", fmt::format("{} ms", q), "step us", "fields us",
               "mech. us");
  fmt::print(stderr, " {:>9}\n", "of wanted");
  for (const auto& s : c.steps) {
    fmt::print(stderr, "{:<17} {:>15} {:>8}", s.name, fmt::format("{} {:g}", s.setting_name, s.run.tolerance),
               s.run.cpu > 0 ? fmt::format("{:.2f}", s.run.cpu * 1e3) : "-");
    for (std::size_t q = 0; q < s.step_error.size(); ++q)
      fmt::print(stderr, " {:>11} {:>9} {:>9} {:>9}",
                 std::isnan(s.run.times[q]) ? "-" : fmt::format("{:.4f}", s.run.times[q] * 1e3),
                 us_text(s.step_error[q]), axis_text(s.fields, q), axis_text(s.mechanics, q));
    fmt::print(stderr, " {:>7.2g} x\n", s.share);
  }
  fmt::print(stderr,
             "step: by a finer run; fields and mech. (the model error): to the rungs above; in brackets, at "
             "the top, from the one below; ? not known\n");
  const auto& last = c.steps.back();
  fmt::print(stderr, "taken: {} at {} {:g} ({})", last.name, last.setting_name, last.run.tolerance,
             c.rung.meaning);
  if (c.spent > 0)
    fmt::print(stderr, "; {:.1f} ms CPU a closing, {:.1f} ms with choosing", last.run.cpu * 1e3,
               c.spent * 1e3);
  fmt::print(stderr, "\n");
  if (wish.accuracy) fmt::print(stderr, "wanted accuracy: {}\n", verdict_text(c));
  if (wish.accuracy && wish.fields.empty())
    fmt::print(stderr, "--fields auto compares the circuit with fields of the specimen's [shape]\n");
  if (wish.fields == "auto" && !specimen.shaped && !specimen.drawn && !specimen.in_space)
    fmt::print(stderr, "specimen '{}' has no [shape]: only its circuit describes its magnet\n",
               specimen.name);
  fmt::print(stderr, "{:<9} {:>15} {:>15} {:>15}\n", "", "step error us", "model error us", "input error us");
  for (std::size_t q = 0; q < last.step_error.size(); ++q)
    fmt::print(stderr, "{:<9} {:>15} {:>15} {:>15}\n", sim::ladder_quantities[q],
               known_or(last.step_error[q]), known_or(last.model_error[q]), known_or(c.input_error[q]));
  fmt::print(stderr, "{}\n", inputs_text(c));
}

Json choice_json(const sim::SceneChoice& c, bool wanted) {
  Json steps = Json::array();
  for (const auto& s : c.steps) steps.push_back(Json::parse(step_json(s)));
  Json inputs = Json::object();
  for (const auto& i : c.inputs) inputs[i.name] = i.u;
  return {{"rung", c.rung.name()},
          {"setting", c.setting},
          {"verdict", wanted ? Json(sim::reached_names[static_cast<std::size_t>(c.reached())]) : Json()},
          {"step_error_s", c.steps.back().step_error},
          {"model_error_s", c.steps.back().model_error},
          {"input_error_s", c.input_error},
          {"inputs", inputs},
          {"input_not_known", numbers_not_known},
          {"cpu_ms_with_choosing", milliseconds(c.spent)},
          {"looked_at", steps}};
}

CampaignInfo only_simulated(CampaignInfo info) {
  info.origin = Origin::simulation;
  return info;
}

/// Beside the newest measurement of this plan, else in the campaign of simulations alone by the same model.
std::optional<std::int64_t> find_campaign(const Store& store, const Scene& scene, const std::string& model) {
  std::optional<std::int64_t> measured, alone;
  for (const CampaignInfo& c : store.campaigns()) {
    if (c.plan_hash != scene.plan_hash || c.specimen_hash != scene.specimen_hash) continue;
    if (!c.rig_uri.empty())
      measured = c.id;
    else if (c.rig_identity == model)
      alone = c.id;
  }
  return measured ? measured : alone;
}

std::int64_t campaign_for(Store& store, const Scene& scene, const std::string& model) {
  const auto there = find_campaign(store, scene, model);
  return there ? *there : store.create_campaign(only_simulated(campaign_info(scene, "", model)));
}

/// Share of the states outside of what the fields were made from, above which no time is one to rely on.
constexpr double few_beyond = 0.01;

/// How much of the closings lay outside of what their fields were made from.
double share_beyond(const SimulatedCount& n) {
  return n.field_states > 0 ? static_cast<double>(n.field_beyond) / static_cast<double>(n.field_states) : 0;
}

std::string beyond_text(const SimulatedCount& n) {
  return fmt::format(
      "fields: {:.2g} % of the states of the magnet, in {} of {}, lie outside of what the fields were made "
      "from "
      "(largest gap or flux); there they are continued by the saturation law, which is wrong where the steel "
      "is not "
      "saturated at the end of the table: make it larger (largest_flux_Wb of a drawing){}\n",
      100 * share_beyond(n), n.beyond_fields, counted(n.stored, "run"),
      share_beyond(n) > few_beyond ? "; exit code 1" : "");
}

RecordMaker maker_of(const sim::SceneChoice& choice, const std::string& name) {
  return [choice, name](const sim::Specimen& s, const Conditions& c, const rigs::SimRigConfig& rig) {
    const auto run = [&](const sim::Specimen& specimen, const Conditions& conditions, double duration,
                         double dt) {
      return choice.rung.run({specimen, conditions, rig.supply}, duration, choice.setting, dt);
    };
    return rigs::simulate_record_with(run, name, s, c, rig);
  };
}

sim::SceneChoice choose(const Wish& wish, const Scene& scene, const sim::Supply& bench,
                        const FieldCache& cache, const sim::CpuClock& clock) {
  constexpr double duration = 0.06;  // s: what is judged
  const sim::Case first{scene.specimen, scene.shots.front().conditions, bench};
  try {
    return sim::choose_scene(axes_of(wish, first, cache), first, wish.wanted, duration, inputs_of(scene),
                             clock);
  } catch (const std::invalid_argument& e) {
    throw BadInput({std::string("sim: ") + e.what()});
  }
}

std::string said(const SimulatedCount& n) {
  std::string text = counted(n.stored, "closing") + " simulated";
  if (n.renewed > 0) text += fmt::format(", {} of them anew: their inputs have changed", n.renewed);
  if (n.kept > 0) text += fmt::format("; {} kept: nothing that they come from has changed", n.kept);
  return text;
}

/// Touches and bounces of the first shot at each angle, and how far they can be believed.
std::vector<BounceRow> bounces_of_scene(const sim::Rung& rung, const Scene& scene, const sim::Supply& bench,
                                        const sim::BounceStudyOptions& options) {
  std::vector<BounceRow> rows;
  std::set<double> seen;
  for (const auto& shot : scene.shots) {
    if (!rung.settings.empty() || rung.costly || StopOnSignal::asked()) break;
    if (!seen.insert(shot.conditions.closing_angle).second) continue;
    const auto name = fmt::format("{:g} degrees", shot.conditions.closing_angle * 180 / pi);
    rows.push_back(bounce_row(rung, name, {scene.specimen, shot.conditions, bench}, options));
  }
  std::sort(rows.begin(), rows.end(), [](const BounceRow& a, const BounceRow& b) {
    return std::strtod(a.name.c_str(), nullptr) < std::strtod(b.name.c_str(), nullptr);
  });
  return rows;
}

/// What a part reads measured closings from; where there is no such store nothing was measured.
Store store_to_read(const SimArgs& args) {
  const bool there = std::filesystem::exists(args.database);
  return Store(there ? args.database : args.shards.database, Store::Mode::read_only);
}

}  // namespace

Exit simulate_plan(const SimArgs& args) {
  if (is_solenoid_file(args.plan)) return simulate_solenoid(args);
  refuse_solenoid_options(args);
  if (args.shards.slurm > 0) {
    load_scene(args.plan);  // mistakes are told before anything is submitted
    fmt::print("{}", slurm_script(args.shards, args.shards.database));
    return Exit::pass;
  }
  const Scene scene = load_scene(args.plan);
  Wish wish = wish_of(args, scene.plan);
  if (!wish.any() && !sim::rigid_only(scene.specimen).empty()) {
    fmt::print(stderr, "specimen '{}' takes mechanics = rigid\n", scene.specimen.name);
    wish.mechanics = "rigid";
  }
  if (!scene.specimen.lumped && wish.fields.empty()) {
    fmt::print(stderr, "specimen '{}' has a drawing and no circuit: fields = table\n", scene.specimen.name);
    wish.fields = "table";
  }
  RigFile bench = args.rig_file.empty() ? RigFile{} : read_rig(args.rig_file);
  bench.config.sensors.channels = wanted_channels(scene.plan);
  const rigs::SimRigConfig& sensors = bench.config;
  const StopOnSignal stop;
  Points points = open_points(args.shards);
  std::optional<sim::SceneChoice> choice;
  RecordMaker maker = rigs::simulate_record;
  std::string model = "simulation only";
  if (wish.any()) {
    FieldCache cache;
    cache.folder = args.cache;
    cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
    choice = choose(wish, scene, sensors.supply, cache, points.stored() ? no_clock : thread_cpu_seconds);
    print_choice(*choice, wish, scene.specimen);
    model =
        fmt::format("simulation by {}, {} {:g}", choice->rung.name(), choice->rung.setting, choice->setting);
    maker = maker_of(*choice, model);
  }
  const sim::Rung rung = choice ? choice->rung : sim::closing_rungs().front();
  const sim::BounceStudyOptions believed;
  const auto bounces =
      points.part() ? std::vector<BounceRow>{} : bounces_of_scene(rung, scene, sensors.supply, believed);
  Store store = points.part() ? store_to_read(args) : Store(args.database);
  const std::int64_t campaign =
      points.part() ? find_campaign(store, scene, model).value_or(0) : campaign_for(store, scene, model);
  const int threads = worker_count(args.threads);
  Progress progress("simulate", scene.plan.angles.size(), progress_style(args.progress));
  const SimulatedCount n = simulate_campaign(
      store, campaign, scene.shots, scene.specimen, sensors, run_options(scene.plan), progress,
      {model + "\n" + scene.specimen_text + resolved_text(bench), maker, args.nominal, threads, &points});
  progress.finish();
  say_points(points, args.shards);
  if (points.part()) return StopOnSignal::asked() ? Exit::interrupted : Exit::pass;
  if (args.json) {
    Json j{{"campaign", campaign},
           {"simulated", n.stored},
           {"renewed", n.renewed},
           {"kept", n.kept},
           {"nominal", args.nominal}};
    if (choice) j["models"] = choice_json(*choice, wish.accuracy);
    j["states_beyond_fields"] = n.field_states > 0 ? Json(share_beyond(n)) : Json();
    j["bounces"] = Json::parse(bounce_json(bounces));
    fmt::print("{}\n", j.dump(2));
  }
  fmt::print(
      stderr, "{}",
      bounces.empty()
          ? fmt::format("how far the bounces of {} can be believed is not judged: it takes steps or "
                        "cells, no tolerance; circuit+rigid is\n",
                        rung.name())
          : "nominal conditions of the plan, model alone; break A:\n" + bounce_text(bounces, believed));
  if (n.field_beyond > 0) fmt::print(stderr, "{}", beyond_text(n));
  fmt::print(stderr, "campaign {}: {}\n", campaign, said(n));
  if (StopOnSignal::asked()) return Exit::interrupted;
  if (share_beyond(n) > few_beyond) return Exit::outside_limits;
  if (!choice || !wish.accuracy || choice->reached() == sim::Reached::met) return Exit::pass;
  return choice->reached() == sim::Reached::not_met ? Exit::outside_limits : Exit::not_known;
}

}  // namespace powbench::host
