#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include <exception>
#include <functional>

#include "host/cli/commands.h"
#include "host/cli/manual.h"
#include "host/cli/program.h"
#include "host/cli/unknown_verb.h"
#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/store/store.h"
#include "rigs/rig.h"

/// The command line: words to arguments, exceptions to sentences and exit codes. The work is in the verbs.

namespace {

using namespace powbench;
using namespace powbench::host;

constexpr const char* import_footer = R"(
A waveform file has one header line and one line a sample:
  time [s],pvdf_a [N],pvdf_b [V],laser [mm]
  -0.0200,0.013,0.0021,0.0004
  -0.0199,0.011,0.0019,
Columns, in any order and number: time [s ms us]; pvdf_a, pvdf_b [N mN V mV]; laser [m mm um V mV]; coil_current
[A mA V mV]; coil_voltage, mains_voltage, contact_a, aux [V mV]. Time zero is switch-on. Stamps may be uneven but must
rise. An empty cell or nan is a lost sample. Semicolons or tabs may separate, then decimals may have commas. Lines
that begin with # are skipped.

Volts of a film, laser or current clamp need a calibration file, shot.toml beside shot.csv:
  calibration = "sensors 2026-03"
  valid_until = "2027-03-01"
  [pvdf_b]
  gain_N_per_V = 10
  corner_hertz = 0.5
All its keys: powbench plan template calibration

Files of oscilloscopes are read as they come; [columns] of the calibration file says which column is which channel, and
--suggest writes it:
  powbench import scope.csv --suggest -o scope.toml

Try:  powbench events shot.csv             contacts at once, without a store; --json for programs
      powbench import shot.csv --db lab.db  then events, export, report from there
)";

constexpr const char* steel_footer = R"(
A B-H sheet has one header line and one row a line, the commutation curve from zero upwards:
  H (A/m), B (T)
  42, 0.21
  88, 0.66
H in A/m, kA/m, A/cm or Oe; B in T, mT, G or kG; J (T) in the place of B is the polarisation B - mu0 H.
Other columns are passed over, the order of rows does not matter.
Noise is smoothed and its size printed. Numbers that no steel has in these units are refused with the units
that would fit.

Use it:  [magnet] steel = "sheet.csv"     in the specimen file: every rung, circuit and fields, takes it
         powbench field SPECIMEN --steel sheet.csv
)";

void add_result_options(CLI::App* app, ResultArgs& args) {
  app->add_option("--db", args.database, "store to read")->capture_default_str();
  app->add_option("--campaign", args.campaign, "campaign id; the newest if left out");
  app->add_flag("--json", args.json, "JSON to stdout");
}

void add_plan_verbs(CLI::App& app) {
  CLI::App* plan = app.add_subcommand("plan", "Check a plan, show its shots, print a template");
  plan->require_subcommand(1);
  auto check = std::make_shared<PlanArgs>();
  verb(*plan, "check", "Read the plan and its specimen; name every mistake", check, check_plan)
      ->add_option("plan", check->file, "plan file (TOML)")
      ->required();
  auto show = std::make_shared<PlanArgs>();
  CLI::App* list = verb(*plan, "show", "Print the randomised list of shots", show, show_plan);
  list->add_option("plan", show->file, "plan file (TOML)")->required();
  list->add_flag("--json", show->json, "JSON to stdout");
  auto kind = std::make_shared<std::string>();
  verb(*plan, "template", "Print a commented file with every key", kind, print_template)
      ->add_option("kind", *kind, "plan, rig, specimen, solenoid or calibration")
      ->check(CLI::IsMember({"plan", "rig", "specimen", "solenoid", "calibration"}))
      ->required();

  auto run = std::make_shared<RunArgs>();
  CLI::App* acquire = verb(app, "run", "Fire a plan on a rig and store every shot", run, run_plan);
  acquire->add_option("plan", run->plan, "plan file (TOML)")->required();
  acquire->add_option("--rig", run->rig, "rig: ip:ADDRESS, sim: or sim:RIG.toml, serial:PORT,BAUD, usb:...");
  acquire->add_option("--db", run->database, "store to write; made if missing")->capture_default_str();
  acquire->add_flag(
      "--resume", run->resume,
      "go on with the newest campaign of this plan: fire what is missing, begin if there is none");
  acquire->add_flag("--dry-run", run->dry_run, "check everything, fire nothing");
  acquire->add_option("--seed", run->seed, "seed instead of the plan's");
  acquire->add_option("--max-failures", run->max_failures, "shots without a record in a row before stopping")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  acquire->add_flag("--json", run->json, "summary as JSON to stdout");
  add_progress(acquire, run->progress);

  auto sim = std::make_shared<SimArgs>();
  CLI::App* simulate =
      verb(app, "sim", "Simulate the closings of a plan, or one closing of a solenoid", sim, simulate_plan);
  simulate
      ->add_option("plan", sim->plan, "plan file, or specimen file of a solenoid: kind = \"solenoid\" (TOML)")
      ->required();
  simulate->add_option(
      "--sensors", sim->rig_file,
      "rig file (TOML) whose sensors to simulate through; of a solenoid: its supply, switch and "
      "suppression. Without: direct current, freewheel diode of 0.7 V");
  simulate->add_option("--db", sim->database, "store to write; made if missing")->capture_default_str();
  simulate->add_option("-j,--threads", sim->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  simulate->add_option(
      "--fields", sim->fields,
      "circuit, table, field2d or field3d; auto: as far up as the accuracy takes. Of a solenoid: table, "
      "field2d, or eddy: field2d with eddy currents");
  simulate->add_option("--mechanics", sim->mechanics, "plant, rigid, modal or explicit; auto likewise");
  simulate->add_option("--accuracy", sim->accuracy,
                       "wanted error of the touch time, such as 1%; [wanted] of the plan says more");
  simulate->add_option("--cache", sim->cache, "folder for field tables; made if missing")
      ->capture_default_str();
  simulate->add_option("--volts", sim->volts, "solenoid: supply, V; 24 if left out");
  simulate->add_option("--hertz", sim->hertz, "solenoid: of a rectified supply; 50 if left out");
  simulate->add_option("--coil", sim->coil_degC, "solenoid: coil temperature, degC; 20 if left out");
  simulate->add_option("--hold", sim->hold_ms, "solenoid: switch off after so many ms; never if left out");
  simulate->add_option("--duration", sim->duration_ms, "solenoid: ms to simulate; 100 if left out");
  simulate->add_option("-o,--output", sim->output,
                       "solenoid: .csv or .svg of voltage, current, position, force");
  simulate->add_flag("--nominal", sim->nominal,
                     "under the conditions the plan asks for; without it those the measured closings had");
  add_shard_options(simulate, sim->shards, "closing of the plan");
  simulate->add_flag("--json", sim->json, "summary as JSON to stdout");
  add_progress(simulate, sim->progress);
}

void add_result_verbs(CLI::App& app) {
  auto list = std::make_shared<ResultArgs>();
  add_result_options(verb(app, "campaigns", "List the campaigns in a store", list, list_campaigns), *list);
  auto shots = std::make_shared<ResultArgs>();
  add_result_options(verb(app, "shots", "List the shots of a campaign: angle reached, touch, bounce, outcome",
                          shots, list_shots),
                     *shots);
  auto shown = std::make_shared<ShotArgs>();
  CLI::App* one =
      verb(app, "show", "One shot: what was asked, by whom it was made, what came out", shown, show_shot);
  one->add_option("shot", shown->shot, "shot id, as `powbench shots` lists it")->required();
  add_result_options(one, *shown);
  auto drawn = std::make_shared<ShotArgs>();
  CLI::App* plot =
      verb(app, "plot", "Draw the channels of a shot, with the simulation of its angle", drawn, plot_shot);
  plot->add_option("shot", drawn->shot, "shot id, as `powbench shots` lists it")->required();
  plot->add_option("-o,--output", drawn->file, "picture to write, .svg or .html; shot-ID.svg if left out");
  add_result_options(plot, *drawn);
  auto note = std::make_shared<AnnotateArgs>();
  CLI::App* annotated = verb(
      app, "annotate", "Complete a campaign's test record; without KEY list what was added", note, annotate);
  annotated->add_option(
      "key", note->key,
      "customer, order, device, serial, rating, standard, operator, recorded, source, remarks or instrument");
  annotated->add_option(
      "text", note->text,
      "its text; of an instrument \"NAME; CERTIFICATE; LAST DAY\", the last as 2030-12-31 or left out");
  add_result_options(annotated, *note);
  auto events = std::make_shared<EventsArgs>();
  CLI::App* show =
      verb(app, "events", "Extract the events of a stored shot or of a waveform file", events, show_events);
  show->add_option(
          "shot", events->shot,
          "shot id, as `powbench campaigns --json` and the report list it; or a CSV file, see `powbench "
          "import --help`")
      ->required();
  show->add_option("--calibration", events->calibration, "calibration file of a CSV file");
  show->add_option(
          "--force-percent", events->force_percent,
          "lab rule: closed above this share of the settled force, instead of where the force leaves zero")
      ->check(CLI::Range(0.1, 99.0));
  show->add_option("--voltage-percent", events->voltage_percent,
                   "lab rule: open above this share of the open-circuit contact voltage (50)")
      ->check(CLI::Range(1.0, 99.0));
  show->add_option("--min-opening-us", events->min_opening_us, "lab rule: shorter openings count as closed")
      ->check(CLI::Range(0.0, 1e5));
  show->add_option(
      "--filter", events->filter,
      "of the force before events are looked for: none, plain (low-pass where the vibration leaves "
      "room for one), lowpass:2kHz or bandstop:3.1kHz..3.6kHz");
  show->add_option(
      "--phase", events->phase,
      "of the filter: zero (forward and backward) or causal (its delay is taken out of the times)");
  show->add_option("--band", events->band,
                   "where core vibration is looked for and modelled, such as 800Hz..18kHz (the default)");
  show->add_flag(
      "--stream", events->stream,
      "as the samples come in: each touch, release and seat as soon as it is known, with its latency");
  show->add_option(
      "--picture", events->picture,
      "SVG to write: the force as it came and as events were taken from it, in time and frequency");
  show->footer(
      "Without --filter the vibration is taken out by a model fitted to the record, and no filter is "
      "applied. A "
      "filter moves "
      "edges: what it adds to u, what it leaves of the vibration and what it takes from the shortest contact "
      "are printed "
      "with the events. One that takes more than -20 dB (a hundredth) of that contact's energy is refused.\n"
      "  powbench events 7 --filter bandstop:14kHz..16kHz --phase causal");
  add_result_options(show, *events);
  auto comparison = std::make_shared<CompareArgs>();
  CLI::App* compared = verb(app, "compare", "Measured beside simulated beside published; or two campaigns",
                            comparison, compare_campaigns);
  compared->add_option("campaigns", comparison->pair, "two campaign ids: the second against the first")
      ->expected(2);
  add_result_options(compared, *comparison);
  auto report = std::make_shared<ReportArgs>();
  CLI::App* write =
      verb(app, "report", "Write report (HTML, PDF) and JUnit XML of a campaign", report, write_report);
  add_result_options(write, *report);
  write->add_option("-o,--output", report->folder, "folder to write into; made if missing")
      ->capture_default_str();
  write->add_flag("--pdf", report->pdf, "print report.pdf too, with an installed Chromium");
  auto exported = std::make_shared<ExportArgs>();
  CLI::App* out =
      verb(app, "export", "Write shots for other programs: waveforms of one, events of a campaign", exported,
           export_shot);
  out->add_option("shot", exported->shot, "shot id; left out for the events of a campaign (arrow, xlsx)");
  add_result_options(out, *exported);
  out->add_option("--to", exported->to, "format; left out: as the file's extension says, else csv")
      ->check(CLI::IsMember({"csv", "nc", "comtrade", "xlsx", "arrow", "vtu", "gltf"}));
  out->add_option("-o,--output", exported->file, "file; stdout if left out (csv). vtu, gltf: folder");
  out->footer(
      "csv        waveforms as text, with a calibration file beside: powbench import reads both back\n"
      "nc         waveforms as netCDF-4 (HDF5): xarray.open_dataset\n"
      "comtrade   waveforms as x.cfg and x.dat, for relay test sets and fault recorders\n"
      "xlsx       waveforms and contacts of a shot, or without a shot the events and contacts of a campaign\n"
      "arrow      events of a campaign as Arrow IPC: polars.read_ipc, pyarrow, apache-arrow of npm\n"
      "vtu, gltf  motion and stress of the shot's closing, simulated once more");
  out->add_option("--cell-mm", exported->cell_mm, "vtu, gltf: largest cell of the bodies")
      ->capture_default_str();
  out->add_option("--scale-masses-ns", exported->scale_masses_ns,
                  "vtu, gltf: thin cells get inertia against deformation up to this step, ns");
  out->add_option("--end-ms", exported->end_ms, "vtu, gltf: end of the closing")->capture_default_str();
}

void add_import_verb(CLI::App& app) {
  auto args = std::make_shared<ImportArgs>();
  CLI::App* in = verb(app, "import", "Store anyone's waveform as a shot", args, import_waveform_file);
  in->add_option("file", args->file,
                 "waveform file: CSV of an oscilloscope or logger, .lvm, .tdms, .mat, .wvf or .hdr, COMTRADE "
                 "(.cfg, .cff), .wav")
      ->required();
  in->add_flag("--suggest", args->suggest,
               "store nothing: print the calibration file that the columns suggest, and why");
  in->add_option("-o,--output", args->output, "with --suggest: file to write it to");
  in->add_flag("--overwrite", args->overwrite, "with --suggest: replace a file that is there already");
  in->add_option("--calibration", args->calibration,
                 "calibration file (TOML); FILE.toml beside FILE.csv if left out");
  in->add_option("--db", args->database, "store to write; made if missing")->capture_default_str();
  in->add_flag("--json", args->json, "JSON to stdout");
  in->footer(import_footer);
}

void add_study_verbs(CLI::App& app) {
  auto tables = std::make_shared<TablesArgs>();
  CLI::App* show = verb(app, "tables", "The published tables against this simulator, errors recomputed",
                        tables, show_tables);
  show->add_option("--specimen", tables->specimen_file,
                   "specimen file (TOML); scenes/published.specimen.toml if left out");
  show->add_option("--fit", tables->fit_file, "fit file of `powbench fit`: its held-out predictions");
  show->add_flag("--pressure", tables->pressure,
                 "the statements on contact pressure beside two simulated trains");
  show->add_flag("--json", tables->json, "JSON to stdout");
  auto field_args = std::make_shared<FieldArgs>();
  CLI::App* field = verb(app, "field", "The magnet's potential by finite elements: table and pictures",
                         field_args, show_field);
  field->add_option(
      "specimen", field_args->specimen_file,
      "specimen file (TOML); the reference contactor if left out. Its [shape] is an E-core, with legs = 2 "
      "a U-core, with closed_leg = 1 too a C-core; or a solenoid, kind = \"solenoid\". Or a drawing "
      "(x.magnet.toml): any magnet on a mesh of gmsh");
  field->add_option("-o,--output", field_args->folder, "folder for table and pictures; made if missing")
      ->capture_default_str();
  field->add_option("--accuracy", field_args->accuracy, "relative error of current and pull")
      ->capture_default_str();
  field->add_option("--steel", field_args->steel,
                    "built-in steel or B-H sheet (CSV) in place of the specimen's");
  field->add_flag("--ring", field_args->ring, "the shading ring as a third variable");
  field->add_option(
      "--mesh", field_args->mesh_file,
      "plane mesh of gmsh (MSH 2.2 or 4.1) in place of the specimen's shape: one state at --current");
  field->add_option("--mesh-unit", field_args->mesh_unit, "of the mesh's coordinates: mm, m or in")
      ->capture_default_str();
  field->add_option("--current", field_args->current, "A in the coil, with --mesh or of a solenoid")
      ->default_str("0.3");
  field->add_flag("--symmetric", field_args->symmetric, "the mesh is one half of the device");
  field->add_flag(
      "--ends", field_args->ends,
      "with the ends of stack and coil, and with --ring of the ring, from three dimensions: minutes with it");
  field->add_option(
      "--out", field_args->tables,
      "table of flux linkage and force over current and position; FILE.csv, FILE.mat (Simscape and "
      "Modelica) or FILE.txt (Modelica); may be repeated");
  field
      ->add_option("--largest-current", field_args->largest_current,
                   "A, end of the tables of --out; 0: of the open core at the largest flux computed")
      ->check(CLI::Range(0.0, 1e4))
      ->capture_default_str();
  field->add_option("-j,--threads", field_args->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_shard_options(field, field_args->shards, "group of four gaps of the table with all their fluxes");
  field->add_flag("--json", field_args->json, "JSON to stdout");
  auto steel_args = std::make_shared<SteelArgs>();
  CLI::App* steel =
      verb(app, "steel", "A steel's B-H curve: checked, smoothed, with a picture; alone: the list",
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
  all->add_option("--rig", args->rig, "another rig than the simulated one")->capture_default_str();
  add_progress(all, args->progress);
}

int leave(Exit code) {
  return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "powbench: point-on-wave test bench for AC contactors.\n"
      "Fires closings at commanded angles of the mains, extracts touch and bounce from the records, "
      "simulates the same\n"
      "conditions and lays both side by side.\n\n"
      "Start with:  powbench demo                      everything once, without hardware\n"
      "             powbench plan template plan        a commented plan to edit\n"
      "             powbench run PLAN --rig sim: --db lab.db   acquire;  then sim, compare, report"};
  app.name("powbench");
  app.set_version_flag("--version", fmt::format("powbench {}, commit {}", program_version, program_commit));
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 pass or nothing to judge, 1 not passed: outside limits, accuracy missed or shots "
      "missing,\n"
      "            2 bad input, 3 rig or database server unreachable or at fault, 4 time-out, 5 data "
      "damaged,\n"
      "            6 interlock, 7 accuracy not known, 130 interrupted");
  add_rig_verbs(app);
  add_live_verb(app);
  add_plan_verbs(app);
  add_result_verbs(app);
  add_import_verb(app);
  add_db_verbs(app);
  add_study_verbs(app);
  add_fit_verb(app);
  add_sweep_verb(app);
  add_ladder_verb(app);
  add_fmu_verb(app);
  add_manual_verbs(app);
  add_specimen_verbs(app);

  app.failure_message(parse_failure);
  const auto ended = [](Exit exit, const std::string& text) {
    fmt::print(stderr, "{}\n", text);
    return leave(exit);
  };
  if (const auto wrong = unknown_verb(app, argc, argv); !wrong.empty()) return ended(Exit::bad_input, wrong);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? leave(Exit::pass) : leave(Exit::bad_input);
  }
  try {
    return leave(chosen()());
  } catch (const BadInput& e) {
    return ended(Exit::bad_input, e.what());
  } catch (const WrongStore& e) {
    return ended(Exit::bad_input, fmt::format("powbench: {}", e.what()));
  } catch (const StoreError& e) {
    return ended(Exit::data_damaged, fmt::format("powbench: {}", e.what()));
  } catch (const rigs::UnknownRig& e) {
    return ended(Exit::bad_input, fmt::format("powbench: {}", e.what()));
  } catch (const rigs::RigError& e) {
    return ended(Exit::rig_fault, fmt::format("powbench: {}", e.what()));
  } catch (const std::filesystem::filesystem_error& e) {
    return ended(Exit::bad_input,
                 fmt::format("powbench: {}: {}; name another place", e.path1().string(), e.code().message()));
  } catch (const std::exception& e) {
    return ended(Exit::bad_input, fmt::format("powbench: {}", e.what()));
  }
}
