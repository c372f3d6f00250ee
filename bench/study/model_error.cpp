// How often the stated total of a closing, its distance to the next rung and the step error of that one, covers its
// difference to the best rung that can be afforded: specimens over the catalogue's bounds, angle anywhere, 0.85 .. 1.1
// of 230 V, coil at -5 .. 60 degC. Fields are the specimen's circuit, for a drawn specimen has no shape; mechanics are
// compared from rigid parts to bending ones at a quarter of the step that the estimate is made with.
//   bench_model_error [--scenes N] [--seed S] [--json PATH]

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "bench/study/coverage.h"
#include "bench/study/drawn_case.h"
#include "core/cpu_time.h"
#include "core/random.h"
#include "sim/models/mechanics.h"
#include "sim/study/parameter.h"
#include "sim/study/scene_choice.h"
#include "sim/team.h"

namespace {

namespace sim = powbench::sim;
using Json = nlohmann::ordered_json;
constexpr double duration = 0.06;  // s

/// Those that close; the others have no times to compare.
sim::Case drawn(powbench::Random& random) {
  const auto parameters = sim::catalogue_parameters();
  for (;;) {
    const sim::Case c = bench::drawn_case(random, parameters);
    if (sim::tried_closing(c.specimen, c.conditions, duration).core_seat) return c;
  }
}

}  // namespace

int main(int argc, char** argv) {
  int scenes = 200;
  std::uint64_t seed = 20261;
  std::string json;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--scenes") == 0) scenes = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--seed") == 0) seed = std::strtoull(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--json") == 0) json = argv[i + 1];
  }
  const sim::Rung rigid = sim::closing_rungs()[1], modal = sim::scene_rung(sim::circuit_field(), "modal");
  const std::vector<sim::Rung> rungs{rigid, modal};
  const auto run = [&](std::size_t rung, const sim::Case& c, double setting) {
    return sim::run_rung(rungs, rung, c, duration, setting, powbench::thread_cpu_seconds);
  };
  powbench::Random random(seed);
  struct Scene {
    sim::Case at;
    sim::LadderTimes stated{}, error{};
    double cpu = 0;
    std::string failed;
  };
  std::vector<Scene> all(static_cast<std::size_t>(scenes));
  for (Scene& s : all) s.at = drawn(random);
  sim::Team team(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  sim::for_each_index(team, scenes, [&](int k) {
    Scene& s = all[static_cast<std::size_t>(k)];
    try {
      const auto here = run(0, s.at, 1e-6), next = run(1, s.at, 0.8), finer_next = run(1, s.at, 0.4),
                 best = run(1, s.at, 0.2);
      s.stated = sim::model_difference(here, next, sim::error_estimate(next, finer_next));
      s.error = sim::time_error(here, best);
      s.cpu = here.cpu + next.cpu + finer_next.cpu + best.cpu;
    } catch (const std::runtime_error& e) {
      s.failed = e.what();
    }
  });
  std::array<bench::Coverage, 3> tally;
  double cpu = 0;
  int failed = 0;
  for (int k = 0; k < scenes; ++k) {
    const Scene& s = all[static_cast<std::size_t>(k)];
    cpu += s.cpu;
    if (!s.failed.empty()) {
      ++failed;
      std::printf("scene %d: %.100s\n", k, s.failed.c_str());
      continue;
    }
    for (std::size_t q = 0; q < tally.size(); ++q) tally[q].add(k, s.stated[q], s.error[q]);
  }
  std::printf(
      "Does the stated total of circuit+rigid (its distance to circuit+modal and the step error of that) "
      "cover its difference to circuit+modal at a quarter of the step?\n"
      "%d scenes over the catalogue's bounds, seed %llu, %.0f s CPU, %d without a result; wanted 85 .. 98 "
      "%%\n",
      scenes, static_cast<unsigned long long>(seed), cpu, failed);
  bench::print_coverage_head();
  Json rows = Json::array();
  for (std::size_t q = 0; q < tally.size(); ++q)
    rows.push_back(bench::print_coverage("circuit+rigid", sim::ladder_quantities[q], tally[q]));
  if (!json.empty())
    std::ofstream(json) << Json{{"scenes", scenes}, {"seed", seed}, {"rows", rows}}.dump(2) << "\n";
  return 0;
}
