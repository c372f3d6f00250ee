#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "rigs/registry.h"
#include "rigs/rig_watch.h"

/// powbench stop: the coil of any rig off, from any terminal.

namespace powbench::host {

namespace {

constexpr std::chrono::milliseconds connect_time{1500};
constexpr std::chrono::seconds stop_time{2};

}  // namespace

Exit stop_rig(const InfoArgs& args) {
  const auto begun = std::chrono::steady_clock::now();
  if (args.uri.starts_with("sim:") || args.uri.starts_with("qemu:"))
    throw BadInput(
        {fmt::format("{} lives and ends inside the program that uses it, so there is none to stop from "
                     "here; Ctrl-C stops that program",
                     args.uri)});
  std::optional<rigs::RigStatus> off;
  std::string why;
  rigs::Endpoint place;
  std::unique_ptr<rigs::RigWatch> line;
  while (!off && std::chrono::steady_clock::now() - begun < stop_time) {
    try {
      if (!line) {
        place = rigs::endpoint_to_stop(args.uri);
        line = std::make_unique<rigs::RigWatch>(place.uri, connect_time);
      }
      line->stop();
      if (const rigs::RigStatus seen = line->status(); rigs::coil_off(seen.state))
        off = seen;
      else
        why = "it has taken the command, and its state is '" + seen.state + "'";
    } catch (const rigs::RigError& e) {
      line.reset();
      why = e.what();
    }
    if (!off) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
  const bool owned = off && !off->owner.empty() && off->owner != "free";
  if (args.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"off", off.has_value()},
                                              {"state", off ? off->state : ""},
                                              {"owner", owned ? off->owner : ""},
                                              {"error", off ? "" : why},
                                              {"ms", ms}}
                           .dump(2));
  else if (off)
    fmt::print("{}: coil off, confirmed by the rig (its state: {}), {:.0f} ms\n", args.uri, off->state, ms);
  if (!off) {
    fmt::print(
        stderr,
        "powbench: {}: NOT CONFIRMED, THE COIL MAY BE ON: {}\nSwitch the supply of the coil off by hand.\n",
        args.uri, why);
    return Exit::rig_fault;
  }
  if (off->state == "fault" && !args.json)
    fmt::print("fault {} remains: {}\n", off->fault, rigs::advice(off->last_error));
  if (owned)
    fmt::print(stderr,
               "{} owns the rig; a program of theirs that still runs may fire the next shot: end it too\n",
               off->owner);
  return Exit::pass;
}

}  // namespace powbench::host
