#include <fmt/format.h>

#include "host/cli/commands.h"
#include "host/cli/fmu_verb.h"
#include "host/cli/specimen_verb.h"
#include "host/cli/study.h"
#include "host/cli/verbs.h"
#include "sim/models/mechanics.h"

/// Fits, sweeps, specimens and the ladder: words to arguments.

namespace powbench::host {

namespace {

constexpr const char* steel_footer = R"(
A B-H sheet has one header line and one row a line, the commutation curve from zero upwards:
  H (A/m), B (T)
  42, 0.21
  88, 0.66
H in A/m, kA/m, A/cm or Oe; B in T, mT, G or kG; J (T) in the place of B is the polarisation B - mu0 H.
Other columns are ignored, and the order of the rows does not matter.
Noise is smoothed and its size printed. Numbers that no steel has in these units are refused with the units
that would fit.

Use it:  [magnet] steel = "sheet.csv"     in the specimen file, for every rung, circuit and fields
         powbench field SPECIMEN --steel sheet.csv
)";

/// What was typed but what each shard, and the run that collects them, has of its own.
std::vector<std::string> words_of(const CLI::App& v, const std::string& store) {
  std::vector<std::string> words{v.get_name()}, options;
  for (const CLI::Option* o : v.get_options()) {
    const std::string name = o->get_name();
    const bool own = name == store || name == "--shard" || name == "--slurm" || name == "--threads" ||
                     name == "--progress";
    if (o->count() == 0 || own) continue;
    auto& list = o->nonpositional() ? options : words;
    if (o->nonpositional()) list.push_back(name);
    if (o->get_items_expected_max() > 0) list.insert(list.end(), o->results().begin(), o->results().end());
  }
  words.insert(words.end(), options.begin(), options.end());
  return words;
}

}  // namespace

void add_shard_options(CLI::App* v, ShardArgs& args, const char* of, const char* store) {
  args.store = store;
  args.verb = v->get_name();
  args.threads = v->get_option_no_throw("--threads") != nullptr;
  if (args.store == "--points-db")
    v->add_option("--points-db", args.database,
                  fmt::format("store of computed points, made if missing: each {} found in it is reused, "
                              "the others are computed and added",
                              of));
  v->add_option(
      "--shard", args.shard,
      fmt::format("I/N: compute only part I of N (each {0} in turn) into the store of {1}, without a result; "
                  "`powbench db merge` puts the "
                  "parts together, then the same command without --shard prints the result",
                  of, store));
  v->add_option("--slurm", args.slurm,
                "print a script that submits this number of shards to Slurm and merges them; compute nothing")
      ->check(CLI::Range(1, 1'000'000));
  v->parse_complete_callback([v, &args] { args.words = words_of(*v, args.store); });
}

void add_study_verbs(CLI::App& app) {
  auto tables = std::make_shared<TablesArgs>();
  CLI::App* show =
      verb(app, "tables", "Compare the published tables with this simulator, with the errors recomputed",
           tables, show_tables);
  show->add_option("--specimen", tables->specimen_file,
                   "specimen file (TOML); scenes/published.specimen.toml if left out");
  show->add_option("--fit", tables->fit_file,
                   "fit file of `powbench fit`, whose held-out predictions are used");
  show->add_flag("--pressure", tables->pressure,
                 "compare the published statements on contact pressure with two simulated bounce trains");
  show->add_flag("--json", tables->json, "JSON to stdout");
  auto field_args = std::make_shared<FieldArgs>();
  CLI::App* field =
      verb(app, "field", "Compute the field table of a magnet by finite elements, with pictures", field_args,
           show_field);
  field->add_option(
      "specimen", field_args->specimen_file,
      "specimen file (TOML) with the [shape] of an E-core, U-core (legs = 2) or C-core (legs = 2, "
      "closed_leg = 1) or of a solenoid (kind = \"solenoid\"), or a drawing (x.magnet.toml) of any "
      "magnet on a mesh of gmsh; the reference contactor if left out");
  field->add_option("-o,--output", field_args->folder, "folder for table and pictures; made if missing")
      ->capture_default_str();
  field->add_option("--accuracy", field_args->accuracy, "relative error of current and pull")
      ->capture_default_str();
  field->add_option("--steel", field_args->steel,
                    "built-in steel or B-H sheet (CSV) in place of the specimen's");
  field->add_flag("--ring", field_args->ring, "add the flux of the shading ring as a third variable");
  field->add_option(
      "--mesh", field_args->mesh_file,
      "plane mesh of gmsh (MSH 2.2 or 4.1) in place of the specimen's shape: one state at --current");
  field->add_option("--mesh-unit", field_args->mesh_unit, "unit of the mesh coordinates: mm, m or in")
      ->capture_default_str();
  field->add_option("--current", field_args->current, "coil current, A, with --mesh or for a solenoid")
      ->default_str("0.3");
  field->add_flag("--symmetric", field_args->symmetric, "the mesh is one half of the device");
  field->add_flag("--ends", field_args->ends,
                  "include the end effects of stack and coil, with --ring also of the ring (minutes), in "
                  "three dimensions");
  field->add_option(
      "--out", field_args->tables,
      "table of flux linkage and force over current and position; FILE.csv, FILE.mat (Simscape and "
      "Modelica) or FILE.txt (Modelica); may be repeated");
  field
      ->add_option("--largest-current", field_args->largest_current,
                   "largest current of the tables of --out, A; 0: that of the open core at the largest flux")
      ->check(CLI::Range(0.0, 1e4))
      ->capture_default_str();
  field->add_option("-j,--threads", field_args->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_shard_options(field, field_args->shards, "group of four gaps of the table with all their fluxes");
  field->add_flag("--json", field_args->json, "JSON to stdout");
  auto steel_args = std::make_shared<SteelArgs>();
  CLI::App* steel =
      verb(app, "steel",
           "Check, smooth and plot the B-H curve of a steel; without a steel, list the built-in ones",
           steel_args, show_steel);
  steel->footer(steel_footer);
  steel->add_option("steel", steel_args->steel,
                    "B-H sheet (CSV) or built-in steel; all built-in ones if left out");
  steel->add_option("-o,--output", steel_args->picture, "picture (SVG); the steel's name if left out");
  steel->add_flag("--json", steel_args->json, "JSON to stdout");
  auto args = std::make_shared<DemoArgs>();
  CLI::App* all =
      verb(app, "demo", "The whole path on the simulated rig: run, simulate, compare, report", args, demo);
  all->add_option("-o,--output", args->folder, "folder for store and report; made if missing")
      ->capture_default_str();
  all->add_option("--rig", args->rig, "rig to use instead of the simulated one")->capture_default_str();
  add_progress(all, args->progress);
}

void add_fit_verb(CLI::App& app) {
  auto fit = std::make_shared<FitArgs>();
  CLI::App* v = verb(
      app, "fit", "Identify a specimen from a measured campaign or, without --db, from the published tables",
      fit, fit_specimen);
  v->add_option("--db", fit->database, "store with the measured campaign");
  v->add_option("--campaign", fit->campaigns,
                "campaign ids, such as 3,4,5: imports with other calibration files are campaigns of their "
                "own; the newest if left out")
      ->delimiter(',');
  v->add_option("--specimen", fit->specimen_file, "specimen file (TOML) with the numbers that are not free");
  v->add_option(
      "--fields", fit->fields,
      "model that simulates: circuit, table, ends or solved, as for `sim`; the plant if both are left out");
  v->add_option("--mechanics", fit->mechanics, "plant, rigid or modal; rigid if --fields is given alone");
  v->add_option("--cache", fit->cache, "folder for field tables; made if missing")->capture_default_str();
  v->add_option("--free", fit->free,
                "free parameter and its bounds, NAME=LOW:HIGH in the unit of the specimen file");
  v->add_option(
      "--start", fit->start,
      "specimen file that the fit to all closings may begin from; never used where angles are held out");
  v->add_option("--deviations", fit->deviations,
                "standard deviations of the model in percent of touch, seat and bounce, such as 1.0,1.1,5; a "
                "fourth one makes the overtravel time a target of its own")
      ->delimiter(',')
      ->type_name("FLOAT")
      ->expected(3, 4)
      ->check(CLI::Range(0.01, 100.0));
  v->add_option(
       "--prior", fit->prior,
       "prior standard deviation of each free parameter, as a share of the width of its bounds; 0: no prior")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  v->add_option("--hold-out", fit->hold_out,
                "closing angles, degrees, that are predicted and not used by the fit")
      ->delimiter(',');
  v->add_flag("--leave-one-out", fit->leave_one_out,
              "predict every angle from the others, one posterior each");
  v->add_option(
       "--next", fit->next,
       "propose so many measurements: quantity, angle and number of shots from which most is to be learnt")
      ->check(CLI::Range(1, 48));
  v->add_option("--evaluations", fit->evaluations,
                "specimens tried in each global search of the fit to all closings")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  v->add_option("--searches", fit->searches, "independent global searches of the fit to all closings")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  v->add_option(
       "--finish", fit->finish,
       "specimens tried in a last search of the fit to all closings, started from the best ones, that "
       "minimises the sum of absolute deviations")
      ->check(CLI::Range(0, 100'000'000))
      ->capture_default_str();
  v->add_option("--ensemble", fit->ensemble, "fits to shifted data in addition to each global search")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  v->add_option("--seed", fit->seed, "seed of the search")->capture_default_str();
  v->add_option("-j,--threads", fit->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  v->add_option("--state", fit->state_file,
                "file with the state of the search, from which an interrupted fit continues");
  v->add_option("-o,--output", fit->output, "specimen file to write");
  v->add_option("--name", fit->name, "name of the specimen written");
  v->add_option("--svg", fit->picture, "picture to write: measured, fitted, held out");
  v->add_option("--fit", fit->fit_file,
                "fit file to write: every specimen found, for `powbench tables --fit`");
  v->add_flag("--overwrite", fit->overwrite, "replace specimen file and fit file that are there already");
  add_shard_options(v, fit->shards, "posterior of a held-out angle or global search");
  v->add_flag("--json", fit->json, "JSON to stdout");
  add_progress(v, fit->progress);
}

void add_sweep_verb(CLI::App& app) {
  auto args = std::make_shared<SweepArgs>();
  CLI::App* v = verb(app, "sweep", "Simulate many closings: sweeps, sensitivities, the best closing angle",
                     args, sweep);
  v->add_option("--specimen", args->specimen_file,
                "specimen file (TOML); the reference contactor if left out");
  v->add_option("--vary", args->vary,
                "NAME=LOW:HIGH[:STEPS] or NAME~MEAN:DEVIATION; NAME is angle_deg, supply_volts, mains_hertz, "
                "ambient_degC or section.key of the specimen file");
  v->add_option("--sampling", args->sampling, "grid, latin or monte-carlo")
      ->check(CLI::IsMember({"grid", "latin", "monte-carlo"}))
      ->capture_default_str();
  v->add_option("--points", args->points, "number of closings for latin and monte-carlo")
      ->capture_default_str();
  v->add_option("--seed", args->seed, "seed of the points")->capture_default_str();
  v->add_option("--angle", args->angle_deg, "closing angle in degrees, if not varied")->capture_default_str();
  v->add_option("--volts", args->supply_volts, "supply, V rms, if not varied")->capture_default_str();
  v->add_option("--ambient", args->ambient_degC, "coil temperature, degC, if not varied")
      ->check(CLI::Range(-50.0, 150.0))
      ->capture_default_str();
  v->add_option(
       "--metric", args->metric,
       "touch, bounce, settled, seat, openings, open_time, touch_velocity, seat_velocity, first_peak or "
       "impulse: for --sensitivity and --best-angle")
      ->capture_default_str();
  v->add_flag("--forces", args->forces, "compute first_peak and impulse, too");
  v->add_flag("--sensitivity", args->sensitivity,
              "sensitivity of the metric to mains, temperature, angle, friction, mass and gap");
  v->add_flag("--best-angle", args->best_angle,
              "find the closing angle with the smallest metric over the tolerances of the device (--vary)");
  v->add_option("--svg", args->picture, "picture to write");
  v->add_option("--angles", args->angles, "closing angles over half a period for --sensitivity, --best-angle")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  v->add_option("--draws", args->draws, "sampled devices for --best-angle")
      ->check(CLI::Range(2, 100'000))
      ->capture_default_str();
  v->add_option("--db", args->database,
                "store to write, made if missing; an interrupted sweep continues from it")
      ->capture_default_str();
  v->add_option("-j,--threads", args->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_shard_options(v, args->shards, "block of 500 closings", "--db");
  v->add_flag("--json", args->json, "JSON to stdout");
  add_progress(v, args->progress);
}

void add_specimen_verbs(CLI::App& app) {
  CLI::App* specimen =
      app.add_subcommand("specimen", "Derived quantities, circuit and conversion of a specimen file");
  specimen->require_subcommand(1);
  auto args = std::make_shared<SpecimenArgs>();
  CLI::App* v = verb(*specimen, "describe",
                     "Print inrush and holding power, pick-up and drop-out voltage, frequencies and rebounds "
                     "beside catalogue "
                     "ranges",
                     args, describe_specimen);
  v->add_option("file", args->file,
                "specimen file (TOML), also of a solenoid; the reference contactor if left out");
  v->add_option("--volts", args->volts, "rated voltage, V rms; if left out 230, for a solenoid 24 (V dc)")
      ->check(CLI::Range(1.0, 1e4));
  v->add_option("--hertz", args->hertz, "rated frequency, Hz; 50 if left out")->check(CLI::Range(1.0, 1e3));
  v->add_flag("--json", args->json, "JSON to stdout");
  auto circuit = std::make_shared<CircuitArgs>();
  v = verb(*specimen, "circuit",
           "Print the lumped circuit nearest to the magnet's field, with the residual at each gap: a drawn "
           "magnet "
           "then also runs on the simulated rig and as a mock-up unit",
           circuit, identify_specimen_circuit);
  v->add_option("file", circuit->file,
                "specimen file (TOML) with a drawing or [shape]; the reference contactor if left out");
  v->add_option("--volts", circuit->volts, "rated voltage, V rms: sets the largest flux linkage")
      ->check(CLI::Range(1.0, 1e4))
      ->capture_default_str();
  v->add_option("--hertz", circuit->hertz, "rated frequency, Hz")
      ->check(CLI::Range(1.0, 1e3))
      ->capture_default_str();
  v->add_option("--accuracy", circuit->accuracy, "accuracy of the field table")->capture_default_str();
  v->add_option("--cache", circuit->cache, "folder for field tables; made if missing")->capture_default_str();
  v->add_flag("--json", circuit->json, "JSON to stdout");
  auto former = std::make_shared<SpecimenArgs>();
  verb(*specimen, "convert",
       "Convert a file with the former definition of restitution to that of a drop test, with the same "
       "closings",
       former, convert_specimen)
      ->add_option("file", former->file, "specimen file (TOML) to convert")
      ->required();
}

void add_ladder_verb(CLI::App& app) {
  auto args = std::make_shared<LadderArgs>();
  CLI::App* v = verb(app, "ladder",
                     "One closing on every rung: compare error and cost, or find the rung for an accuracy",
                     args, show_ladder);
  v->add_option(
      "scene", args->scene,
      "specimen file or plan (NAME.plan.toml, its first shot); the reference contactor if left out");
  v->add_option("--angle", args->angles_deg, "closing angle in degrees; several with --judge");
  v->add_option("--volts", args->supply_volts, "supply, V rms");
  v->add_option("--ambient", args->ambient_degC, "coil temperature, degC")->check(CLI::Range(-50.0, 150.0));
  v->add_option(
      "--judge", args->judge,
      "share, such as 1%: print for each pair its times, step, model and input errors, cost, and whether "
      "touch, seat and settled are known to that share of the touch time");
  v->add_option(
      "--fit", args->fit_file,
      "with --judge: file of `powbench fit --leave-one-out`; its prediction error at a held-out angle is "
      "used as the field error of the identified specimen there");
  v->add_option("--db", args->database,
                "with --fit: store with the closings; the published tables if left out");
  v->add_option("--campaign", args->campaign, "with --fit: number of the campaign; the newest if left out");
  v->add_option("--accuracy", args->accuracy,
                "such as 0.1%: take the cheapest rung and tolerance whose estimated error in touch, seat and "
                "settled is below this share of the touch time");
  v->add_option("--fields", args->fields,
                "fields of the rungs: " + sim::names_of(sim::all_fields(), ", ") + "; may be repeated");
  v->add_option("--mechanics", args->mechanics,
                "only rungs with these mechanics: " + sim::names_of(sim::all_mechanics()));
  v->add_flag("--all", args->all, "every pair of fields and mechanics, also those that take minutes");
  v->add_option("--cache", args->cache, "folder for field tables; made if missing")->capture_default_str();
  v->add_option("--table", args->table_file,
                "field table of `powbench field`: also the rung table+rigid; with --accuracy only this one");
  add_shard_options(v, args->shards, "cell of the table (a rung at a setting)");
  v->add_option("-o,--output", args->folder, "folder for the picture; made if missing")
      ->capture_default_str();
  v->add_flag("--json", args->json, "JSON to stdout");
}

void add_fmu_verb(CLI::App& app) {
  auto args = std::make_shared<FmuArgs>();
  CLI::App* v = verb(app, "fmu", "The contactor as a functional mock-up unit (FMI) for a system simulator",
                     args, make_fmu);
  v->add_option("specimen", args->specimen_file, "specimen file (TOML); the reference contactor if left out");
  v->add_option("-o,--output", args->output, "FMU to write")->capture_default_str();
  v->add_option("--fmi", args->fmi,
                "2: FMI 2.0, model exchange and co-simulation; 3: FMI 3.0, co-simulation with event mode and "
                "early return")
      ->check(CLI::IsMember({2, 3}))
      ->capture_default_str();
  v->add_flag("--json", args->json, "JSON to stdout");
}

}  // namespace powbench::host
