// Work against precision of the 60 ms reference closing (17 degrees of freedom, 24 contacts, 170 bounces): own
// integrator beside SUNDIALS, with the same right-hand side, in the same process. Then how far the bounces can be
// believed: twin runs, and an ensemble where the sequence is not computable.
//   mechanics_rigid [--json PATH] [--repeats N]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/mechanics/rigid_runs.h"
#include "core/random.h"

namespace {

namespace sim = powbench::sim;
using powbench::bench::closing_end;
using powbench::bench::ClosingRun;
using Json = nlohmann::ordered_json;

struct Row {
  ClosingRun run;
  sim::BounceError error;
};

void print(const Row& r) {
  std::printf("%-24s %7.0e %7ld %8ld %9.3f  %4d/%-4d %9.2e %9.2e %s\n", r.run.method.c_str(), r.run.tolerance,
              r.run.steps, r.run.evaluations, r.run.cpu_ms, r.error.matched, r.error.reference,
              r.error.largest_dt, r.error.distance, r.run.finished ? "" : "gave up");
  std::fflush(stdout);
}

Json as_json(const Row& r) {
  return {{"method", r.run.method},
          {"tolerance", r.run.tolerance},
          {"steps", r.run.steps},
          {"rhs_evaluations", r.run.evaluations},
          {"cpu_ms", r.run.cpu_ms},
          {"matched", r.error.matched},
          {"events", r.error.reference},
          {"largest_dt_s", r.error.largest_dt},
          {"state_distance_s", r.error.distance},
          {"finished", r.run.finished}};
}

/// Cheapest run that has every event within `error` s; nullptr if there is none.
const Row* cheapest(const std::vector<Row>& rows, double error) {
  const Row* best = nullptr;
  for (const auto& r : rows)
    if (r.run.finished && r.error.all() && r.error.largest_dt <= error &&
        (best == nullptr || r.run.cpu_ms < best->run.cpu_ms))
      best = &r;
  return best;
}

/// Fewest right-hand-side calls of a method at `error`, interpolated between its settings in the logarithms, so that the
/// spacing of the tolerances decides nothing. 0: never reaches it.
double calls_at(const std::vector<Row>& rows, const std::string& method, double error) {
  const Row* above = nullptr;
  for (const auto& r : rows) {
    if (r.run.method != method || !r.error.all()) continue;
    if (r.error.largest_dt <= error) {
      if (above == nullptr) return static_cast<double>(r.run.evaluations);
      const double share =
          std::log(above->error.largest_dt / error) / std::log(above->error.largest_dt / r.error.largest_dt);
      return static_cast<double>(above->run.evaluations) *
             std::pow(static_cast<double>(r.run.evaluations) / static_cast<double>(above->run.evaluations),
                      share);
    }
    above = &r;
  }
  return 0;
}

/// CPU time of one right-hand side over states of the closing, us.
double rhs_cost(const sim::RigidParts& parts) {
  using Contactor = sim::RigidContactor<double>;
  Contactor c(parts);
  sim::EventSolver<Contactor> solver(c, 1e-7, 1e-3);
  alignas(64) double y[sim::EventSolver<Contactor>::capacity] = {};
  alignas(64) double dy[sim::EventSolver<Contactor>::capacity] = {};
  c.equilibrium(y);
  solver.restart(0, y, 1e-6);
  double spent = 0;
  long calls = 0;
  double sink = 0;
  while (solver.end() < closing_end) {
    if (!solver.extend()) break;
    std::copy_n(solver.end_state(), c.size(), y);
    c.set_root(solver.memory().y[c.size() + 1]);
    const double begin = powbench::bench::cpu_ms();
    for (int i = 0; i < 100; ++i) {
      c.derivative(solver.end(), y, dy);
      sink += dy[0];
    }
    spent += powbench::bench::cpu_ms() - begin;
    calls += 100;
  }
  return sink == 0.123 ? 0 : spent * 1e3 / static_cast<double>(calls);
}

/// CPU time of the dearest 100 us of the closing, ms; each frame counts with its cheapest repeat.
double worst_frame(const sim::RigidParts& parts, double tolerance, int repeats) {
  using Contactor = sim::RigidContactor<double>;
  constexpr std::size_t frames = 600;
  std::vector<double> cost(frames, 1e300);
  Contactor start(parts);
  alignas(64) double y[sim::EventSolver<Contactor>::capacity] = {};
  start.equilibrium(y);
  for (int r = 0; r < repeats; ++r) {
    Contactor c = start;
    c.events().reserve(4096);
    sim::EventSolver<Contactor> solver(c, tolerance, 1e-3);
    solver.restart(0, y, 1e-6);
    for (std::size_t k = 0; k < frames; ++k) {
      const double begin = powbench::bench::cpu_ms();
      while (solver.end() < static_cast<double>(k + 1) * 1e-4)
        if (!solver.extend()) return 1e300;
      cost[k] = std::min(cost[k], powbench::bench::cpu_ms() - begin);
    }
  }
  return *std::max_element(cost.begin(), cost.end());
}

Json twins() {
  std::printf(
      "\nHow far the bounces can be believed: twin runs with the core's mass changed by a relative eps\n");
  std::printf("  stiffness x   events   eps     condition s per unit   diverged at ms\n");
  Json list = Json::array();
  for (const double stiffness : {1.0, 100.0}) {
    const auto parts = sim::reference_closing(stiffness);
    const auto base = powbench::bench::own_run(parts, 1e-12, 1);
    for (const double eps : {1e-10, 1e-8, 1e-6}) {
      auto changed = parts;
      changed.core_mass *= 1 + eps;
      const auto twin = powbench::bench::own_run(changed, 1e-12, 1);
      const auto c = sim::bounce_condition(twin.events, base.events, eps, closing_end);
      const auto count = std::count_if(base.events.begin(), base.events.end(), sim::is_bounce);
      if (c.diverged)
        std::printf("  %11.0f %8ld  %.0e  %20.3g   %10.3f\n", stiffness, static_cast<long>(count), eps,
                    c.per_input, c.horizon * 1e3);
      else
        std::printf("  %11.0f %8ld  %.0e  %20.3g            never\n", stiffness, static_cast<long>(count),
                    eps, c.per_input);
      list.push_back({{"stiffness", stiffness},
                      {"events", count},
                      {"eps", eps},
                      {"condition_s", c.per_input},
                      {"diverged", c.diverged},
                      {"horizon_s", c.horizon}});
    }
  }
  return list;
}

Json ensemble() {
  constexpr int runs = 64;
  std::printf(
      "\nEnsemble of %d runs at stiffness x 100 (masses and gaps +- 1e-6): mean, 5 %%, 50 %%, 95 %%, ms\n",
      runs);
  powbench::Random random(20);
  std::vector<double> first, open, last;
  for (int k = 0; k < runs; ++k) {
    auto p = sim::reference_closing(100);
    const auto vary = [&](double& v) { v *= 1 + 1e-6 * (2 * random.uniform() - 1); };
    vary(p.core_mass);
    for (auto& b : p.bridges) {
      vary(b.mass);
      vary(b.gap[0]);
      vary(b.gap[1]);
    }
    const auto s = sim::bounce_summary(powbench::bench::own_run(p, 1e-7, 1).events, 0);
    first.push_back(s.first_touch);
    open.push_back(s.open_time);
    last.push_back(s.last_closing);
  }
  Json result;
  const auto line = [&](const char* name, const std::vector<double>& values) {
    const auto s = sim::spread(values);
    std::printf("  %-22s %9.4f %9.4f %9.4f %9.4f\n", name, s.mean * 1e3, s.low * 1e3, s.median * 1e3,
                s.high * 1e3);
    result[name] = {{"mean_s", s.mean}, {"q05_s", s.low}, {"q50_s", s.median}, {"q95_s", s.high}};
  };
  line("first touch of pad 1", first);
  line("open after it", open);
  line("last closing", last);
  return result;
}

Json bars(const std::vector<Row>& own, const std::vector<Row>& peers, const sim::RigidParts& parts,
          int repeats) {
  Json list = Json::array();
  std::printf("\n%-58s %12s %12s\n", "bar", "must", "measured");
  const auto bar = [&](const char* what, const char* must, double value, const char* unit) {
    std::printf("%-58s %12s %9.3g %s\n", what, must, value, unit);
    list.push_back({{"bar", what}, {"must", must}, {"measured", value}, {"unit", unit}});
  };
  const Row* mine = cheapest(own, 3e-8);
  if (mine != nullptr) bar("all 170 events within 3e-8 s, CPU (stretch 2)", "<= 4", mine->run.cpu_ms, "ms");
  bar("right-hand side", "<= 0.1", rhs_cost(parts), "us");
  bar("dearest 100 us frame at tolerance 1e-6", "<= 60", worst_frame(parts, 1e-6, repeats) * 1e3, "us");
  for (const double level : {3e-7, 3e-8, 1e-8}) {
    const Row* a = cheapest(own, level);
    const Row* b = cheapest(peers, level);
    if (a == nullptr || b == nullptr) continue;
    char text[80];
    std::snprintf(text, sizeof text, "CPU of the best SUNDIALS setting over own, error %.0e s", level);
    bar(text, ">= 10", b->run.cpu_ms / a->run.cpu_ms, (" (" + b->run.method + ")").c_str());
    const double own_calls = calls_at(own, a->run.method, level);
    double adams = calls_at(peers, "CVODE Adams", level);
    const double restarted = calls_at(peers, "CVODE Adams, restarted", level);
    if (adams == 0 || (restarted > 0 && restarted < adams)) adams = restarted;
    std::snprintf(text, sizeof text, "right-hand-side calls over those of CVODE Adams, error %.0e s", level);
    if (adams > 0) bar(text, "<= 1", own_calls / adams, "");
  }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  int repeats = 15;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--repeats") == 0) repeats = std::max(1, std::atoi(argv[i + 1]));
  }
  const auto parts = sim::reference_closing();
  const auto exact = powbench::bench::exact_run(parts, 1e-13L);
  const auto looser = powbench::bench::exact_run(parts, 3e-13L);
  const auto judge = [&](const ClosingRun& r) {
    return Row{r, sim::bounce_error(r.events, exact.events, closing_end)};
  };
  std::printf(
      "60 ms closing, 17 degrees of freedom, 24 contacts. Reference: long double at tolerance 1e-13; at "
      "3e-13 it\n"
      "differs by %.1e s. Peer: %s\n",
      judge(looser).error.largest_dt,
      powbench::bench::have_sundials() ? "SUNDIALS, same process, same right-hand side"
                                       : "SUNDIALS was not installed when this was built");
  std::printf("method                       tol   steps      rhs    CPU ms  matched   max dt s  states s\n");
  Json list = Json::array();
  std::vector<Row> own;
  std::vector<Row> peers;
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 5e-9, 2e-9, 1e-9, 1e-10, 1e-11}) {
    own.push_back(judge(powbench::bench::own_run(parts, tolerance, repeats)));
    print(own.back());
    list.push_back(as_json(own.back()));
  }
  for (const auto& method : powbench::bench::sundials_methods())
    for (const double tolerance : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
      peers.push_back(judge(powbench::bench::sundials_run(method, parts, tolerance, std::min(repeats, 3))));
      print(peers.back());
      list.push_back(as_json(peers.back()));
    }
  const Json measured = bars(own, peers, parts, repeats);
  const Json condition = twins();
  const Json spread = ensemble();
  if (json_path.empty()) return 0;
  std::ofstream out(json_path);
  out << Json{{"benchmark", "mechanics_rigid"},
              {"duration_s", closing_end},
              {"rows", list},
              {"bars", measured},
              {"twin_runs", condition},
              {"ensemble_stiffness_100", spread}}
             .dump(2)
      << '\n';
  if (!out) {
    std::fprintf(stderr, "mechanics_rigid: cannot write %s\n", json_path.c_str());
    return 2;
  }
  return 0;
}
