#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>

#include "bench/link/link_trials.h"
#include "bench/link/plain_client.h"
#include "rigs/iiod_server.h"
#include "rigs/sim_world.h"

/// Owners that vanish, and clients that take more than their share.

namespace powbench::bench {
namespace {

using Clock = std::chrono::steady_clock;

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// ---- owners that vanish ----

/// The board without sockets, so that a connection ends at an instant of virtual time.
struct Rig {
  Rig() : world({}, {}) {}
  std::string ask(unsigned connection, const std::string& request) {
    std::string out;
    std::span<const std::uint8_t> rest(reinterpret_cast<const std::uint8_t*>(request.data()), request.size());
    while (!rest.empty()) {
      const auto answer = world.board().feed(connection, rest);
      out.append(answer.bytes.begin(), answer.bytes.end());
      rest = rest.subspan(answer.used);
      world.notice_commands();
      if (answer.used == 0) break;
    }
    return out;
  }
  void write(unsigned connection, const std::string& attribute, const std::string& value) {
    ask(connection, "WRITE iio:device1 " + attribute + " " + std::to_string(value.size()) + "\r\n" + value);
  }
  rigs::SimWorld world;
};

VanishRow vanish(const std::string& state, int spectators) {
  constexpr unsigned owner = 0;
  constexpr std::int64_t lease_ms = 5000;
  Rig rig;
  const auto& report = [&rig]() -> const firmware::BenchReport& { return rig.world.board().report(); };
  for (int s = 1; s <= spectators; ++s) rig.ask(static_cast<unsigned>(s), "READ iio:device1 state\r\n");
  rig.write(owner, "lease", "t " + std::to_string(lease_ms) + " owner");
  rig.write(owner, "hold_time_ms", "10000 t");
  if (state != "idle") rig.write(owner, "arm", "1 t");
  if (state == "waiting for the angle" || state == "energised") rig.write(owner, "fire", "1 t");
  if (state == "energised")
    while (!report().gate_on) rig.world.run(0.001);
  rig.world.board().close(owner);

  VanishRow row{.state = state, .spectators = spectators, .off = false, .virtual_ms = 0};
  for (int passed = 0; rig.world.busy() && passed < 20'000; ++passed) {
    for (int s = 1; s <= spectators; ++s) rig.ask(static_cast<unsigned>(s), "READ iio:device1 state\r\n");
    if (report().gate_on) row.virtual_ms += 1;
    rig.world.run(0.001);
  }
  rig.world.board().rest(lease_ms);
  row.off = !report().gate_on && !report().lease_held && report().state != firmware::State::armed &&
            report().state != firmware::State::firing;
  return row;
}

}  // namespace

std::vector<VanishRow> vanishing_owners() {
  std::vector<VanishRow> rows;
  for (const char* state : {"idle", "armed", "waiting for the angle", "energised"})
    for (const int spectators : {0, 1, 15}) rows.push_back(vanish(state, spectators));
  return rows;
}

ServerRow server_under_attack(int connections, int flood_megabytes) {
  ServerRow row;
  rigs::LocalRig server({}, {});
  const auto visit = [&] { PlainClient(server.address()).read("iio:device1 state"); };
  for (int i = 0; i < 200; ++i) visit();
  double before = resident_mb();
  for (int i = 0; i < connections; ++i) visit();
  row.connections = connections;
  row.connections_growth_mb = resident_mb() - before;

  before = resident_mb();
  const std::string junk(1 << 16, '\n');
  for (double sent = 0; sent < flood_megabytes;) {
    // one client after the other, as each is cut off
    const PlainClient flooder(server.address());
    flooder.say("OPEN iio:device0 16 00000001\r\nREADBUF iio:device0 32\r\n");
    double mine = 0;
    while (flooder.say(junk) && mine < flood_megabytes) mine += static_cast<double>(junk.size()) / 1e6;
    sent += mine + 0.065;
    row.flood_mb = sent;
  }
  row.flood_growth_mb = resident_mb() - before;

  std::vector<std::unique_ptr<PlainClient>> slow;
  for (unsigned i = 0; i < firmware::Bench::max_connections; ++i) {
    slow.push_back(std::make_unique<PlainClient>(server.address()));
    slow.back()->say("READ iio:dev");
  }
  const auto start = Clock::now();
  for (std::string state; state != "idle" && Clock::now() - start < std::chrono::seconds(60);)
    state = PlainClient(server.address()).read("iio:device1 state");
  row.slow_lines_wait_s = std::chrono::duration<double>(Clock::now() - start).count();
  return row;
}

}  // namespace powbench::bench
