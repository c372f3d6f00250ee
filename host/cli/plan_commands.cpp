#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "host/cli/commands.h"
#include "host/cli/verbs.h"
#include "sim/models/mechanics.h"

/// Words to arguments of plans, of runs and of simulations.

namespace powbench::host {

void add_plan_verbs(CLI::App& app) {
  CLI::App* plan = app.add_subcommand("plan", "Check a plan, show its shots, print a template");
  plan->require_subcommand(1);
  auto check = std::make_shared<PlanArgs>();
  verb(*plan, "check", "Check a plan and its specimen and list every mistake", check, check_plan)
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
      "continue the newest campaign of this plan with its missing shots; start one if there is none");
  acquire->add_flag(
      "--dry-run", run->dry_run,
      "check plan, specimen and rig file, and count the shots; no rig is asked, nothing is fired");
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
      "rig file (TOML) with the sensors to simulate. For a solenoid: its supply, switch and suppression; "
      "if left out, direct current and a freewheel diode of 0.7 V");
  simulate->add_option("--db", sim->database, "store to write; made if missing")->capture_default_str();
  simulate->add_option("-j,--threads", sim->threads, "threads; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  simulate->add_option("--fields", sim->fields,
                       sim::names_of(sim::all_fields()) +
                           "; auto: as high as the accuracy needs. For a solenoid: table, solved or eddy "
                           "(solved with eddy currents)");
  simulate->add_option("--mechanics", sim->mechanics,
                       sim::names_of(sim::all_mechanics()) + ", or auto, as for --fields");
  simulate->add_option("--accuracy", sim->accuracy,
                       "allowed error of the touch time, such as 1%; see also [wanted] in the plan");
  simulate->add_option("--cache", sim->cache, "folder for field tables; made if missing")
      ->capture_default_str();
  simulate->add_option("--volts", sim->volts, "solenoid: supply, V; 24 if left out");
  simulate->add_option("--hertz", sim->hertz,
                       "solenoid: mains frequency of a rectified supply, Hz; 50 if left out");
  simulate->add_option("--coil", sim->coil_degC, "solenoid: coil temperature, degC; 20 if left out");
  simulate->add_option("--hold", sim->hold_ms,
                       "solenoid: time until switch-off, ms; not switched off if left out");
  simulate->add_option("--duration", sim->duration_ms, "solenoid: ms to simulate; 100 if left out");
  simulate->add_option("-o,--output", sim->output,
                       "solenoid: .csv or .svg of voltage, current, position, force");
  simulate->add_flag("--nominal", sim->nominal,
                     "use the conditions of the plan instead of those measured in its closings");
  add_shard_options(simulate, sim->shards, "closing of the plan");
  simulate->add_flag("--json", sim->json, "summary as JSON to stdout");
  add_progress(simulate, sim->progress);
}

}  // namespace powbench::host
