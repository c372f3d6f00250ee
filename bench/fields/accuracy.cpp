// Errors of the finite elements and of the tables: closed solutions, the fifteen rows of the E-E contactor, cold
// starts with a steep steel, convergence with the mesh, and tables against a finer field.
//   fields_accuracy [--json PATH]

#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/analytic.h"
#include "bench/fields/contactor.h"
#include "bench/fields/json_out.h"
#include "core/random.h"
#include "sim/magnetics/plane/table_build.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

Json closed_solutions() {
  Json list = Json::array();
  std::printf("closed solutions\n%-48s %-22s %14s %14s %9s %8s\n", "case", "quantity", "exact", "found",
              "error %", "unknowns");
  for (const auto& cases : {bench::static_cases(), bench::alternating_cases(), bench::circuit_cases()})
    for (const auto& r : cases) {
      std::printf("%-48s %-22s %14.7g %14.7g %+9.4f %8d\n", r.name.c_str(), r.quantity.c_str(), r.exact,
                  r.found, 100 * r.error(), r.unknowns);
      list.push_back({{"case", r.name},
                      {"quantity", r.quantity},
                      {"exact", r.exact},
                      {"found", r.found},
                      {"error", r.error()},
                      {"unknowns", r.unknowns}});
    }
  return list;
}

Json contactor_rows() {
  Json list = Json::array();
  const auto design = bench::reference_contactor();
  sim::MagnetField field(design, {});
  std::printf("\nE-E contactor, %d unknowns, against 265 295\n%8s %8s %14s %9s %12s %9s %12s %4s\n",
              field.unknowns(), "gap mm", "A turns", "flux Wb", "error %", "pull N", "error %", "by stress %",
              "its");
  for (const auto& row : bench::reference_rows) {
    field.set_gap(row.gap - design.residual_gap);
    const auto p = field.at_current(row.ampere_turns, 0);
    const double flux = field.fluxes(p).first;
    const double e_psi = flux / row.flux - 1, e_pull = p.response.pull / row.pull - 1,
                 e_stress = p.stress_pull / row.pull - 1;
    std::printf("%8.2f %8.0f %14.7e %+9.4f %12.5f %+9.4f %+12.4f %4d\n", row.gap * 1e3, row.ampere_turns,
                flux, 100 * e_psi, p.response.pull, 100 * e_pull, 100 * e_stress, p.newton.iterations);
    list.push_back({{"gap_m", row.gap},
                    {"ampere_turns", row.ampere_turns},
                    {"error_psi", e_psi},
                    {"error_pull", e_pull},
                    {"error_pull_stress", e_stress},
                    {"iterations", p.newton.iterations}});
  }
  return list;
}

Json cold_starts() {
  Json list = Json::array();
  std::printf("\n25 cold starts, gaps 0.02 .. 5 mm, 30 .. 10 000 A turns\n%-12s %-12s %10s %8s %6s\n",
              "steel", "steps", "converged", "mean", "most");
  for (const char* name : {"team13", "reference"})
    for (const bool search : {true, false}) {
      auto design = bench::reference_contactor();
      design.steel = sim::builtin_steel(name);
      sim::FieldOptions o;
      o.newton.line_search = search;
      sim::MagnetField field(design, o);
      int converged = 0, sum = 0, most = 0;
      for (const double gap : {0.02e-3, 0.1e-3, 0.5e-3, 2e-3, 5e-3})
        for (const double current : {30.0, 300.0, 1000.0, 3000.0, 10000.0}) {
          field.set_gap(gap);
          const auto r = field.at_current(current, 0).newton;
          if (!r.converged) continue;
          ++converged;
          sum += r.iterations;
          most = std::max(most, r.iterations);
        }
      std::printf("%-12s %-12s %7d/25 %8.1f %6d\n", name, search ? "by energy" : "full", converged,
                  sum / std::max(1.0, 1.0 * converged), most);
      list.push_back({{"steel", name},
                      {"line_search", search},
                      {"converged_of_25", converged},
                      {"most_iterations", most}});
    }
  return list;
}

/// All sizes halved: the order is that of the worst error over the rows, against the finest grid.
Json convergence() {
  Json list = Json::array();
  std::printf(
      "\nconvergence, all cells divided by the factor; worst of 0.5 mm, 300 and 3000 A turns, against the "
      "factor 6\n");
  std::printf("%6s %7s %9s %12s %7s %12s %7s\n", "order", "factor", "unknowns", "psi %", "order", "F %",
              "order");
  const auto design = bench::reference_contactor();
  const auto solve = [&](int order, double factor, int& unknowns) {
    sim::FieldOptions o;
    o.order = order;
    o.sizes = {0.4e-3 / factor, 3e-3 / factor, 3e-3 / factor, 30e-3 / factor, 1 + 1 / factor};
    sim::MagnetField field(design, o);
    unknowns = field.unknowns();
    field.set_gap(0.5e-3 - design.residual_gap);
    std::array<double, 4> out{};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto p = field.at_current(k ? 3000 : 300, 0);
      out[2 * k] = field.fluxes(p).first;
      out[2 * k + 1] = p.response.pull;
    }
    return out;
  };
  int unknowns = 0;
  const auto truth = solve(2, 6, unknowns);
  for (const int order : {1, 2}) {
    double last_psi = 0, last_pull = 0, last_factor = 1;
    for (const double factor : {1.0, 1.5, 2.0, 3.0}) {
      const auto r = solve(order, factor, unknowns);
      const double psi = std::max(std::fabs(r[0] / truth[0] - 1), std::fabs(r[2] / truth[2] - 1));
      const double pull = std::max(std::fabs(r[1] / truth[1] - 1), std::fabs(r[3] / truth[3] - 1));
      const double step = std::log(factor / last_factor);
      const double psi_order = last_psi > 0 ? std::log(last_psi / psi) / step : 0,
                   pull_order = last_psi > 0 ? std::log(last_pull / pull) / step : 0;
      std::printf("%6d %7.1f %9d %12.4f %7.2f %12.4f %7.2f\n", order, factor, unknowns, psi * 100, psi_order,
                  pull * 100, pull_order);
      list.push_back({{"order", order},
                      {"factor", factor},
                      {"unknowns", unknowns},
                      {"error_psi", psi},
                      {"error_pull", pull}});
      last_psi = psi;
      last_pull = pull;
      last_factor = factor;
    }
  }
  return list;
}

struct Worst {
  double current = 0, pull = 0;
};

/// Largest relative differences of a table from a field at random states; the pull where it is above 1 N.
Worst distance(const sim::TablePotential& t, sim::MagnetField& field, int points, std::uint64_t seed) {
  Random random(seed);
  Worst w;
  const double largest_gap = t.table().gap.back();
  for (int k = 0; k < points; ++k) {
    const double psi = t.table().psi.back() * random.uniform();
    const double gap = 0.3e-3 * std::expm1(random.uniform() * std::log1p(largest_gap / 0.3e-3));
    const double ring = t.has_ring()
                            ? t.table().ring.back() *
                                  std::fmin(1, psi / t.table().psi.back() + 0.3 * (2 * random.uniform() - 1))
                            : 0;
    field.set_gap(gap);
    const auto p = field.at_flux(psi, ring, {}, !t.has_ring()).response;
    const auto r = t.at({psi, ring, gap});
    if (!t.has_ring() || std::fabs(p.current) > 0.01)
      w.current = std::max(w.current, std::fabs(r.current / p.current - 1));
    if (p.pull > 1) w.pull = std::max(w.pull, std::fabs(r.pull / p.pull - 1));
  }
  return w;
}

Json tables() {
  Json list = Json::array();
  std::printf("\ntables: 400 random states against the field on the table's mesh, 25 against a fine mesh\n");
  std::printf("%-28s %14s %11s %11s %11s %11s %11s %11s\n", "", "nodes", "i table %", "F table %", "i all %",
              "F all %", "i expected", "F expected");
  auto contactor = bench::reference_contactor();
  contactor.turns = 3000;
  contactor.residual_gap = 20e-6;
  struct Job {
    const char* name;
    sim::MagnetDesign design;
    sim::TableOptions options;
    double fine;
  };
  sim::TableOptions rough, half, tenth, ring;
  rough.psi_nodes = rough.gap_nodes = 12;
  half.psi_nodes = half.gap_nodes = 24;
  tenth.psi_nodes = tenth.gap_nodes = 24;
  tenth.accuracy = 0.001;
  ring.psi_nodes = 24;  // 16 are too few for the reference's steel: the table is refused
  ring.gap_nodes = ring.ring_nodes = 16;
  sim::Team team(2);
  for (const Job& job :
       {Job{"contactor, 0.5 %, 12 nodes", contactor, rough, 3e-4},
        Job{"contactor, 0.5 %", contactor, half, 3e-4}, Job{"contactor, 0.1 %", contactor, tenth, 2e-4},
        Job{"reference, ring open", {}, half, 5e-4}, Job{"reference, with ring", {}, ring, 5e-4}}) {
    auto options = job.options;
    options.ring = std::strstr(job.name, "with ring") != nullptr;
    const sim::TablePotential t(build_table(job.design, options, team));
    sim::MagnetField own(job.design, sim::plan_table(job.design, options).field);
    sim::FieldOptions fine;
    fine.sizes = sim::sizes_for(job.fine);
    sim::MagnetField finer(job.design, fine);
    const auto inner = distance(t, own, options.ring ? 100 : 400, 1), all = distance(t, finer, 25, 2);
    const auto& table = t.table();
    const double i = table.worst_current_error(), f = table.worst_pull_error();
    std::printf("%-28s %3zu x %2zu x %3zu %11.4f %11.4f %11.4f %11.4f %11.4f %11.4f\n", job.name,
                table.psi.size(), std::max<std::size_t>(1, table.ring.size()), table.gap.size(),
                inner.current * 100, inner.pull * 100, all.current * 100, all.pull * 100, i * 100, f * 100);
    list.push_back({{"table", job.name},
                    {"table_current", inner.current},
                    {"table_pull", inner.pull},
                    {"all_current", all.current},
                    {"all_pull", all.pull},
                    {"expected_current", i},
                    {"expected_pull", f},
                    {"least_stiffness", t.least_stiffness()}});
  }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const Json result{{"benchmark", "fields_accuracy"}, {"closed_solutions", closed_solutions()},
                    {"contactor", contactor_rows()},  {"cold_starts", cold_starts()},
                    {"convergence", convergence()},   {"tables", tables()}};
  return bench::write_json(argc, argv, result);
}
