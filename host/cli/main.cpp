#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <system_error>

#include "core/memory.h"
#include "host/cli/commands.h"
#include "host/cli/manual.h"
#include "host/cli/not_a_number.h"
#include "host/cli/program.h"
#include "host/cli/unknown_verb.h"
#include "host/config/bad_input.h"
#include "host/store/store.h"
#include "rigs/rig.h"

/// The command line: words to arguments, exceptions to sentences and exit codes. The work is in the verbs.

namespace {

using namespace powbench;
using namespace powbench::host;

int leave(Exit code) {
  return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  CLI::App app{
      "powbench: point-on-wave test bench for AC contactors.\n"
      "Fires closings at commanded angles of the mains, extracts touch and bounce from the records, "
      "simulates the same\n"
      "conditions and compares both.\n\n"
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
  for (const auto add : verb_files) add(app);

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
  if (const auto wrong = not_a_number(app); !wrong.empty()) return ended(Exit::bad_input, wrong);
  try {
    const Exit exit = chosen()();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return leave(exit);
    return ended(Exit::bad_input, fmt::format("powbench: what was printed could not be written: {}",
                                              std::error_code(errno, std::generic_category()).message()));
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
