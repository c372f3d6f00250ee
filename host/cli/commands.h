#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/outcome.h"
#include "host/cli/shard.h"

/// How words become a verb with its arguments.

namespace powbench::host {

/// What was typed, to be run once everything is parsed.
inline std::function<Exit()>& chosen() {
  static std::function<Exit()> act;
  return act;
}

/// A verb that runs `act` with arguments of its own when it is the one typed.
template <class Args>
CLI::App* verb(CLI::App& parent, const char* name, const char* help, std::shared_ptr<Args> args,
               Exit (*act)(const Args&)) {
  CLI::App* app = parent.add_subcommand(name, help);
  app->callback([args, act] { chosen() = [args, act] { return act(*args); }; });
  return app;
}

/// --progress of a verb.
inline void add_progress(CLI::App* app, std::string& progress) {
  app->add_option("--progress", progress, "auto, bar, lines or none")
      ->check(CLI::IsMember({"auto", "bar", "lines", "none"}))
      ->capture_default_str();
}

/// --shard and --slurm of a verb whose points do not know of each other, and --points-db where it has no other store
/// for them. `of`: what a point is, for the help.
void add_shard_options(CLI::App*, ShardArgs&, const char* of, const char* store = "--points-db");

/// info, rigs, calibrate, rig, bridge.
void add_rig_verbs(CLI::App&);
/// serve.
void add_live_verb(CLI::App&);
/// plan, run, sim.
void add_plan_verbs(CLI::App&);
/// What reads a store.
void add_result_verbs(CLI::App&);
void add_import_verb(CLI::App&);
/// db.
void add_db_verbs(CLI::App&);
/// tables, field, steel, demo.
void add_study_verbs(CLI::App&);
void add_fit_verb(CLI::App&);
void add_sweep_verb(CLI::App&);
void add_ladder_verb(CLI::App&);
void add_fmu_verb(CLI::App&);
/// help, and the hidden verb `manual` that writes manual pages, completion and reference into a folder.
void add_manual_verbs(CLI::App&);
/// specimen describe, convert.
void add_specimen_verbs(CLI::App&);

/// All of them, in the order of the help. A new verb is a line here, its words beside its act.
inline constexpr std::array verb_files{add_rig_verbs,     add_live_verb,   add_plan_verbs,  add_result_verbs,
                                       add_import_verb,   add_db_verbs,    add_study_verbs, add_fit_verb,
                                       add_sweep_verb,    add_ladder_verb, add_fmu_verb,    add_manual_verbs,
                                       add_specimen_verbs};

}  // namespace powbench::host
