// The rungs of a simulated closing: cost against error at every tolerance, and the calibration of the estimate of the
// error on random scenes (angle, 0.85 .. 1.1 of 230 V, coil at -5 .. 60 degC) against tolerance 1e-12. Then as many
// closings of specimens over the catalogue's bounds: whether their times converge down to 1e-11.
//   sim_ladder [--json PATH] [--svg PATH] [--scenes N] [--bending N] [--deformable N] [--threads N]
// --bending, --deformable: scenes for the rungs of bending parts (a second each) and of deformable ones (a minute).
// The picture of the documents: --svg docs/sim-ladder.svg

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>

#include "bench/study/drawn_case.h"
#include "bench/study/estimate_coverage.h"
#include "bench/study/step_convergence.h"
#include "core/cpu_time.h"
#include "core/random.h"
#include "core/units.h"
#include "host/export/ladder_svg.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/models/mechanics.h"
#include "sim/study/ladder.h"
#include "sim/study/parameter.h"

namespace {

namespace sim = powbench::sim;
using Json = nlohmann::ordered_json;

/// Plane finite elements from the same specimen, as a table of three variables.
sim::Rung table_rung(const sim::Specimen& s) {
  sim::MagnetDesign d;
  d.shape = s.shape;
  d.steel = sim::Steel::power_law(s.magnet.bh_linear, s.magnet.bh_power, s.magnet.bh_exponent);
  d.turns = s.coil.turns;
  d.residual_gap = s.magnet.residual_gap;
  sim::TableOptions options;
  options.accuracy = 0.02;
  options.largest_gap = 1.5 * s.core.travel;
  sim::Team team(2);
  return sim::scene_rung(
      sim::pure_field("table", "plane finite elements in a table",
                      std::make_shared<sim::TablePotential>(sim::build_table(d, options, team))),
      "rigid");
}

Json ladder_table(const sim::Ladder& ladder, const std::vector<sim::Rung>& rungs) {
  std::printf(
      "One closing of the reference contactor, 230 V, 60 degrees, 80 ms; errors in us against 1e-12\n");
  std::printf(
      "rung           tolerance   CPU ms      rhs  touch: error  estimate   seat: error  estimate  "
      "settled: error  estimate\n");
  Json list = Json::array();
  for (const auto& r : ladder.rows) {
    std::printf("%-14s %9.0e %8.3f %8ld", rungs[r.run.rung].name().c_str(), r.run.tolerance, r.run.cpu * 1e3,
                static_cast<long>(r.run.evaluations));
    for (std::size_t q = 0; q < r.error.size(); ++q)
      std::printf("  %12.2e  %8.1e", r.error[q] * 1e6, r.estimate[q] * 1e6);
    std::printf("\n");
    list.push_back({{"rung", rungs[r.run.rung].name()},
                    {"tolerance", r.run.tolerance},
                    {"cpu_ms", r.run.cpu * 1e3},
                    {"rhs_evaluations", r.run.evaluations},
                    {"error_s", r.error},
                    {"estimate_s", r.estimate}});
  }
  for (const auto& m : ladder.models)
    std::printf("between %s and %s at 1e-12: touch %.1e us, seat %.1e us, settled %.1e us\n",
                rungs[m.rung].name().c_str(), rungs[m.other].name().c_str(), m.difference[0] * 1e6,
                m.difference[1] * 1e6, m.difference[2] * 1e6);
  return list;
}

Json coverage_table(const std::vector<powbench::bench::EstimateCoverage>& all,
                    std::span<const sim::Rung> rungs, int scenes) {
  std::printf("\nDoes the estimate cover the error? %d random scenes; must 85 .. 98 %%\n", scenes);
  std::printf(
      "rung             setting   CPU ms   covered %%: touch    seat  settled   all   "
      "worst error us: touch      seat   settled\n");
  Json list = Json::array();
  for (const auto& c : all) {
    std::printf("%-14s %9.0e %8.3f              ", rungs[c.rung].name().c_str(), c.tolerance, c.cpu * 1e3);
    for (std::size_t q = 0; q < c.covered.size(); ++q)
      std::printf("%7.1f ", c.happened[q] > 0 ? 100.0 * c.covered[q] / c.happened[q] : std::nan(""));
    std::printf("%6.1f             ", c.share() * 100);
    for (const double e : c.worst_error) std::printf(" %9.2e", e * 1e6);
    std::printf(c.stopped > 0 ? "   %d stopped by a guard\n" : "\n", c.stopped);
    list.push_back({{"rung", rungs[c.rung].name()},
                    {"tolerance", c.tolerance},
                    {"stopped", c.stopped},
                    {"cpu_ms", c.cpu * 1e3},
                    {"happened", c.happened},
                    {"covered", c.covered},
                    {"share", c.share()},
                    {"worst_error_s", c.worst_error}});
  }
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    int in = 0;
    int happened = 0;
    for (const auto& c : all)
      for (std::size_t q = 0; c.rung == r && q < c.covered.size(); ++q) {
        in += c.covered[q];
        happened += c.happened[q];
      }
    std::printf("%s, all tolerances and times: %.1f %%\n", rungs[r].name().c_str(), 100.0 * in / happened);
  }
  return list;
}

Json convergence_table(const std::vector<sim::Rung>& rungs, int scenes) {
  constexpr double duration = 0.06;  // s
  std::vector<sim::Case> drawn;
  powbench::Random random(20261);
  const auto parameters = sim::catalogue_parameters();
  while (drawn.size() < static_cast<std::size_t>(scenes)) {
    const auto c = bench::drawn_case(random, parameters);
    if (sim::tried_closing(c.specimen, c.conditions, duration).core_seat) drawn.push_back(c);
  }
  std::printf(
      "\nDo the times converge? %d closings of specimens over the catalogue's bounds; errors in us against "
      "1e-12, median and largest\n",
      scenes);
  Json list = Json::array();
  using powbench::bench::StepConvergence;
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    const auto c = powbench::bench::step_convergence(rungs, r, drawn, duration, powbench::thread_cpu_seconds);
    std::printf("%s: %d computable, %d not computable, %d stay open\n", rungs[r].name().c_str(), c.computable,
                c.not_computable, c.open);
    std::printf("tolerance       touch                 seat                  settled\n");
    for (std::size_t t = 0; t < StepConvergence::tolerances.size(); ++t) {
      std::printf("%9.0e", StepConvergence::tolerances[t]);
      for (std::size_t q = 0; q < c.grew.size(); ++q)
        std::printf("   %8.1e  %8.1e", c.median[t][q] * 1e6, c.largest[t][q] * 1e6);
      std::printf("\n");
    }
    std::printf("above 1 ns and ten times the error of a coarser tolerance: touch %d, seat %d, settled %d\n",
                c.grew[0], c.grew[1], c.grew[2]);
    list.push_back({{"rung", rungs[r].name()},
                    {"computable", c.computable},
                    {"not_computable", c.not_computable},
                    {"open", c.open},
                    {"tolerances", StepConvergence::tolerances},
                    {"median_s", c.median},
                    {"largest_s", c.largest},
                    {"grew", c.grew}});
  }
  return list;
}

Json choice_table(const std::vector<sim::Rung>& rungs, const std::vector<sim::Case>& scenes,
                  double duration) {
  std::printf("\nChoice by wanted accuracy (worst of the times, as a share of the touch time), %zu scenes\n",
              scenes.size());
  std::printf("accuracy   met   CPU ms of the run: mean  worst   with choosing: mean  worst\n");
  Json list = Json::array();
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6}) {
    int met = 0;
    double run = 0, run_worst = 0, spent = 0, spent_worst = 0;
    for (const auto& scene : scenes) {
      const auto c = sim::choose_rung(rungs, scene, accuracy, duration, powbench::thread_cpu_seconds);
      met += c.met;
      run += c.run.cpu * 1e3 / static_cast<double>(scenes.size());
      spent += c.spent * 1e3 / static_cast<double>(scenes.size());
      run_worst = std::max(run_worst, c.run.cpu * 1e3);
      spent_worst = std::max(spent_worst, c.spent * 1e3);
    }
    std::printf("%8.4f %% %4d %25.3f %6.2f %21.3f %6.2f\n", accuracy * 100, met, run, run_worst, spent,
                spent_worst);
    list.push_back({{"accuracy", accuracy},
                    {"met", met},
                    {"cpu_ms", run},
                    {"worst_cpu_ms", run_worst},
                    {"cpu_ms_with_choosing", spent},
                    {"worst_cpu_ms_with_choosing", spent_worst}});
  }
  std::printf("must: at 1 %% <= 10 ms, at 0.1 %% <= 100 ms\n");
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  std::string svg_path;
  int scenes = 200;
  int bending = 0, deformable = 0;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--svg") == 0) svg_path = argv[i + 1];
    if (std::strcmp(argv[i], "--scenes") == 0) scenes = std::max(1, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--bending") == 0) bending = std::max(0, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--deformable") == 0) deformable = std::max(0, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--threads") == 0) threads = std::max(1, std::atoi(argv[i + 1]));
  }
  sim::Team team(threads);
  auto rungs = sim::closing_rungs();
  const std::size_t same_physics = rungs.size();
  rungs.push_back(table_rung({}));
  sim::LadderOptions options;
  options.repeats = 7;
  sim::Case one;
  one.conditions.closing_angle = powbench::radians(60);
  const auto ladder = sim::run_ladder(rungs, one, options, powbench::thread_cpu_seconds);
  const Json rows = ladder_table(ladder, rungs);

  const std::string picture =
      powbench::host::ladder_svg(ladder, rungs, "Reference contactor, 60 degrees: error against cost");

  options.repeats = 1;
  options.tolerances = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
  const auto coverage = [&](std::span<const sim::Rung> of, int count, std::uint64_t seed) {
    return count == 0 ? Json::array()
                      : coverage_table(powbench::bench::estimator_coverage(
                                           of, powbench::bench::random_scenes({}, count, seed), options,
                                           powbench::thread_cpu_seconds, team),
                                       of, count);
  };
  const Json covered = coverage(rungs, scenes, 23);
  const sim::Rung bends = sim::scene_rung(sim::circuit_field(), "modal"),
                  deforms = sim::scene_rung(sim::circuit_field(), "deformable");
  const Json covered_bending = coverage({&bends, 1}, bending, 29);
  const Json covered_deformable = coverage({&deforms, 1}, deformable, 31);
  const Json converge = convergence_table(rungs, scenes);
  // the estimate speaks of one physics: it cannot choose between fields
  rungs.resize(same_physics);
  const Json chosen = choice_table(rungs, powbench::bench::random_scenes({}, scenes, 23), options.duration);

  const auto write = [](const std::string& path, const std::string& text) {
    std::ofstream out(path);
    out << text;
    out.close();
    if (out) return;
    std::fprintf(stderr, "sim_ladder: cannot write %s\n", path.c_str());
    std::exit(2);
  };
  if (!svg_path.empty()) write(svg_path, picture);
  if (!json_path.empty())
    write(json_path, Json{{"benchmark", "sim_ladder"},
                          {"scenes", scenes},
                          {"estimator_factor", sim::estimator_factor},
                          {"ladder", rows},
                          {"coverage", covered},
                          {"coverage_bending", covered_bending},
                          {"coverage_deformable", covered_deformable},
                          {"convergence", converge},
                          {"choice", chosen}}
                             .dump(2) +
                         "\n");
  return 0;
}
