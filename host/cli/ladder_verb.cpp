#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/cpu_time.h"
#include "core/units.h"
#include "host/cli/ladder_errors.h"
#include "host/cli/percent.h"
#include "host/cli/picture.h"
#include "host/cli/study.h"
#include "host/export/ladder_svg.h"
#include "host/gather/scene.h"
#include "host/run/campaign.h"
#include "host/store/field_table.h"
#include "host/store/hash.h"
#include "host/store/json.h"
#include "host/store/point_bytes.h"
#include "host/store/store.h"
#include "host/study/bounce_text.h"
#include "host/study/scene_fields.h"
#include "sim/models/mechanics.h"
#include "sim/study/scene_choice.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// 0 for "".
double share_of(const std::string& word) {
  return word.empty() ? 0 : share_option("--accuracy", word, 1e-10, 0.5, "1e-8% .. 50%");
}

/// A plan brings its specimen and the conditions of its first shot; options that are given come on top.
sim::Case case_of(const LadderArgs& args) {
  sim::Case c;
  if (args.scene.ends_with(".plan.toml")) {
    const Scene scene = load_scene(args.scene);
    c.specimen = scene.specimen;
    if (!scene.shots.empty()) c.conditions = scene.shots.front().conditions;
  } else if (!args.scene.empty()) {
    c.specimen = read_specimen(args.scene);
  }
  if (!args.angles_deg.empty()) c.conditions.closing_angle = radians(args.angles_deg.front());
  if (args.supply_volts) c.conditions.supply_volts = *args.supply_volts;
  if (args.ambient_degC) c.conditions.ambient = *args.ambient_degC + zero_celsius;
  return c;
}

std::string time_text(double seconds, double per_second) {
  if (std::isnan(seconds)) return "-";
  if (std::isinf(seconds)) return "no";
  return per_second == 1e3 ? fmt::format("{:.4f}", seconds * 1e3)
                           : fmt::format("{:.1e}", seconds * per_second);
}

/// Where points are kept no time is: it is not a function of the point.
Json milliseconds(double seconds) {
  return std::isnan(seconds) ? Json() : Json(seconds * 1e3);
}

Json row_json(const sim::LadderRow& r, const std::vector<sim::Rung>& rungs, bool with_error) {
  Json j{{"rung", rungs[r.run.rung].name()},
         {rungs[r.run.rung].setting, r.run.tolerance},
         {"cpu_ms", milliseconds(r.run.cpu)},
         {"rhs_evaluations", r.run.evaluations},
         {"openings", r.run.openings}};
  for (std::size_t q = 0; q < r.estimate.size(); ++q) {
    const std::string name(sim::ladder_quantities[q]);
    j[name + "_s"] = r.run.times[q];
    j[name + "_estimate_s"] = r.estimate[q];
    if (with_error) j[name + "_error_s"] = r.error[q];
  }
  return j;
}

std::string setting(const std::vector<sim::Rung>& rungs, const sim::LadderRun& run) {
  return fmt::format("{} {:g}", rungs[run.rung].setting, run.tolerance);
}

void print_rows(const std::vector<sim::LadderRow>& rows, const std::vector<sim::Rung>& rungs,
                bool with_error) {
  fmt::print("{:<18} {:>15} {:>10} {:>7}", "rung", "setting", "CPU ms", "rhs");
  for (const auto q : sim::ladder_quantities)
    fmt::print(" {:>11}{} {:>8}", fmt::format("{} ms", q), with_error ? "    err us" : "", "est us");
  fmt::print("\n");
  for (const auto& r : rows) {
    fmt::print("{:<18} {:>15} {:>10} {:>7}", rungs[r.run.rung].name(), setting(rungs, r.run),
               std::isnan(r.run.cpu) ? "-" : fmt::format("{:.3f}", r.run.cpu * 1e3), r.run.evaluations);
    for (std::size_t q = 0; q < r.estimate.size(); ++q)
      fmt::print(" {:>11}{} {:>8}", time_text(r.run.times[q], 1e3),
                 with_error ? fmt::format(" {:>9}", time_text(r.error[q], 1e6)) : "",
                 time_text(r.estimate[q], 1e6));
    fmt::print("\n");
  }
}

/// Standard uncertainties that `sim` takes where a plan says nothing: 0.5 % of the voltage, 2 K of the coil.
std::vector<sim::InputUncertainty> usual_inputs(const sim::Case& c) {
  const RunOptions o;
  return {{"supply_volts", o.supply_u * c.conditions.supply_volts}, {"ambient_degC", o.coil_temperature_u}};
}

/// Of the one rung that is cheapest: inputs move all rungs alike.
sim::LadderTimes input_error_of(const std::vector<sim::Rung>& rungs, const sim::Case& c, double duration) {
  const auto& r = rungs.front();
  return sim::input_error(r, r.settings.empty() ? 1e-6 : r.settings.front(), c, duration, usual_inputs(c),
                          thread_cpu_seconds);
}

Exit choose(const sim::Case& c, const std::vector<sim::Rung>& rungs, double accuracy, double duration,
            bool json) {
  const auto choice = sim::choose_rung(rungs, c, accuracy, duration, thread_cpu_seconds);
  const auto& rung = rungs[choice.run.rung];
  const auto input = input_error_of(rungs, c, duration);
  if (json) {
    Json tried = Json::array();
    for (const auto& r : choice.tried) tried.push_back(row_json(r, rungs, false));
    Json taken = row_json({choice.run, choice.estimate, {}, false}, rungs, false);
    fmt::print("{}\n", Json{{"accuracy", accuracy},
                            {"verdict", choice.met ? "not known" : "not met"},
                            {"step_met", choice.met},
                            {"step_error_s", choice.estimate},
                            {"model_error_s", sim::nan_times},
                            {"input_error_s", input},
                            {"estimate", choice.relative},
                            {"taken", taken},
                            {"cpu_ms_with_choosing", choice.spent * 1e3},
                            {"tried", tried}}
                           .dump(2));
    return choice.met ? Exit::not_known : Exit::outside_limits;
  }
  print_rows(choice.tried, rungs, false);
  fmt::print("{} at {} ({}): its step {} the wanted {:.3g} % of the touch time, estimate {:.2g} %; {}\n",
             rung.name(), setting(rungs, choice.run), rung.meaning, choice.met ? "meets" : "does not meet",
             accuracy * 100, choice.relative * 100,
             choice.met ? "the cheapest of those tried that does" : "nothing tried does; this comes nearest");
  fmt::print(
      "touch {} ms, seat {} ms, settled {} ms, {} re-openings; {:.3f} ms CPU, {:.3f} ms with choosing\n",
      time_text(choice.run.times[0], 1e3), time_text(choice.run.times[1], 1e3),
      time_text(choice.run.times[2], 1e3), choice.run.openings, choice.run.cpu * 1e3, choice.spent * 1e3);
  fmt::print(
      "input error: touch {}, seat {}, settled {} us (0.5 % of the voltage, 2 K of the coil; the specimen's "
      "own "
      "numbers: not known)\n",
      or_not_known(input[0]), or_not_known(input[1]), or_not_known(input[2]));
  fmt::print("wanted accuracy: {}\n", choice.met ? "not known. The step is fine enough; nothing is compared "
                                                   "with another model. `powbench sim --fields auto "
                                                   "--accuracy` judges the model too"
                                                 : "not met");
  return choice.met ? Exit::not_known : Exit::outside_limits;
}

/// Pairs of fields and mechanics. Without a name only one physics and no pair that takes seconds; with --all every
/// pair that ends within minutes.
std::vector<sim::Rung> rungs_of(const LadderArgs& args, const sim::Specimen& specimen) {
  FieldCache cache;
  cache.folder = args.cache;
  cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  std::vector<std::string> fields = args.fields;
  if (args.all && fields.empty())
    for (const auto& f : sim::all_fields()) fields.emplace_back(f.name);
  if (fields.empty()) fields = {"circuit"};
  const bool one_physics = !args.accuracy.empty() && args.mechanics.empty();
  std::vector<sim::Rung> rungs;
  for (const auto& name : fields) {
    const auto field = obtain_field(name, specimen, cache);
    for (const auto& m : sim::all_mechanics()) {
      if (!args.mechanics.empty() && m.name != args.mechanics) continue;
      if (!m.any_fields && name != "circuit" && args.mechanics.empty()) continue;
      if (m.detail > 0 && one_physics) continue;
      if (field.costly && m.detail > 0 && args.mechanics.empty()) continue;  // hours
      const auto rung = sim::scene_rung(field, m.name);
      if (rung.costly && !args.all && args.mechanics.empty() && args.fields.empty()) continue;
      if (m.costly && !args.all && args.mechanics.empty()) continue;
      rungs.push_back(rung);
    }
  }
  if (rungs.empty()) sim::mechanics_named(args.mechanics);  // names what is known
  return rungs;
}

/// All that is computed for one ladder.
struct LadderResult {
  std::optional<sim::Ladder> ladder;
  sim::LadderTimes input{};
  std::string bounces, bounces_json;
};

constexpr double not_kept = std::numeric_limits<double>::quiet_NaN();

std::string bytes_of(const sim::LadderRun& run) {
  ByteWriter out;
  for (const double t : run.times) out.add(t);
  return out.add(static_cast<std::int64_t>(run.openings)).add(run.evaluations).bytes();
}

sim::LadderRun run_of(const std::string& bytes, std::size_t rung, double setting) {
  ByteReader in(bytes);
  sim::LadderRun run;
  run.rung = rung;
  run.tolerance = setting;
  for (double& t : run.times) t = in.number();
  run.openings = static_cast<std::size_t>(in.integer());
  run.evaluations = in.integer();
  run.cpu = not_kept;
  return run;
}

/// Cells, the input error and the bounces, each a point of its own. `basis`: specimen, conditions and tables, as text.
LadderResult result_of(Points& points, const std::vector<sim::Rung>& rungs, const sim::Case& c,
                       const sim::LadderOptions& options, const sim::BounceStudyOptions& believed,
                       const std::string& basis) {
  LadderResult r;
  std::int64_t number = 0;
  const sim::CpuClock clock = points.stored() ? sim::CpuClock([] { return 0.0; }) : thread_cpu_seconds;
  const auto cell = [&](std::size_t rung, double setting, int repeats) -> std::optional<sim::LadderRun> {
    const auto run = [&](int times) {
      return sim::run_rung(rungs, rung, c, options.duration, setting, clock, times);
    };
    if (!points.stored()) return run(repeats);
    const std::string name = fmt::format("cell {} {} {} {}\n{}", rungs[rung].name(), rungs[rung].setting,
                                         setting, options.duration, basis);
    const auto bytes = points.get(number++, name, [&] { return bytes_of(run(1)); });
    return bytes ? std::optional(run_of(*bytes, rung, setting)) : std::nullopt;
  };
  r.ladder = sim::run_ladder(rungs, options, cell);
  const std::string all = fmt::format("{} {}\n{}", rungs.front().name(), options.duration, basis);
  if (const auto bytes = points.get(number++, "input error " + all, [&] {
        ByteWriter out;
        for (const double e : input_error_of(rungs, c, options.duration)) out.add(e);
        return out.bytes();
      })) {
    ByteReader in(*bytes);
    for (double& e : r.input) e = in.number();
  }
  std::string names;
  for (const auto& rung : rungs) names += rung.name() + " ";
  if (const auto bytes = points.get(number++, "bounces " + names + all, [&] {
        const auto rows = bounces_of(rungs, c, believed);
        return ByteWriter().add(bounce_text(rows, believed)).add(bounce_json(rows)).bytes();
      })) {
    ByteReader in(*bytes);
    r.bounces = in.text();
    r.bounces_json = in.text();
  }
  return r;
}

/// What the points of a ladder depend on but for rung and setting.
std::string basis_of(const LadderArgs& args, const sim::Case& c) {
  std::string text = resolved_text(c.specimen) + "\n" + to_json(c.conditions);
  if (!args.table_file.empty())
    text += "\n" + sha256_hex(field_table_bytes(load_field_table(args.table_file)));
  return text;
}

}  // namespace

Exit show_ladder(const LadderArgs& args) {
  const bool shared_out =
      !args.shards.database.empty() || !args.shards.shard.empty() || args.shards.slurm > 0;
  if (shared_out && !args.accuracy.empty())
    throw BadInput(
        {"--accuracy: each run decides on the next by its CPU time, so there are no points to share out; "
         "--points-db, --shard and --slurm are for the whole ladder"});
  if (!args.judge.empty() && (shared_out || !args.accuracy.empty() || !args.table_file.empty()))
    throw BadInput(
        {"--judge: the table of all pairs; without --accuracy, --table and the options of points"});
  if (args.judge.empty() && args.angles_deg.size() > 1)
    throw BadInput({"--angle: one for a ladder; several with --judge"});
  if (args.judge.empty() && !args.fit_file.empty()) throw BadInput({"--fit: for --judge only"});
  const sim::Case c = case_of(args);
  if (!args.judge.empty()) return judge_ladder(args, c);
  if (args.shards.slurm > 0) {
    fmt::print("{}", slurm_script(args.shards, args.shards.database));
    return Exit::pass;
  }
  if (!args.table_file.empty() && !std::filesystem::exists(args.table_file))
    throw BadInput({args.table_file + ": no such file; `powbench field` makes a table"});
  std::vector<sim::Rung> rungs;
  try {
    rungs = rungs_of(args, c.specimen);
  } catch (const std::invalid_argument& e) {
    throw BadInput({e.what()});
  }
  if (!args.table_file.empty()) {
    // the estimate speaks of one physics: it cannot choose between fields
    if (!args.accuracy.empty()) rungs.clear();
    const auto table = std::make_shared<sim::TablePotential>(load_field_table(args.table_file));
    rungs.push_back(sim::scene_rung(sim::pure_field("table", table->table().description, table), "rigid"));
  }
  const sim::LadderOptions options;
  if (const double accuracy = share_of(args.accuracy); accuracy > 0)
    return choose(c, rungs, accuracy, options.duration, args.json);
  sim::BounceStudyOptions believed;
  believed.end = options.duration;
  Points points = open_points(args.shards);
  const LadderResult result = result_of(points, rungs, c, options, believed, basis_of(args, c));
  say_points(points, args.shards);
  if (points.part()) return Exit::pass;
  const sim::Ladder& ladder = *result.ladder;
  const sim::LadderTimes& input = result.input;
  const std::string title = fmt::format("{}, {:g} V, {:g} degrees: error against cost", c.specimen.name,
                                        c.conditions.supply_volts, c.conditions.closing_angle * 180 / pi);
  const fs::path picture = fs::path(args.folder) / "ladder.svg";
  write_picture(picture, ladder_svg(ladder, rungs, title));
  if (args.json) {
    Json rows = Json::array();
    for (const auto& r : ladder.rows) rows.push_back(row_json(r, rungs, true));
    Json models = Json::array();
    for (const auto& m : ladder.models)
      models.push_back(
          {{"rung", rungs[m.rung].name()}, {"other", rungs[m.other].name()}, {"difference_s", m.difference}});
    Json errors = Json::array();
    for (std::size_t r = 0; r < rungs.size(); ++r)
      errors.push_back({{"rung", rungs[r].name()},
                        {"model_error_s", model_error_of(r, rungs, ladder).known()},
                        {"model_error_known_part_s", model_error_of(r, rungs, ladder).part},
                        {"input_error_s", input}});
    fmt::print("{}\n", Json{{"rows", rows},
                            {"models", models},
                            {"errors", errors},
                            {"bounces", Json::parse(result.bounces_json)},
                            {"picture", picture.string()}}
                           .dump(2));
    return Exit::pass;
  }
  fmt::print("{}; errors against the same rung at tolerance {:.0e}, or its finest setting\n", title,
             options.truth);
  print_rows(ladder.rows, rungs, true);
  for (const auto& m : ladder.models)
    fmt::print("{} and {} are apart by touch {} us, seat {} us, settled {} us\n", rungs[m.rung].name(),
               rungs[m.other].name(), time_text(m.difference[0], 1e6), time_text(m.difference[1], 1e6),
               time_text(m.difference[2], 1e6));
  fmt::print("{}", three_errors_text(ladder, rungs, input));
  fmt::print("\n{}{}\n", result.bounces, picture.string());
  return Exit::pass;
}

}  // namespace powbench::host
