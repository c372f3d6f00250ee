// What a closing on a table costs: 40 ms in steps of 10 us, and the steps one by one as a rig in the loop would see
// them.
//   fields_transient [--json PATH]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/fields/json_out.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

/// A closing on a table, 4000 steps of 10 us: implicit midpoint rule, mechanics included. The cheapest of a few, and
/// every step by itself, as a rig in the loop would see it.
Json transient(const char* name, const sim::MagneticPotential& p) {
  sim::TransientSetup s;
  s.resistance = 250;
  s.ring_resistance = 0.6e-3;
  s.mass = 0.12;
  s.counter_force = [](double gap) { return 10 - 1500 * gap; };
  s.start_gap = 4e-3;
  s.step = 10e-6;
  s.duration = 40e-3;
  using Clock = std::chrono::steady_clock;
  constexpr int rounds = 30;
  const auto steps = static_cast<std::size_t>(std::lround(s.duration / s.step));
  std::vector<double> least(steps,
                            1e300);  // of a step over the rounds: what others take of the machine drops out
  Clock::time_point last;
  std::vector<double> taken;
  s.voltage = [&](double t) {  // asked once a step
    const auto now = Clock::now();
    taken.push_back(std::chrono::duration<double>(now - last).count());
    last = now;
    return 325.27 * std::sin(2 * pi * 50 * t + 1);
  };
  double best = 1e300;
  for (int round = 0; round < rounds; ++round) {
    taken.clear();
    const double start = process_cpu_seconds();
    run_transient(p, s);
    best = std::min(best, process_cpu_seconds() - start);
    for (std::size_t k = 1; k < taken.size(); ++k) least[k] = std::min(least[k], taken[k]);
  }
  const double worst = *std::max_element(least.begin() + 1, least.end());
  std::printf("%-28s %10.3f %12.3f %12.3f\n", name, best * 1e3, best / static_cast<double>(steps) * 1e6,
              worst * 1e6);
  return {{"table", name},
          {"cpu_ms", best * 1e3},
          {"mean_step_us", best / static_cast<double>(steps) * 1e6},
          {"worst_step_us", worst * 1e6}};
}

Json transients() {
  std::printf("40 ms of a closing on a table, steps of 10 us\n%-28s %10s %12s %12s\n", "", "CPU ms",
              "mean us/step", "worst us/step");
  sim::TableOptions plain, ring;
  plain.accuracy = ring.accuracy = 0.01;
  plain.psi_nodes = plain.gap_nodes = ring.psi_nodes = ring.gap_nodes = 20;
  ring.ring_nodes = 12;
  plain.ring = false;
  sim::Team team(2);
  Json list = Json::array();
  list.push_back(
      transient("two variables", sim::TablePotential(build_table(sim::MagnetDesign{}, plain, team))));
  list.push_back(transient("with ring", sim::TablePotential(build_table(sim::MagnetDesign{}, ring, team))));
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::write_json(argc, argv, {{"benchmark", "fields_transient"}, {"rows", transients()}});
}
