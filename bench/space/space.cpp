// Three-dimensional fields beside exact, measured and self-converged references: one row a quantity.
//   space [--json PATH] [--picture PATH.svg] [--fine]      --fine: finer meshes and the table too (minutes)

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "bench/space/exact.h"
#include "bench/space/picture.h"
#include "bench/space/probe.h"
#include "bench/space/table.h"
#include "bench/space/team13_rows.h"
#include "bench/space/team20.h"
#include "core/cpu_time.h"
#include "sim/magnetics/space/force.h"
#include "sim/magnetics/space/ladder.h"
#include "sim/magnetics/space/magnet_field.h"
#include "sim/magnetics/space/newton.h"

namespace {

namespace sim = powbench::sim;
namespace bench = powbench::bench;
using bench::Table;
using sim::Vec3;

constexpr double mu0 = 4e-7 * std::numbers::pi;

void balls(Table& table) {
  const auto one = [&](const std::string& name, const std::vector<double>& radius,
                       std::vector<sim::space::Medium> media, double b0, double dipole, double exact) {
    const double start = powbench::process_cpu_seconds();
    sim::space::Problem p;
    p.mesh = bench::ball_mesh(radius, 3);
    p.media = std::move(media);
    p.copies = 8;
    p.fixed = bench::ball_potentials(p.mesh, radius.back(), [&](const Vec3& x) {
      const double r = std::hypot(x[0], x[1], x[2]);
      return -b0 / mu0 * x[2] * (1 - dipole / (r * r * r));
    });
    const sim::space::Coenergy w(p);
    sim::space::Newton newton(w);
    const auto s = newton.solve({});
    const double b = bench::Probe(w, s.state).at({0.2, 0.15, 0.3}).b[2];
    table.add(
        {name, "T", b, exact, w.unknowns(), s.iterations, powbench::process_cpu_seconds() - start, "exact"});
  };
  for (const double mu : {10.0, 1000.0, 1e5})
    one("ball, mu " + nlohmann::json(mu).dump() + ", B inside", {1, 4},
        {powbench::bench::linear_medium(mu), sim::space::air()}, 1, (mu - 1) / (mu + 2), 3 * mu / (mu + 2));
  for (const double b0 : {0.5, 2.0}) {
    const auto steel = sim::builtin_steel("team20");
    const double exact = bench::ball_field(steel, b0);
    one("steel ball in " + std::string(b0 < 1 ? "0.5" : "2") + " T, B inside", {1, 4},
        {sim::space::solid(steel), sim::space::air()}, b0, (exact - mu0 * steel.h(exact)) / (3 * b0), exact);
  }
  for (const double mu : {10.0, 1000.0}) {
    const auto exact = bench::shell_exact(mu, 1, 1.2);
    one("shell, mu " + nlohmann::json(mu).dump() + ", B in the cavity", {1, 1.2, 4},
        {sim::space::air(), powbench::bench::linear_medium(mu), sim::space::air()}, 1, exact.dipole,
        exact.cavity);
  }
}

void solenoids(Table& table) {
  for (const double length : {40e-3, 20e-3}) {
    const double start = powbench::process_cpu_seconds();
    const auto p = bench::solenoid(10e-3, length, 1000, 3);
    const sim::space::Coenergy w(p);
    sim::space::Newton newton(w);
    const auto s = newton.solve({{false, 1}});
    const std::string name = "solenoid " + std::string(length > 0.03 ? "40" : "20") + " mm";
    const double cost = powbench::process_cpu_seconds() - start;
    table.add({name + ", inductance", "H", s.flux[0], bench::solenoid_inductance(10e-3, length, 1000),
               w.unknowns(), s.iterations, cost, "exact"});
    const double centre = mu0 * 1000 / length * (length / 2) / std::hypot(10e-3, length / 2);
    table.add({name + ", B at the centre", "T", bench::Probe(w, s.state).at({1e-6, 1e-6, 1e-6}).b[2], centre,
               w.unknowns(), s.iterations, cost, "exact"});
  }
}

void team20(Table& table, double size) {
  const auto t = bench::team20(size);
  const sim::space::Coenergy w(t.problem);
  sim::space::Newton newton(w);
  for (const auto& row : bench::team20_measured) {
    const double start = powbench::process_cpu_seconds();
    const auto s = newton.solve({{false, row.ampere_turns}});
    const double pull = -sim::space::stress_force(w, s.state, t.virtual_work)[2];
    const double thin = -sim::space::stress_force(w, s.state, t.thin)[2];
    const std::string name = "TEAM 20, " + std::to_string(static_cast<int>(row.ampere_turns)) + " A";
    const double cost = powbench::process_cpu_seconds() - start;
    table.add({name + ", pull", "N", pull, row.pull, w.unknowns(), s.iterations, cost, "measured"});
    table.add({name + ", by thin layer", "N", thin, pull, w.unknowns(), s.iterations, cost, "virtual work"});
  }
}

/// The reference core at several meshes: self-convergence of psi and pull.
void core(Table& table, bool fine) {
  struct State {
    double gap, current;
  };
  const std::vector<State> states{{2e-3, 0.3}, {0.5e-3, 0.3}, {0, 0.3}};
  std::vector<double> sizes{4, 2.8, 2};
  if (fine) sizes.insert(sizes.end(), {1.4, 1});
  struct Result {
    int unknowns, iterations;
    double cpu, psi, pull, stress;
  };
  std::vector<std::vector<Result>> all;
  for (const double size : sizes) {
    sim::space::MagnetField field({}, sim::space::CoreMeshSizes{}.scaled(size));
    auto& results = all.emplace_back();
    for (const auto& state : states) {
      const double start = powbench::process_cpu_seconds();
      field.set_gap(state.gap);
      const auto p = field.at_current(state.current);
      results.push_back({field.unknowns(), p.solution.iterations, powbench::process_cpu_seconds() - start,
                         p.psi, p.response.pull, p.stress_pull});
    }
  }
  char name[64];
  for (std::size_t k = 0; k < states.size(); ++k)
    for (std::size_t m = 0; m < sizes.size(); ++m) {
      const auto& r = all[m][k];
      const auto& best = all.back()[k];
      std::snprintf(name, sizeof name, "core, gap %.1f mm, 0.3 A", states[k].gap * 1e3);
      table.add({name + std::string(", psi"), "Wb", r.psi, best.psi, r.unknowns, r.iterations, r.cpu,
                 "finest mesh"});
      table.add({name + std::string(", pull"), "N", r.pull, best.pull, r.unknowns, r.iterations, r.cpu,
                 "finest mesh"});
    }
}

/// The plane problem by scalar potential here and by vector potential in the plane rung: one from above, one from
/// below.
void plane(Table& table) {
  sim::MagnetField reference({}, {sim::CoreMeshSizes{}.scaled(0.4), 2, 6e-3, {}});
  for (const double size : {2.0, 1.0}) {
    auto sizes = sim::space::CoreMeshSizes{}.scaled(size);
    sizes.ends = false;
    sim::space::MagnetField field({}, sizes);
    for (const double gap : {2e-3, 0.5e-3, 0.0}) {
      const double start = powbench::process_cpu_seconds();
      field.set_gap(gap);
      const auto p = field.at_current(0.3);
      const double cost = powbench::process_cpu_seconds() - start;
      reference.set_gap(gap);
      const auto r = reference.at_current(0.3, 0);
      char name[64];
      std::snprintf(name, sizeof name, "core without ends, gap %.1f mm", gap * 1e3);
      table.add({name + std::string(", psi"), "Wb", p.psi, reference.fluxes(r).first, field.unknowns(),
                 p.solution.iterations, cost, "plane rung"});
      table.add({name + std::string(", pull"), "N", p.response.pull, r.response.pull, field.unknowns(),
                 p.solution.iterations, cost, "plane rung"});
    }
  }
}

nlohmann::ordered_json ends(double size) {
  std::printf(
      "\nWhat the ends of stack and coil add to the plane problem (reference core, 0.05 A, same cells in the "
      "plane)\n");
  std::printf("%8s %12s %12s %12s\n", "gap mm", "leakage H", "pull x", "ring flux x");
  auto list = nlohmann::ordered_json::array();
  const auto sizes = sim::space::CoreMeshSizes{}.scaled(size);
  for (const auto& e :
       sim::space::end_corrections({}, sizes, 0.05, {6e-3, 4e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0})) {
    std::printf("%8.1f %12.4f %12.4f %12.4f\n", e.gap * 1e3, e.leakage, e.pull, e.ring);
    list.push_back(
        {{"gap_m", e.gap}, {"leakage_h", e.leakage}, {"pull_ratio", e.pull}, {"ring_ratio", e.ring}});
  }
  return list;
}

void three_dimensional_table() {
  sim::TableOptions options;
  options.psi_nodes = options.gap_nodes = 12;
  options.ring = false;
  sim::TableReport report;
  const double start = powbench::process_cpu_seconds();
  const sim::TablePotential table(
      sim::space::build_table({}, sim::space::CoreMeshSizes{}.scaled(2.8), options, &report));
  std::printf(
      "\ntable W(psi, gap) 12 x 12: %d unknowns, %d solutions, %d factorisations (most %d), %.1f s CPU, "
      "least d2W/dpsi2 %.4g\n",
      report.unknowns, report.solutions, report.iterations, report.most_iterations,
      powbench::process_cpu_seconds() - start, table.least_stiffness());
}

bool write(const std::string& path, const std::string& text) {
  if (path.empty()) return true;
  std::ofstream out(path);
  out << text;
  if (out) return true;
  std::fprintf(stderr, "space: cannot write %s\n", path.c_str());
  return false;
}

std::string picture() {
  const sim::MagnetDesign design;
  sim::space::MagnetField field(design, sim::space::CoreMeshSizes{}.scaled(2));
  constexpr double gap = 2e-3;
  field.set_gap(gap);
  return bench::core_picture(field, field.at_current(0.8), design, gap);
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path, picture_path;
  bool fine = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json_path = argv[++i];
    else if (std::strcmp(argv[i], "--picture") == 0 && i + 1 < argc)
      picture_path = argv[++i];
    else if (std::strcmp(argv[i], "--fine") == 0)
      fine = true;
  }
  std::printf(
      "Magnetostatics in three dimensions: scalar potential, hexahedra of order 2, Newton from zero\n");
  Table table;
  Table::head();
  balls(table);
  solenoids(table);
  team20(table, 2);
  if (fine) team20(table, 1.3);
  const auto above = bench::team13_rows(table, fine ? 1 : 1.6);
  plane(table);
  core(table, fine);
  std::printf(
      "Peers' published figures, not run here: TEAM 20 by first-order edge elements (226 k unknowns, GetDP) "
      "7.98, 54.64, "
      "74.49, 79.60 N\n");
  const auto bounds = bench::team13_bounds(above, fine);
  const auto corrections = ends(2.8);
  if (fine) three_dimensional_table();
  const nlohmann::ordered_json all{{"benchmark", "space"},
                                   {"rows", table.rows()},
                                   {"team13_bounds", bounds},
                                   {"end_corrections", corrections}};
  const bool written = write(json_path, json_path.empty() ? "" : all.dump(2) + "\n") &&
                       write(picture_path, picture_path.empty() ? "" : picture());
  return written ? 0 : 2;
}
