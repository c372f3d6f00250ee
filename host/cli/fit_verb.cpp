#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "host/cli/picture.h"
#include "host/cli/study.h"
#include "host/cli/threads.h"
#include "host/compare/compare.h"
#include "host/export/write_file.h"
#include "host/gather/gather.h"
#include "host/gather/scene.h"
#include "host/run/stop.h"
#include "host/study/fit_text.h"
#include "host/study/next_measurement.h"
#include "host/study/problem.h"
#include "host/study/scene_fields.h"
#include "host/study/study_svg.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/models/mechanics.h"

namespace powbench::host {
namespace {

/// One part of NAME=LOW:HIGH, a number as TOML writes it.
double bound(const std::string& text, const std::string& whole) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0')
    throw BadInput({"--free " + whole + ": '" + text +
                    "' is not a number; allowed NAME=LOW:HIGH, such as "
                    "core.friction_N=0.5:3"});
  return value;
}

/// The free numbers of a device that is known but for its tolerances: around `base`.
std::vector<sim::Parameter> tolerances(const sim::Specimen& base) {
  struct Around {
    const char* name;
    double share;
  };
  constexpr Around list[] = {{"coil.resistance_ohm", 0.15},
                             {"core.return_preload_N", 0.2},
                             {"core.return_rate_N_per_m", 0.2},
                             {"core.friction_N", 0.5},
                             {"core.mass_g", 0.05},
                             {"bridges.gap_mm", 0.08},
                             {"bridges.preload_N", 0.2},
                             {"bridges.contact_restitution", 0.2},
                             {"base.mode_Hz", 0.1},
                             {"base.damping", 0.5}};
  std::vector<sim::Parameter> out;
  for (const auto& a : list) {
    const auto& f = sim::specimen_field(a.name);
    const double value = f.get(base) / f.si_per_unit;
    out.push_back(sim::parameter(a.name, std::max(f.low, value * (1 - a.share)),
                                 std::min(f.high, value * (1 + a.share))));
  }
  return out;
}

std::string text_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw BadInput({path + ": cannot be read"});
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// In one piece: a state must never be half a state.
void replace_file(const std::string& path, const std::string& text) {
  const std::string next = path + ".new";
  write_file(next, text);
  std::error_code failed;
  std::filesystem::rename(next, path, failed);
  if (failed) throw BadInput({path + ": cannot be written; check the folder and the disk"});
}

struct Source {
  FitJob job;
  std::vector<sim::MeasuredClosing> closings;  ///< also those that are held out
  std::string from;                            ///< said of a campaign: a line each
};

/// Those of the command line, in percent, or `usual`.
ModelDeviation deviations(const FitArgs& args, ModelDeviation usual) {
  if (args.deviations.empty()) return usual;
  usual.touch = args.deviations[0] / 100;
  usual.seat = args.deviations[1] / 100;
  usual.bounce = args.deviations[2] / 100;
  if (args.deviations.size() > 3) usual.overtravel_time = args.deviations[3] / 100;
  return usual;
}

Source published_source(const FitArgs& args) {
  Source s;
  s.job.granted = deviations(args, {});
  s.closings = published_closings(s.job.granted);
  s.job.problem.parameters = sim::catalogue_parameters();
  s.job.posterior_parameters = sim::posterior_parameters();
  s.job.problem.plausible = sim::catalogue_ranges();
  s.job.problem.base = args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  return s;
}

/// Conditions of a campaign's closings: its plan's, or what an import measured.
Conditions conditions_of(const FitArgs& args, const CampaignInfo& info,
                         const std::vector<AngleGroup>& groups) {
  const Plan plan = stored_plan(info);
  Conditions conditions;
  conditions.supply_volts = plan.supply_volts;
  conditions.mains_hertz = plan.mains_hertz;
  conditions.ambient = plan.ambient;
  conditions.hold_time = plan.hold_time;
  if (info.origin == Origin::import) {
    // nobody asked for a voltage: what was measured counts, or nothing
    double sum = 0;
    int n = 0;
    for (const AngleGroup& g : groups)
      for (const Events& e : g.measured) sum += e.coil.supply_volts.value, ++n;
    conditions.supply_volts = n > 0 ? sum / n : std::nan("");
    if (!std::isfinite(conditions.supply_volts))
      throw BadInput(
          {args.database + ": campaign " + std::to_string(info.id) +
           ": the supply voltage of these imports is not known; a file needs mains_voltage for it"});
  }
  return conditions;
}

Source campaign_source(const FitArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  Source s;
  s.job.granted = deviations(args, {0.002, 0.002, 0.02});
  std::vector<CampaignInfo> campaigns;
  for (const std::int64_t id : args.campaigns) campaigns.push_back(store.campaign(id));
  if (campaigns.empty()) campaigns.push_back(store.campaign());
  std::vector<AngleGroup> all;
  for (const CampaignInfo& info : campaigns) {
    const auto groups = gather_angles(store, info.id);
    const auto closings = campaign_closings(groups, conditions_of(args, info, groups), s.job.granted);
    if (closings.empty())
      throw BadInput(
          {args.database + ": campaign " + std::to_string(info.id) + " holds no measured closing"});
    s.closings.insert(s.closings.end(), closings.begin(), closings.end());
    all.insert(all.end(), groups.begin(), groups.end());
    s.from += fmt::format("campaign {}: {}\n", info.id, counted(closings.size(), "measured angle"));
  }
  s.job.scatter = shot_scatter(all);
  s.job.problem.base =
      args.specimen_file.empty() ? stored_specimen(campaigns.front()) : read_specimen(args.specimen_file);
  s.job.problem.parameters = tolerances(s.job.problem.base);
  s.job.problem.edge = 0;
  return s;
}

void take_options(const FitArgs& args, Source& s) {
  if (!args.free.empty()) {
    s.job.problem.parameters.clear();
    s.job.posterior_parameters.clear();
  }
  std::set<std::string> names;
  for (const auto& text : args.free) {
    const auto equals = text.find('=');
    const auto colon = text.find(':', equals == std::string::npos ? 0 : equals);
    if (equals == std::string::npos || colon == std::string::npos)
      throw BadInput({"--free " + text + ": allowed NAME=LOW:HIGH, such as core.friction_N=0.5:3"});
    if (!names.insert(text.substr(0, equals)).second)
      throw BadInput({"--free " + text + ": this number is free already; allowed once"});
    try {
      s.job.problem.parameters.push_back(
          sim::parameter(text.substr(0, equals), bound(text.substr(equals + 1, colon - equals - 1), text),
                         bound(text.substr(colon + 1), text)));
    } catch (const std::invalid_argument& e) {
      throw BadInput({std::string("--free ") + e.what()});
    }
  }
  for (const double a : args.hold_out) {
    const auto there = [&](const auto& m) { return same_angle(m.conditions.closing_angle, radians(a)); };
    if (std::none_of(s.closings.begin(), s.closings.end(), there))
      throw BadInput({fmt::format("--hold-out {:g}: no measured closing has this angle", a)});
    s.job.unseen.push_back(radians(a));
  }
  s.job.problem.closings = without(s.closings, s.job.unseen);
  if (s.job.problem.closings.empty()) throw BadInput({"--hold-out leaves no closing to fit to"});
  if (args.leave_one_out)
    for (const auto& m : s.job.problem.closings) s.job.held_out.push_back(m.conditions.closing_angle);
  for (const auto& file : args.start)
    s.job.start.push_back(sim::point_of(read_specimen(file), s.job.problem.parameters));
  if (!args.start.empty() && !args.hold_out.empty())
    throw BadInput({"--start and --hold-out: a start may know what is held out; give one of them"});
  s.job.options.evaluations = args.evaluations;
  s.job.options.ensemble = args.ensemble;
  s.job.searches = args.searches;
  s.job.problem.prior_deviation = args.prior;
  s.job.finish = args.finish;
  s.job.next = args.next;
  s.job.options.seed = args.seed;
}

/// Whether a field made of the base specimen is that of every specimen with this number moved.
bool leaves_field(const sim::Parameter& p) {
  const std::string_view section = p.field->section;
  return section == "core" || section == "bridges" || section == "base" || p.name() == "coil.resistance_ohm";
}

/// The model that simulates, where it is not the plant.
void take_model(const FitArgs& args, sim::FitProblem& problem) {
  const std::string of =
      args.specimen_file.empty() ? std::string("the campaign's specimen") : args.specimen_file;
  if (args.fields.empty() && args.mechanics.empty()) {
    if (!problem.base.lumped)
      throw BadInput(
          {of + ": has a drawing and no circuit, so the plant cannot simulate it; take --fields table"});
    if (const auto beyond = sim::rigid_only(problem.base); !beyond.empty())
      throw BadInput({of + ": " + beyond});
    return;
  }
  const std::string fields = args.fields.empty() ? "circuit" : args.fields,
                    mechanics = args.mechanics.empty() ? "rigid" : args.mechanics;
  if (fields != "circuit") {
    if (args.database.empty())
      throw BadInput({"--fields " + fields +
                      ": allowed with --db; the published tables tell of no magnet but its circuit"});
    for (const auto& p : problem.parameters)
      if (!leaves_field(p))
        throw BadInput({"--free " + p.name() + ": allowed with --fields circuit; " + fields +
                        " is made once, of the specimen as it is"});
  }
  if (!args.fit_file.empty())
    throw BadInput(
        {"--fit: allowed without --fields and --mechanics: what reads a fit file simulates with the plant"});
  FieldCache cache;
  cache.folder = args.cache;
  cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  try {
    const sim::Rung rung = sim::scene_rung(obtain_field(fields, problem.base, cache), mechanics);
    if (rung.costly)
      throw BadInput({"--mechanics " + mechanics + ": a closing takes seconds; allowed plant, rigid, modal"});
    const sim::Case first{problem.base, problem.closings.front().conditions, {}};
    for (const sim::Mechanics& m : sim::all_mechanics())
      if (m.name == mechanics)
        if (const std::string beyond = m.unknown(first); !beyond.empty())
          throw BadInput({of + ": " + beyond});
    problem.model = sim::closing_model(rung);
  } catch (const std::invalid_argument& e) {
    throw BadInput({of + ": " + e.what()});
  }
}

/// The circuit's numbers were moved and the shape is the default one, which nobody drew for this contactor.
bool moves_default_magnet(const sim::FitProblem& problem) {
  return problem.base.shape == sim::MagnetShape{} &&
         std::ranges::any_of(problem.parameters, [](const sim::Parameter& p) {
           return p.field->section == "coil" || p.field->section == "magnet";
         });
}

}  // namespace

std::vector<sim::MeasuredClosing> fit_closings(const FitArgs& args) {
  return (args.database.empty() ? published_source(args) : campaign_source(args)).closings;
}

Exit fit_specimen(const FitArgs& args) {
  if (!args.shards.database.empty() && !args.state_file.empty())
    throw BadInput({"--state and --points-db: both keep what is done, allowed one of them"});
  const bool published = args.database.empty();
  Source source = published ? published_source(args) : campaign_source(args);
  take_options(args, source);
  take_model(args, source.job.problem);
  if (args.shards.slurm > 0) {
    fmt::print("{}", slurm_script(args.shards, args.shards.database));
    return Exit::pass;
  }
  fmt::print(stderr, "{}", source.from);
  for (const std::string& file : {args.output, args.fit_file}) refuse_existing(file, args.overwrite);
  Points points = open_points(args.shards);
  FitState state;
  if (!args.state_file.empty() && std::filesystem::exists(args.state_file))
    state = parse_fit_state(text_of_file(args.state_file), args.state_file);
  const int threads = worker_count(args.threads);
  sim::Team team(threads);
  const StopOnSignal stop;
  const auto per_fit = static_cast<std::size_t>(args.evaluations);
  const auto searches = static_cast<std::size_t>(args.searches);
  const std::size_t blind = blind_fits(source.job);
  const std::size_t per_full = args.finish > 0 ? static_cast<std::size_t>(args.finish) : per_fit;
  Progress progress("fit", per_fit * blind + per_full * (searches + (args.finish > 0 ? 1 : 0)),
                    progress_style(args.progress));
  auto saved = std::chrono::steady_clock::now();
  const auto watch = [&](std::size_t fit, std::size_t fits, long used, long of, double best,
                         const FitState& now) {
    const std::size_t before = std::min(fit, blind) * per_fit + (fit - std::min(fit, blind)) * per_full;
    progress.update(before + static_cast<std::size_t>(std::min(used, of)),  // the last generation may be more
                    fmt::format("search {} of {}, misfit {:.2f}", fit + 1, fits, best));
    const bool asked = StopOnSignal::asked();
    const auto t = std::chrono::steady_clock::now();
    if (!args.state_file.empty() && (asked || t - saved > std::chrono::seconds(2))) {
      replace_file(args.state_file, to_json(now));
      saved = t;
    }
    return !asked;
  };
  FitReport report = run_fits(source.job, team, watch, state, points);
  progress.finish();
  say_points(points, args.shards);
  if (!args.state_file.empty()) replace_file(args.state_file, to_json(report.state));
  if (report.stopped) {
    fmt::print(stderr, "stopped{}\n",
               args.state_file.empty() ? "" : "; the same command goes on from " + args.state_file);
    return Exit::interrupted;
  }
  if (report.part) return Exit::pass;
  const auto cells = fit_cells(report.file, source.closings, source.job.unseen, source.job.problem.model);
  NextMeasurements next;
  if (report.posterior) next = next_measurements(source.job, report.file, *report.posterior, team);
  fmt::print("{}",
             args.json ? fit_json(source.job, report, cells, next) : fit_text(source.job, report, cells));
  if (!args.json && report.posterior) fmt::print("{}", next_text(next));
  if (!args.picture.empty())
    write_picture(args.picture, fit_svg(cells, published ? "Published closings, fitted and held out"
                                                         : "Measured closings, fitted and held out"));
  sim::Specimen best = specimens(report.file, report.file.folds.back()).front();
  best.shaped = best.shaped && !moves_default_magnet(source.job.problem);
  best.name = args.name.empty() ? best.name + "-fitted" : args.name;
  if (!args.output.empty()) replace_file(args.output, resolved_text(best));
  if (!args.fit_file.empty()) replace_file(args.fit_file, to_json(report.file));
  return Exit::pass;
}

}  // namespace powbench::host
