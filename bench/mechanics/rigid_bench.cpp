// Work against precision of the 60 ms reference closing (17 degrees of freedom, 24 contacts, 170 bounces): own
// integrator beside SUNDIALS, with the same right-hand side, in the same process. Then how far the bounces can be
// believed: twin runs, and an ensemble where the sequence is not computable.
//   mechanics_rigid [--json PATH] [--svg PATH] [--repeats N]
//   mechanics_rigid --draw PATH.json --svg PATH       the picture alone, of an earlier run
// The picture of the documents: --draw docs/bench/mechanics_rigid.json --svg docs/mechanics-rigid.svg

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/mechanics/reference_closing.h"
#include "bench/mechanics/rigid_runs.h"
#include "core/random.h"
#include "host/export/log_plot.h"
#include "sim/mechanics/bounce_study.h"

namespace {

namespace sim = powbench::sim;
using powbench::bench::closing_end;
using powbench::bench::ClosingRun;
using Json = nlohmann::ordered_json;

struct Row {
  ClosingRun run;
  sim::BounceError error;
};

/// The reference closing and four like it, masses and gaps changed by up to 1e-6, each with its exact events. The
/// error of one closing depends on where steps happen to fall and scatters by a factor of ten; the median of five
/// does not.
struct Scene {
  sim::RigidParts parts;
  std::vector<sim::RigidEvent> exact;
};
std::vector<Scene> scenes() {
  powbench::Random random(5);
  std::vector<Scene> list;
  for (int k = 0; k < 5; ++k) {
    const sim::Factor factor = [&] { return k == 0 ? 1 : 1 + 1e-6 * (2 * random.uniform() - 1); };
    const auto parts = sim::varied(powbench::bench::reference_closing(), factor);
    list.push_back({parts, powbench::bench::exact_run(parts, 1e-13L).events});
  }
  return list;
}

/// Every scene by one method: the scene with the median error (a lost sequence counts as the largest), the least CPU
/// time.
template <class Run>
Row median_row(const std::vector<Scene>& all, const Run& run) {
  std::vector<Row> rows;
  double cheapest = 1e300;
  for (const auto& scene : all) {
    const ClosingRun r = run(scene.parts);
    rows.push_back({r, sim::bounce_error(r.events, scene.exact, closing_end)});
    if (r.finished) cheapest = std::min(cheapest, r.cpu_ms);
  }
  const auto badness = [](const Row& r) {
    return r.run.finished && r.error.all() ? r.error.largest_dt : 1.0 / (1 + r.error.matched);
  };
  std::sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return badness(a) < badness(b); });
  Row middle = rows[rows.size() / 2];
  if (middle.run.finished) middle.run.cpu_ms = cheapest;
  return middle;
}

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

/// Fewest right-hand-side calls of a method at `error`, interpolated between its settings in the logarithms, so that
/// the spacing of the tolerances decides nothing. 0: never reaches it.
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

/// Events of the closing with every mass and gap varied.
sim::BounceRun closings(const sim::RigidParts& parts) {
  return [parts](double tolerance, const sim::Factor& factor) {
    return powbench::bench::own_run(sim::varied(parts, factor), tolerance, 1).events;
  };
}

Json twins() {
  std::printf(
      "\nHow far the bounces can be believed: twin runs with every mass and gap changed by a relative "
      "+-eps\n");
  std::printf("  stiffness x   events   eps     condition s per unit   diverged at ms\n");
  Json list = Json::array();
  for (const double stiffness : {1.0, 100.0})
    for (const double eps : {1e-10, 1e-8, 1e-6}) {
      sim::BounceStudyOptions o;
      o.tolerance = 1e-9;
      o.truth = 1e-12;
      o.end = closing_end;
      o.change = eps;
      const auto run = closings(powbench::bench::reference_closing(stiffness));
      const auto [condition, events] = sim::twin_condition(run, o);
      if (condition.diverged)
        std::printf("  %11.0f %8d  %.0e  %20.3g   %10.3f\n", stiffness, events, eps, condition.per_input,
                    condition.horizon * 1e3);
      else
        std::printf("  %11.0f %8d  %.0e  %20.3g            never\n", stiffness, events, eps,
                    condition.per_input);
      list.push_back({{"stiffness", stiffness},
                      {"events", events},
                      {"eps", eps},
                      {"condition_s", condition.per_input},
                      {"diverged", condition.diverged},
                      {"horizon_s", condition.horizon}});
    }
  return list;
}

Json ensemble() {
  sim::BounceStudyOptions o;
  o.tolerance = 1e-7;
  o.end = closing_end;
  o.seed = 20;
  const auto e = sim::bounce_ensemble(closings(powbench::bench::reference_closing(100)), o);
  std::printf(
      "\nEnsemble of %d runs at stiffness x 100 (masses and gaps +- %.0e): mean, 5 %%, 50 %%, 95 %%, ms\n",
      e.runs, o.change);
  Json result;
  const auto line = [&](const char* name, const sim::Spread& s) {
    std::printf("  %-22s %9.4f %9.4f %9.4f %9.4f\n", name, s.mean * 1e3, s.low * 1e3, s.median * 1e3,
                s.high * 1e3);
    result[name] = {{"mean_s", s.mean}, {"q05_s", s.low}, {"q50_s", s.median}, {"q95_s", s.high}};
  };
  line("first touch of pad 1", e.first_touch);
  line("open after it", e.open_time);
  line("last closing", e.last_closing);
  return result;
}

/// Energy that appears from nowhere in the closing without any loss, over a million steps.
Json undamped_energy() {
  std::printf("\nEnergy over 1e6 steps of the closing without any loss; must: residual <= 1e-9\n");
  std::printf("      tol   events   seconds   largest residual   per second\n");
  Json list = Json::array();
  for (const double tolerance : {1e-10, 1e-11, 1e-12}) {
    const auto d = powbench::bench::undamped_run(tolerance, 1000000);
    std::printf("  %7.0e %8ld %9.3f %18.1e %12.1e\n", tolerance, d.events, d.seconds, d.residual,
                d.residual / d.seconds);
    list.push_back({{"tolerance", tolerance},
                    {"steps", 1000000},
                    {"events", d.events},
                    {"seconds", d.seconds},
                    {"residual", d.residual}});
  }
  return list;
}

/// CPU time against error of every method; settings that lose the sequence are left out.
std::string picture(const Json& rows) {
  powbench::host::LogPlot plot{"60 ms closing, 170 bounces: error against cost",
                               "CPU time, ms",
                               "largest time difference of a bounce, s",
                               {}};
  for (const auto& r : rows) {
    if (!r["finished"].get<bool>() || r["matched"] != r["events"]) continue;
    const auto method = r["method"].get<std::string>();
    if (plot.lines.empty() || plot.lines.back().name != method)
      plot.lines.push_back({method, {}, static_cast<int>(plot.lines.size())});
    plot.lines.back().points.push_back({r["cpu_ms"].get<double>(), r["largest_dt_s"].get<double>()});
  }
  return powbench::host::log_plot_svg(plot);
}

void write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text;
  out.close();
  if (out) return;
  std::fprintf(stderr, "mechanics_rigid: cannot write %s\n", path.c_str());
  std::exit(2);
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
  std::string svg_path;
  std::string draw_path;
  int repeats = 15;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
    if (std::strcmp(argv[i], "--svg") == 0) svg_path = argv[i + 1];
    if (std::strcmp(argv[i], "--draw") == 0) draw_path = argv[i + 1];
    if (std::strcmp(argv[i], "--repeats") == 0) repeats = std::max(1, std::atoi(argv[i + 1]));
  }
  if (!draw_path.empty()) {
    std::ifstream in(draw_path);
    write(svg_path, picture(Json::parse(in)["rows"]));
    return 0;
  }
  const auto parts = powbench::bench::reference_closing();
  const auto all = scenes();
  const auto looser = powbench::bench::exact_run(parts, 3e-13L);
  std::printf(
      "60 ms closing, 17 degrees of freedom, 24 contacts. Reference: long double at tolerance 1e-13; at "
      "3e-13 it\n"
      "differs by %.1e s. Peer: %s\n"
      "Events and errors: median of five closings whose masses and gaps differ by up to 1e-6\n",
      sim::bounce_error(looser.events, all.front().exact, closing_end).largest_dt,
      powbench::bench::have_sundials() ? "SUNDIALS, same process, same right-hand side"
                                       : "SUNDIALS was not installed when this was built");
  std::printf("method                       tol   steps      rhs    CPU ms  matched   max dt s  states s\n");
  Json list = Json::array();
  std::vector<Row> own;
  std::vector<Row> peers;
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 5e-9, 2e-9, 1e-9, 1e-10, 1e-11}) {
    own.push_back(median_row(all, [&](const sim::RigidParts& p) {
      return powbench::bench::own_run(p, tolerance, repeats / 5 + 1);
    }));
    print(own.back());
    list.push_back(as_json(own.back()));
  }
  for (const auto& method : powbench::bench::sundials_methods())
    for (const double tolerance : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
      peers.push_back(median_row(all, [&](const sim::RigidParts& p) {
        return powbench::bench::sundials_run(method, p, tolerance, 1);
      }));
      print(peers.back());
      list.push_back(as_json(peers.back()));
    }
  const Json measured = bars(own, peers, parts, repeats);
  const Json condition = twins();
  const Json spread = ensemble();
  const Json energy = undamped_energy();
  if (!svg_path.empty()) write(svg_path, picture(list));
  if (!json_path.empty())
    write(json_path, Json{{"benchmark", "mechanics_rigid"},
                          {"duration_s", closing_end},
                          {"rows", list},
                          {"bars", measured},
                          {"twin_runs", condition},
                          {"ensemble_stiffness_100", spread},
                          {"undamped_energy", energy}}
                             .dump(2) +
                         "\n");
  return 0;
}
