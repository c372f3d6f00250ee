#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/link/link_trials.h"

/// The table of the link: what becomes of shots when the line or another host misbehaves.
/// Usage: bench_link_faults [--tcp N] [--serial N] [--schedules N] [--connections N] [--flood MB] [--seed N] [--json
/// PATH] A part with 0 is left out. Ends with 1 when anything happened that must not.

namespace {

using namespace powbench::bench;
using Json = nlohmann::ordered_json;

struct Arguments {
  int tcp = 600, serial = 80, schedules = 50, connections = 2000, flood = 64;
  std::uint64_t seed = 1;
  std::string json;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i], value = argv[i + 1];
    const auto number = [&](auto& to) { std::from_chars(value.data(), value.data() + value.size(), to); };
    if (key == "--tcp") number(a.tcp);
    if (key == "--serial") number(a.serial);
    if (key == "--schedules") number(a.schedules);
    if (key == "--connections") number(a.connections);
    if (key == "--flood") number(a.flood);
    if (key == "--seed") number(a.seed);
    if (key == "--json") a.json = value;
  }
  return a;
}

/// Prints the rows with their sum; the number of things that must not happen.
int print_faults(const char* title, const std::vector<FaultRow>& rows, Json& json) {
  fmt::print("\n{}\n{:<10} {:<8} {:>6} {:>6} {:>7} {:>8} {:>8} | {:>6} {:>5} {:>5} {:>5} {:>9}\n", title,
             "fault", "towards", "tried", "struck", "same", "fetched", "reported", "silent", "lost", "twice",
             "late", "longest s");
  FaultRow sum;
  const auto line = [](const std::string& kind, const char* towards, const FaultRow& r) {
    fmt::print("{:<10} {:<8} {:>6} {:>6} {:>7} {:>8} {:>8} | {:>6} {:>5} {:>5} {:>5} {:>9.2f}\n", kind,
               towards, r.tried, r.struck, r.same, r.fetched, r.reported, r.silent, r.lost, r.twice, r.late,
               r.longest);
  };
  for (const FaultRow& r : rows) {
    line(name(r.kind), r.to_rig ? "rig" : "host", r);
    sum += r;
    json.push_back({{"fault", name(r.kind)},
                    {"towards", r.to_rig ? "rig" : "host"},
                    {"tried", r.tried},
                    {"struck", r.struck},
                    {"same", r.same},
                    {"fetched", r.fetched},
                    {"reported", r.reported},
                    {"silent", r.silent},
                    {"lost", r.lost},
                    {"twice", r.twice},
                    {"late", r.late},
                    {"longest_s", r.longest}});
  }
  line("all", "", sum);
  for (const auto& [reason, times] : sum.reasons) fmt::print("reported {:>5} times: {}\n", times, reason);
  for (const std::string& sentence : sum.wrong) fmt::print("{}\n", sentence);
  return sum.silent + sum.lost + sum.twice + sum.late;
}

Progress progress(const char* what) {
  return [what](int done, int of) {
    if (done % std::max(of / 20, 1) == 0) fmt::print(stderr, "{} {} of {}\n", what, done, of);
  };
}

int print_two_hosts(const Arguments& a, Json& json) {
  const InterleavingRow two = interleavings(a.schedules, a.seed, progress("schedules"));
  fmt::print("\nTwo hosts, seed {}: {} schedules, {} shots: {} own records, {} refused, {} foreign records\n",
             a.seed, two.schedules, two.shots, two.own, two.refused, two.foreign);
  json["two_hosts"] = {{"schedules", two.schedules},
                       {"shots", two.shots},
                       {"own", two.own},
                       {"refused", two.refused},
                       {"foreign", two.foreign}};
  return two.foreign;
}

int print_vanishing(Json& json) {
  int wrong = 0;
  fmt::print("\nOwner vanishes (hold time 10 s, lease 5 s)\n{:<22} {:>10} {:>12} {:>20}\n", "state",
             "spectators", "off, disarmed", "gate on after it, ms");
  for (const VanishRow& r : vanishing_owners()) {
    fmt::print("{:<22} {:>10} {:>12} {:>20.0f}\n", r.state, r.spectators, r.off ? "yes" : "NO", r.virtual_ms);
    wrong += r.off && r.virtual_ms <= 252 ? 0 : 1;
    json["vanishing_owner"].push_back(
        {{"state", r.state}, {"spectators", r.spectators}, {"off", r.off}, {"gate_on_ms", r.virtual_ms}});
  }
  return wrong;
}

void print_server(const Arguments& a, Json& json) {
  const ServerRow s = server_under_attack(a.connections, a.flood);
  fmt::print(
      "\nServer\n{} connections one after the other: resident set {:+.1f} MB\n"
      "{:.0f} MB behind a pending READBUF: resident set {:+.1f} MB\n"
      "16 half-typed lines: a new client is served after {:.2f} s\n",
      s.connections, s.connections_growth_mb, s.flood_mb, s.flood_growth_mb, s.slow_lines_wait_s);
  json["server"] = {{"connections", s.connections},
                    {"connections_growth_mb", s.connections_growth_mb},
                    {"flood_mb", s.flood_mb},
                    {"flood_growth_mb", s.flood_growth_mb},
                    {"slow_lines_wait_s", s.slow_lines_wait_s}};
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments a = parse(argc, argv);
  Json json;
  int wrong = 0;
  fmt::print("bench_link_faults");
  for (int i = 1; i < argc; ++i) fmt::print(" {}", argv[i]);
  fmt::print(
      "\n\nsame: complete at once, equal to the undisturbed shot; fetched: the same after the rig had been "
      "lost;\n"
      "reported: no record, and said so. Right of the bar: what must not happen. Deadline of a shot {:.1f} "
      "s\n",
      trial_deadline());
  if (a.tcp > 0) wrong += print_faults("TCP", tcp_faults(a.tcp, a.seed, progress("tcp")), json["tcp"]);
  if (a.serial > 0)
    wrong += print_faults("serial, 2 Mbaud, through the bridge",
                          serial_faults(a.serial, a.seed, progress("serial")), json["serial"]);
  if (a.schedules > 0) wrong += print_two_hosts(a, json);
  if (a.connections > 0) {
    wrong += print_vanishing(json);
    print_server(a, json);
  }
  fmt::print("\n{} events that must not happen\n", wrong);
  if (!a.json.empty()) std::ofstream(a.json) << json.dump(1) << '\n';
  return wrong == 0 ? 0 : 1;
}
