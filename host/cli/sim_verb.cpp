#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/counted.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "host/cli/sim_choice.h"
#include "host/cli/solenoid_verb.h"
#include "host/cli/threads.h"
#include "host/cli/verbs.h"
#include "host/config/solenoid_file.h"
#include "host/gather/scene.h"
#include "host/run/simulate.h"
#include "host/run/stop.h"
#include "host/study/bounce_text.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/models/mechanics.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

/// Where points are kept no time is: it is not a function of the point.
double no_clock() {
  return 0;
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

/// How much of the closings lay outside of what their fields were made from.
double share_beyond(const SimulatedCount& n) {
  return n.field_states > 0 ? static_cast<double>(n.field_beyond) / static_cast<double>(n.field_states) : 0;
}

std::string beyond_text(const SimulatedCount& n) {
  return fmt::format(
      "fields: in {} of {} more than {:.0f} % of the magnet's states lie outside of what the fields were "
      "made "
      "from (largest gap or flux). There they are continued by the saturation law, which is wrong where the "
      "steel is not saturated at the end of the table. --fields solved has no such end; a drawing's table "
      "grows with largest_flux_Wb; exit code 1\n",
      n.beyond_fields, counted(n.stored + n.kept, "closing"), 100 * few_beyond);
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

/// Touch, bounce and seat of the simulated closings of a campaign, ms.
std::string times_text(const Store& store, std::int64_t campaign) {
  constexpr std::array symbols{"t_ct1", "t_ct_bon", "t_xt1"};
  std::string out =
      fmt::format("{:>7} {:>10} {:>10} {:>10}   ms, under the conditions of the measured closings, if any\n",
                  "deg", symbols[0], symbols[1], symbols[2]);
  for (const StoredShot& s : store.shots(campaign, ShotKind::simulated)) {
    const auto events = store.load_events(s.id);
    if (!events) continue;
    out += fmt::format("{:>7g}", s.angle_deg);
    for (const char* symbol : symbols) {
      const double value = find_quantity(symbol)->of(*events).value;
      out += fmt::format(" {:>10}", std::isfinite(value) ? fmt::format("{:.4f}", value * 1e3) : "-");
    }
    out += '\n';
  }
  return out;
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
  JudgedAngles judged;
  const sim::SceneChoice* choice = nullptr;
  RecordMaker maker = rigs::simulate_record;
  std::string model = "simulation only";
  if (wish.any()) {
    FieldCache cache;
    cache.folder = args.cache;
    cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
    judged = choose(wish, scene, sensors.supply, cache, points.stored() ? no_clock : thread_cpu_seconds);
    print_choice(judged, wish, scene.specimen);
    choice = &judged.taken();
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
    if (choice) j["models"] = Json::parse(choice_json(judged, wish.accuracy));
    j["states_beyond_fields"] = n.field_states > 0 ? Json(share_beyond(n)) : Json();
    j["bounces"] = Json::parse(bounce_json(bounces));
    fmt::print("{}\n", j.dump(2));
  }
  fmt::print(
      stderr, "{}",
      bounces.empty()
          ? times_text(store, campaign) +
                fmt::format("how far the bounces of {} can be believed is not judged: it takes steps or "
                            "cells, no tolerance; circuit+rigid is\n",
                            rung.name())
          : fmt::format("nominal conditions of the plan, model alone at tolerance {:g}; break A:\n",
                        believed.tolerance) +
                bounce_text(bounces, believed));
  if (n.beyond_fields > 0) fmt::print(stderr, "{}", beyond_text(n));
  fmt::print(stderr, "campaign {}: {}\n", campaign, said(n));
  if (StopOnSignal::asked()) return Exit::interrupted;
  if (n.beyond_fields > 0) return Exit::outside_limits;
  if (!choice || !wish.accuracy || judged.reached() == sim::Reached::met) return Exit::pass;
  return judged.reached() == sim::Reached::not_met ? Exit::outside_limits : Exit::not_known;
}

}  // namespace powbench::host
