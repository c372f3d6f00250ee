#include "rigs/interlock_list.h"

#include <sstream>

#include "firmware/faults.h"
#include "rigs/rig_watch.h"

namespace powbench::rigs {
namespace {

std::string words(firmware::Reaction r) {
  using firmware::Reaction;
  switch (r) {
    case Reaction::gate_off:
      return "coil off";
    case Reaction::open_relay:
      return "coil off, relay open";
    case Reaction::withhold:
      return "not switched on yet";
    case Reaction::refuse:
      return "command refused";
    case Reaction::next_crossing:
      return "switched on at the next crossing";
    case Reaction::mark_record:
      return "coil stays off; once on: record marked";
  }
  return "";
}

std::string words(firmware::Watch w) {
  using firmware::Watch;
  return w == Watch::shot      ? "in a shot"
         : w == Watch::always  ? "always"
         : w == Watch::command ? "at a command"
                               : "at start";
}

std::string words(firmware::Clears c) {
  using firmware::Clears;
  return c == Clears::nothing ? "does not latch" : c == Clears::acknowledge ? "abort" : "abort, cause gone";
}

std::string limit_text(int us) {
  if (us == 0) return "at once";
  std::ostringstream out;
  if (us < 1000)
    out << us << " us";
  else
    out << us / 1000.0 << " ms";
  return out.str();
}

}  // namespace

std::vector<InterlockLine> interlock_list() {
  std::vector<InterlockLine> list;
  for (const auto& f : firmware::fault_table)
    list.push_back({static_cast<int>(f.fault), std::string(f.name), std::string(f.detection),
                    words(f.reaction), limit_text(f.limit_us), words(f.watch), words(f.clears),
                    advice(std::string(f.reason))});
  return list;
}

bool may_try_again(int fault) {
  using firmware::Fault;
  for (const Fault f : {Fault::mains_lost, Fault::phase_invalid, Fault::samples_lost, Fault::host_lost,
                        Fault::sensor_implausible, Fault::phase_stale})
    if (fault == static_cast<int>(f)) return true;
  return false;
}

}  // namespace powbench::rigs
