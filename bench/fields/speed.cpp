// CPU time of a Newton iteration beside GetDP and FreeFem++ on the same unstructured mesh, linear elements, one
// thread; the own quadratic elements on the own grid; and what a table costs to build and to ask.
//   fields_speed [--json PATH]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/fields/contactor.h"
#include "bench/fields/json_out.h"
#include "bench/fields/peers.h"
#include "core/cpu_time.h"
#include "core/random.h"
#include "sim/magnetics/plane/table_build.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

constexpr int repeats = 5;  ///< of ourselves and of each peer alike

/// CPU time of an iteration over the repeats, s.
struct Spread {
  double median = 0, least = 0, most = 0;
};

Spread spread(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  return {seconds[seconds.size() / 2], seconds.front(), seconds.back()};
}

Json json_of(const Spread& s) {
  return {{"median_ms", s.median * 1e3}, {"least_ms", s.least * 1e3}, {"most_ms", s.most * 1e3}};
}

struct Own {
  int unknowns = 0, iterations = 0;
  double flux = 0;
  Spread cpu;  ///< of an iteration
};

/// Cold starts on any mesh with the regions of the peers.
Own own_on(const sim::Mesh& mesh, double ampere_turns, int order) {
  using R = bench::PeerRegion;
  sim::FieldSetup f;
  f.order = order;
  f.depth = 2 * 15e-3;
  f.steels = {sim::builtin_steel("reference")};
  f.steel_of_region = {-1, 0, 0, -1, -1};
  f.windings = {{{{R::coil, 1.0}}}};
  const sim::FieldProblem problem(mesh, f);
  sim::Newton newton(problem);
  Own own;
  own.unknowns = problem.size();
  std::vector<double> cpu;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::vector<double> a(static_cast<std::size_t>(problem.size()) + 1, 0), current;
    const double start = process_cpu_seconds();
    const auto report = newton.solve({{false, ampere_turns, 0}}, a, current, {1e-13, 60, true});
    cpu.push_back((process_cpu_seconds() - start) / report.iterations);
    own.iterations = report.iterations;
    own.flux = 0;
    for (std::size_t k = 0; k < a.size(); ++k) own.flux += problem.winding(0)[k] * a[k];
  }
  own.cpu = spread(std::move(cpu));
  return own;
}

void print_row(const char* name, int unknowns, int iterations, const Spread& cpu, double flux) {
  std::printf("%12s %8d %4d %10.2f %9.2f .. %-8.2f %14.8e", name, unknowns, iterations, cpu.median * 1e3,
              cpu.least * 1e3, cpu.most * 1e3, flux);
}

void peer_row(const char* name, const Own& own, Json& row,
              const std::function<std::optional<bench::PeerResult>()>& run) {
  std::vector<double> cpu;
  bench::PeerResult last;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto r = run();
    if (!r) {
      std::printf("%12s is not here, or failed\n", name);
      row[name] = nullptr;
      return;
    }
    last = *r;
    cpu.push_back(r->cpu_iteration);
  }
  const Spread s = spread(std::move(cpu));
  print_row(name, own.unknowns, last.iterations, s, last.flux);
  std::printf(" %10.1e %8.1f\n", std::fabs(last.flux / own.flux - 1), s.median / own.cpu.median);
  row[name] = {{"iterations", last.iterations},
               {"cpu", json_of(s)},
               {"flux_Wb", last.flux},
               {"ratio", s.median / own.cpu.median}};
}

Json same_mesh() {
  bench::Peers peers((std::filesystem::temp_directory_path() / "powbench_fields_speed").string());
  Json list = Json::array();
  std::printf(
      "Newton iteration on the same unstructured mesh, linear elements, 2 mm gap, 3000 A turns, from zero;\n"
      "median of %d runs, least and most\n",
      repeats);
  std::printf("%12s %8s %4s %10s %21s %14s %10s %8s\n", "", "unknowns", "its", "CPU ms/it", "least .. most",
              "flux Wb", "rel. diff", "x own");
  for (const double size : {0.92, 0.44, 0.215}) {
    const auto mesh = peers.mesh(2e-3, size);
    if (!mesh) {
      std::printf("gmsh is not here: no comparison\n");
      break;
    }
    const Own own = own_on(*mesh, 3000, 1);
    print_row("own", own.unknowns, own.iterations, own.cpu, own.flux);
    std::printf("\n");
    Json row{{"unknowns", own.unknowns}, {"own_cpu", json_of(own.cpu)}, {"own_flux_Wb", own.flux}};
    peer_row("GetDP", own, row, [&] { return peers.getdp(3000); });
    peer_row("FreeFem++", own, row, [&] { return peers.freefem(3000); });
    list.push_back(row);
  }
  return list;
}

/// Own grid: unknowns, time of an iteration and worst errors over the fifteen reference rows.
Json own_grid() {
  Json list = Json::array();
  std::printf("\nown grid, fifteen states of the contactor from zero\n");
  std::printf("%6s %9s %8s %12s %10s %10s %6s\n", "order", "accuracy", "unknowns", "CPU ms/it", "psi %",
              "F %", "most");
  for (const int order : {1, 2})
    for (const double accuracy : {0.02, 0.005, 0.002, 0.001, 0.0005}) {
      const auto design = bench::reference_contactor();
      sim::FieldOptions o;
      o.order = order;
      o.sizes = sim::sizes_for(accuracy);
      sim::MagnetField field(design, o);
      double psi = 0, pull = 0, cpu = 0;
      int iterations = 0, most = 0;
      for (const auto& row : bench::reference_rows) {
        field.set_gap(row.gap - design.residual_gap);
        const double start = process_cpu_seconds();
        const auto p = field.at_current(row.ampere_turns, 0);
        cpu += process_cpu_seconds() - start;
        iterations += p.newton.iterations;
        most = std::max(most, p.newton.iterations);
        psi = std::max(psi, std::fabs(field.fluxes(p).first / row.flux - 1));
        pull = std::max(pull, std::fabs(p.response.pull / row.pull - 1));
      }
      std::printf("%6d %8.2f%% %8d %12.2f %10.4f %10.4f %6d\n", order, accuracy * 100, field.unknowns(),
                  cpu / iterations * 1e3, psi * 100, pull * 100, most);
      list.push_back({{"order", order},
                      {"accuracy", accuracy},
                      {"unknowns", field.unknowns()},
                      {"cpu_ms_iteration", cpu / iterations * 1e3},
                      {"cpu_ms_state", cpu / 15 * 1e3},
                      {"error_psi", psi},
                      {"error_pull", pull},
                      {"most_iterations", most}});
    }
  return list;
}

double evaluation_ns(const sim::TablePotential& t) {
  constexpr int points = 1024, rounds = 400;
  Random random(1);
  std::vector<sim::MagneticState> states;
  for (int k = 0; k < points; ++k)
    states.push_back({t.table().psi.back() * (2 * random.uniform() - 1),
                      t.has_ring() ? t.table().ring.back() * (2 * random.uniform() - 1) : 0,
                      t.table().gap.back() * random.uniform()});
  double best = 1e300, sum = 0;
  for (int r = 0; r < rounds; ++r) {
    const double start = process_cpu_seconds();
    for (int inner = 0; inner < 10; ++inner)
      for (const auto& s : states) {
        const auto m = t.at(s);
        sum += m.current + m.pull;
      }
    best = std::min(best, process_cpu_seconds() - start);
  }
  return std::isfinite(sum) ? best / (10 * points) * 1e9 : 0;
}

Json table(const char* name, const sim::MagnetDesign& design, const sim::TableOptions& o) {
  sim::Team team(2);
  sim::TableReport report;
  const double start = process_cpu_seconds();
  const auto wall = std::chrono::steady_clock::now();
  sim::TablePotential t(build_table(design, o, team, &report));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  const double cpu = process_cpu_seconds() - start;
  const double ns = evaluation_ns(t);
  std::printf("%-28s %3zu x %2zu x %2zu %8d %8.2f %8.2f %10d %8.1f\n", name, t.table().psi.size(),
              std::max<std::size_t>(1, t.table().ring.size()), t.table().gap.size(), report.unknowns, cpu,
              seconds, report.iterations, ns);
  return {{"table", name},      {"unknowns", report.unknowns},   {"cpu_s", cpu},
          {"wall_s", seconds},  {"solutions", report.solutions}, {"iterations", report.iterations},
          {"evaluation_ns", ns}};
}

Json tables() {
  std::printf("\ntables, two threads\n%-28s %12s %8s %8s %8s %10s %8s\n", "", "nodes", "unknowns", "CPU s",
              "wall s", "iterations", "ns/eval");
  auto design = bench::reference_contactor();
  design.turns = 3000;
  design.residual_gap = 20e-6;
  sim::TableOptions half, tenth, ring;
  half.psi_nodes = half.gap_nodes = tenth.psi_nodes = tenth.gap_nodes = 24;
  tenth.accuracy = 0.001;
  ring.psi_nodes = 24;
  ring.gap_nodes = ring.ring_nodes = 16;
  Json list = Json::array();
  list.push_back(table("contactor, 0.5 %", design, half));
  list.push_back(table("contactor, 0.1 %", design, tenth));
  list.push_back(table("reference with ring, 0.5 %", {}, ring));
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const Json result{{"benchmark", "fields_speed"},
                    {"same_mesh", same_mesh()},
                    {"own_grid", own_grid()},
                    {"tables", tables()}};
  return bench::write_json(argc, argv, result);
}
