#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/firmware_cost.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "rigs/qemu_board.h"
#include "rigs/registry.h"
#include "rigs/sim_world.h"

/// The firmware on the emulated Cortex-M4F: what it costs (instructions, memory; exact and the same
/// everywhere) and how fast the lock-step runs (of this machine).
/// Usage: bench_emulated_board [--json PATH] [--baseline PATH]; the latter writes the cost alone, the limit that
/// a test holds.

namespace {

using namespace powbench;

double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Row {
  std::string name, unit;
  double median, low, high;
};

template <class F>
Row row(std::string name, std::string unit, int repeats, F&& once) {
  std::vector<double> v;
  for (int i = 0; i < repeats; ++i) v.push_back(once(i));
  std::sort(v.begin(), v.end());
  return {std::move(name), std::move(unit), v[v.size() / 2], v[v.size() / 4], v[v.size() * 3 / 4]};
}

/// Samples a second of 8 channels through the board alone, in blocks of 10: no plant.
Row exchange_rate(bool count_instructions, std::size_t batch) {
  firmware::ControllerConfig config;
  rigs::QemuBoard board(count_instructions, config, {"bench", "model", "serial", "0", "specimen"});
  board.adopt_thread();
  std::vector<std::int16_t> scans(10 * channel_count);
  std::vector<firmware::GateEdge> edges;
  std::int64_t sample = 0;
  return row(fmt::format("lock-step, {} block{} of 10 in a frame{}", batch, batch == 1 ? "" : "s",
                         count_instructions ? ", -icount" : ""),
             "kS/s", 21, [&](int) {
               const double start = wall();
               std::int64_t done = 0;
               std::vector<firmware::Block> blocks(batch);
               while (done < 20'000) {
                 for (auto& block : blocks) {
                   block = {.first_sample = sample, .scans = scans};
                   sample += 10, done += 10;
                 }
                 board.step(blocks, edges);
               }
               return 1e-3 * static_cast<double>(done) / (wall() - start);
             });
}

/// The same in samples a second of processor time, of both sides together: what one core to itself would do.
Row exchange_cost(bool count_instructions) {
  firmware::ControllerConfig config;
  rigs::QemuBoard board(count_instructions, config, {"bench", "model", "serial", "0", "specimen"});
  board.adopt_thread();
  std::vector<std::int16_t> scans(10 * channel_count);
  std::vector<firmware::GateEdge> edges;
  std::int64_t sample = 0;
  return row(fmt::format("lock-step, a second of processor time{}", count_instructions ? ", -icount" : ""),
             "kS/s", 5, [&](int) {
               const double start = process_cpu_seconds() + board.processor_seconds();
               const std::int64_t first = sample;
               do {
                 for (int i = 0; i < 1000; ++i) {
                   const firmware::Block block{.first_sample = sample, .scans = scans};
                   sample += 10;
                   board.step({&block, 1}, edges);
                 }
               } while (process_cpu_seconds() + board.processor_seconds() - start < 0.5);
               return 1e-3 * static_cast<double>(sample - first) /
                      (process_cpu_seconds() + board.processor_seconds() - start);
             });
}

/// Wall-clock time of a whole shot (warm-up, gate, 100 ms on-time, read-out) through libiio.
Row shot_time(const std::string& uri) {
  const auto rig = rigs::open(uri, {}, {});
  return row("shot with 100 ms on-time through libiio, " + uri, "s", 21, [&](int i) {
    Conditions c;
    c.closing_angle = radians(30.0 * (i % 7));
    c.seed = static_cast<std::uint64_t>(i) + 1;
    c.hold_time = 0.100;
    const double start = wall();
    if (rig->fire(c, std::chrono::seconds(20)).outcome != Outcome::pass)
      throw rigs::RigError("a shot failed");
    return wall() - start;
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::string json, baseline;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json = argv[i + 1];
    if (std::strcmp(argv[i], "--baseline") == 0) baseline = argv[i + 1];
  }
  try {
    nlohmann::ordered_json cost_list, list = nlohmann::ordered_json::array();
    fmt::print("{:<52} {:>10} {:>13}\n", "", "measured", "budget");
    for (const bench::CostRow& c : bench::measure_firmware_cost()) {
      const std::string budget =
          c.budget > 0 ? fmt::format("{:.0f} {}", c.budget, c.value <= c.budget ? "kept" : "MISSED") : "-";
      fmt::print("{:<52} {:>10.1f} {:>13}  {}\n", c.name, c.value, budget, c.unit);
      cost_list[c.name] = std::round(c.value * 10) / 10;
      list.push_back({{"what", c.name}, {"unit", c.unit}, {"value", c.value}});
      if (c.budget > 0) list.back()["budget"] = c.budget;
    }
    if (!baseline.empty()) {
      std::ofstream(baseline) << cost_list.dump(2) << "\n";
      return 0;
    }
    fmt::print("{:<52} {:>10} {:>10} {:>10}\n", "", "median", "quartile", "quartile");
    for (const Row& r : {exchange_rate(false, 1), exchange_rate(false, 20), exchange_rate(true, 1),
                         exchange_cost(false), exchange_cost(true), shot_time("sim:"), shot_time("qemu:")}) {
      fmt::print("{:<52} {:>10.4g} {:>10.4g} {:>10.4g}  {}\n", r.name, r.median, r.low, r.high, r.unit);
      list.push_back(
          {{"what", r.name}, {"unit", r.unit}, {"median", r.median}, {"low", r.low}, {"high", r.high}});
    }
    if (!json.empty()) std::ofstream(json) << list.dump(2) << "\n";
  } catch (const rigs::RigError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 3;
  }
  return 0;
}
