// The rungs of the field on one contactor: error of flux linkage and pull at given currents, and of the touch time that
// follows, against CPU time.
//   fields_ladder [--json PATH] [--svg PATH] [--fine]      --fine: one mesh finer in the plane and in space (minutes)
// The picture of the documents: --svg docs/bench/fields_ladder.svg

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/circuit.h"
#include "bench/fields/json_out.h"
#include "bench/fields/ladder_picture.h"
#include "bench/fields/ladder_states.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/space/ladder.h"

namespace {

using namespace powbench;
using bench::FieldStates;
using Json = nlohmann::ordered_json;

/// One setting of one rung. Costs in s CPU: of one state, and of everything up to a touch time.
struct Row {
  std::string rung, setting;
  bool in_space = false;
  FieldStates states;
  double touch = 0;
  double state_cost = 0, touch_cost = 0;
};

/// The same closing for all: the ring is open, so that the field in three dimensions can be among them.
sim::TransientSetup closing() {
  sim::TransientSetup s;
  s.voltage = [](double t) { return 325.27 * std::sin(2 * pi * 50 * t + pi / 3); };
  s.resistance = 250;
  s.ring_resistance = 1e3;
  s.mass = 0.12;
  s.counter_force = [](double gap) { return 10 - 1500 * gap; };
  s.start_gap = 5e-3;
  s.step = 50e-6;
  s.duration = 25e-3;
  return s;
}

/// When 3 mm of the 5 mm are gone.
double touch_of(const sim::TransientResult& r) {
  constexpr double touch_gap = 2e-3;
  for (std::size_t k = 1; k < r.samples.size(); ++k) {
    const auto &a = r.samples[k - 1], &b = r.samples[k];
    if (a.gap > touch_gap && b.gap <= touch_gap)
      return a.time + (a.gap - touch_gap) / (a.gap - b.gap) * (b.time - a.time);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

constexpr double mesh_share = 0.4;  ///< of a table's accuracy, for its mesh: sim::TablePlan::mesh_error

/// What the heads of the winding add in the plane rungs, H; `bench_space` prints it by gap.
constexpr double end_leakage = 0.23;

sim::MagnetDesign plane_design() {
  sim::MagnetDesign d;
  d.end_leakage = end_leakage;
  return d;
}

std::string percent(double share) {
  char text[16];
  std::snprintf(text, sizeof text, "%g %%", share * 100);
  return text;
}

sim::TableOptions table_options(double accuracy) {
  sim::TableOptions o;
  o.accuracy = accuracy;
  o.ring = false;
  return o;
}

using Make = std::function<std::unique_ptr<sim::MagneticPotential>()>;

/// A rung that is a potential; `make` builds it, the search for each current starts from the fluxes of `guess`.
Row potential(const std::string& rung, const std::string& setting, const Make& make,
              const FieldStates& guess) {
  double start = thread_cpu_seconds();
  const auto p = make();
  Row r{rung, setting, false, {}, touch_of(run_transient(*p, closing())), 0, 0};
  r.touch_cost = thread_cpu_seconds() - start;
  constexpr int repeats = 200;
  start = thread_cpu_seconds();
  for (int k = 0; k < repeats; ++k) r.states = bench::states_of(*p, guess);
  r.state_cost = (thread_cpu_seconds() - start) / repeats / static_cast<double>(guess.size());
  return r;
}

Row circuit(const FieldStates& guess) {
  return potential(
      "circuit", "with ends",
      [] {
        const sim::MagnetDesign d;
        return std::make_unique<sim::CircuitPotential>(d.shape, d.steel, d.turns, d.residual_gap);
      },
      guess);
}

Row table(double accuracy, const FieldStates& guess) {
  return potential(
      "table", percent(accuracy),
      [&] {
        sim::Team team(1);
        return std::make_unique<sim::TablePotential>(
            build_table(plane_design(), table_options(accuracy), team));
      },
      guess);
}

/// States solved one by one on a mesh of the plane; the touch time from a table of 24 x 24 of the same mesh.
Row plane(double accuracy) {
  Row r{"plane", percent(accuracy), false, {}, 0, 0, 0};
  double start = thread_cpu_seconds();
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(accuracy);
  r.states = bench::states_of(plane_design(), o);
  r.state_cost = (thread_cpu_seconds() - start) / static_cast<double>(r.states.size());
  start = thread_cpu_seconds();
  auto options = table_options(accuracy / mesh_share);
  options.psi_nodes = options.gap_nodes = 24;
  sim::Team team(1);
  const sim::TablePotential table(build_table(plane_design(), options, team));
  r.touch = touch_of(run_transient(table, closing()));
  r.touch_cost = thread_cpu_seconds() - start;
  return r;
}

/// The same without a table: the field in every step.
Row in_loop(double accuracy) {
  Row r{"plane loop", percent(accuracy), false, {}, 0, 0, 0};
  const double start = thread_cpu_seconds();
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(accuracy);
  r.touch = touch_of(run_transient(plane_design(), o, closing()));
  r.touch_cost = thread_cpu_seconds() - start;
  return r;
}

/// In three dimensions, all cells scaled; the touch time from a table of 10 x 10 of the same mesh.
Row space(double scale) {
  Row r{"space", "x " + std::to_string(scale).substr(0, 3), true, {}, 0, 0, 0};
  const auto sizes = sim::space::CoreMeshSizes{}.scaled(scale);
  double start = thread_cpu_seconds();
  r.states = bench::states_of(sim::MagnetDesign{}, sizes);
  r.state_cost = (thread_cpu_seconds() - start) / static_cast<double>(r.states.size());
  start = thread_cpu_seconds();
  auto options = table_options(0.01);
  options.psi_nodes = options.gap_nodes = 10;
  options.ring = false;
  const sim::TablePotential table(sim::space::build_table(sim::MagnetDesign{}, sizes, options));
  r.touch = touch_of(run_transient(table, closing()));
  r.touch_cost = thread_cpu_seconds() - start;
  return r;
}

struct Errors {
  double flux = 0, pull = 0, touch = 0;
};

Errors errors(const Row& r, const Row& truth) {
  const auto [flux, pull] = bench::worst(r.states, truth.states);
  return {flux, pull, std::fabs(r.touch - truth.touch)};
}

struct Report {
  Json rows = Json::array();
  std::vector<bench::LadderPanel> panels{
      {"flux linkage", "CPU of a state, s", "worst error, %", {}},
      {"pull", "CPU of a state, s", "worst error, %", {}},
      {"touch time", "CPU from nothing to a touch time, s", "error, us", {}}};
};

Report report(const std::vector<Row>& rows, const Row& plane_truth, const Row& space_truth) {
  Report out;
  std::printf(
      "\nWorst of %zu states (gaps 0 .. 4 mm, 0.05 .. 0.8 A, ring open), touch after 3 of 5 mm at 60 deg\n"
      "finest of their kind: plane %.4f ms, space %.4f ms\n"
      "%-14s %-12s %12s %12s | %9s %9s %10s | %9s %9s %10s\n%40s %14s | %30s | to the field in three "
      "dimensions\n",
      plane_truth.states.size(), plane_truth.touch * 1e3, space_truth.touch * 1e3, "rung", "setting",
      "state CPU s", "touch CPU s", "psi %", "pull %", "touch us", "psi %", "pull %", "touch us", "", "",
      "to the finest of its kind");
  for (const auto& r : rows) {
    const bool finest = &r == &plane_truth || &r == &space_truth;
    // the circuit knows the ends by itself: it has no finest of its kind
    const bool own = !finest && r.rung != "circuit";
    const Errors e = own ? errors(r, r.in_space ? space_truth : plane_truth) : Errors{},
                 s = errors(r, space_truth);
    std::printf("%-14s %-12s %12.3g %12.3g | %9.4f %9.4f %10.2f | %9.4f %9.4f %10.2f\n", r.rung.c_str(),
                r.setting.c_str(), r.state_cost, r.touch_cost, e.flux * 100, e.pull * 100, e.touch * 1e6,
                s.flux * 100, s.pull * 100, s.touch * 1e6);
    out.rows.push_back({{"rung", r.rung},
                        {"setting", r.setting},
                        {"cpu_state_s", r.state_cost},
                        {"cpu_touch_s", r.touch_cost},
                        {"touch_s", r.touch},
                        {"own_psi", e.flux},
                        {"own_pull", e.pull},
                        {"own_touch_s", e.touch},
                        {"space_psi", s.flux},
                        {"space_pull", s.pull},
                        {"space_touch_s", s.touch}});
    for (auto& panel : out.panels) {
      const auto known = [&](const bench::LadderLine& l) { return l.rung == r.rung; };
      if (std::none_of(panel.lines.begin(), panel.lines.end(), known)) panel.lines.push_back({r.rung, {}});
      auto& points = std::find_if(panel.lines.begin(), panel.lines.end(), known)->points;
      if (panel.title == "touch time")
        points.push_back({r.touch_cost, s.touch * 1e6, e.touch * 1e6});
      else if (r.state_cost > 0 && panel.title == "pull")
        points.push_back({r.state_cost, s.pull * 100, e.pull * 100});
      else if (r.state_cost > 0)
        points.push_back({r.state_cost, s.flux * 100, e.flux * 100});
    }
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const bool fine = bench::flag(argc, argv, "--fine");
  const FieldStates guess = plane(0.02).states;
  std::vector<std::function<Row()>> jobs{[&] { return circuit(guess); }};
  for (const double accuracy : {0.05, 0.02, 0.01, 0.005, 0.002})
    jobs.push_back([&guess, accuracy] { return table(accuracy, guess); });
  for (const double accuracy : {0.02, 0.005, 0.002, 0.0005}) jobs.push_back([=] { return plane(accuracy); });
  if (fine) jobs.push_back([] { return plane(0.00025); });
  const std::size_t plane_truth = jobs.size() - 1;
  for (const double accuracy : {0.02, 0.005}) jobs.push_back([=] { return in_loop(accuracy); });
  for (const double scale : {5.6, 4.0, 2.8}) jobs.push_back([=] { return space(scale); });
  if (fine) jobs.push_back([] { return space(2); });
  std::vector<Row> rows;
  rows.reserve(jobs.size());
  for (const auto& job : jobs) rows.push_back(job());
  const auto out = report(rows, rows[plane_truth], rows.back());
  const std::string picture = bench::option(argc, argv, "--svg");
  if (!picture.empty())
    std::ofstream(picture) << bench::ladder_picture(out.panels, "Reference contactor: rungs of the field");
  return bench::write_json(argc, argv, Json{{"benchmark", "fields_ladder"}, {"rows", out.rows}});
}
