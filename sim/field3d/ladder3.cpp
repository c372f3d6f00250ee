#include "sim/field3d/ladder3.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace powbench::sim {
namespace {

/// Solves one gap, node after node; each start follows the tangent of the node before.
void sweep(MagnetField3& field, const std::vector<double>& psi, PotentialTable& table, TableReport& report) {
  State3 start;
  for (std::size_t k = 0; k < psi.size(); ++k) {
    const auto p = field.at_flux(psi[k], 0, start, true);
    const auto& r = p.response;
    ++report.solutions;
    report.iterations += p.solution.iterations;
    report.most_iterations = std::max(report.most_iterations, p.solution.iterations);
    if (!p.solution.converged) {
      char text[100];
      std::snprintf(text, sizeof text, "field3d: no convergence at psi = %g Wb", psi[k]);
      throw std::runtime_error(text);
    }
    table.nodes.insert(table.nodes.end(), {r.energy, r.current, r.pull, r.current_gap});
    report.stress_error = std::max(report.stress_error, std::fabs(r.pull - p.stress_pull));
    start = p.solution.state;
    if (k + 1 == psi.size()) break;
    const double current = (psi[k + 1] - psi[k]) * r.current_psi;  // dI of the linear step
    for (std::size_t i = 0; i < start.u.size(); ++i) start.u[i] += current * p.tangent[i];
    start.current[0] += current;
  }
}

}  // namespace

std::vector<EndCorrection> end_corrections(const MagnetDesign& design, const CoreMeshSizes3& sizes,
                                           double current, const std::vector<double>& gaps) {
  if (!(std::fabs(current) > 0)) throw std::invalid_argument("end corrections: current 0 A, allowed above 0");
  CoreMeshSizes3 flat = sizes;
  flat.ends = false;
  MagnetField3 whole(design, sizes), plane(design, flat);
  std::vector<EndCorrection> out;
  for (const double gap : gaps) {
    whole.set_gap(gap);
    plane.set_gap(gap);
    const auto a = whole.at_current(current), b = plane.at_current(current);
    out.push_back({gap, (a.psi - b.psi) / current, a.response.pull / b.response.pull,
                   b.ring != 0 ? a.ring / b.ring : 1});
  }
  return out;
}

std::vector<double> air_of_core3(const MagnetDesign& design, const CoreMeshSizes3& sizes,
                                 const std::vector<double>& gaps) {
  MagnetDesign bare = design;
  bare.steel = Steel::linear(1);
  bare.shape.stack_factor = 1;
  MagnetField3 air(bare, sizes);
  std::vector<double> out;
  for (const double gap : gaps) {
    air.set_gap(gap);
    constexpr double unit = 1e-3;  // Wb; linear
    const auto response = air.at_flux(unit, 0, {}, true).response;
    out.insert(out.end(), {response.current_psi, response.current_gap / unit});
  }
  return out;
}

PotentialTable build_table3(const MagnetDesign& design, const CoreMeshSizes3& sizes,
                            const TableOptions& options, TableReport* report) {
  TableOptions open = options;
  open.ring = false;
  const TablePlan plan = plan_table(design, open);
  MagnetField3 field(design, sizes);
  PotentialTable table;
  table.psi = plan.psi;
  table.gap = plan.gap;
  TableReport sum;
  for (const double gap : plan.gap) {
    field.set_gap(gap);
    sweep(field, plan.psi, table, sum);
  }
  table.air = air_of_core3(design, sizes, plan.gap);
  double largest = 0;
  for (std::size_t n = 2; n < table.nodes.size(); n += 4)
    largest = std::max(largest, std::fabs(table.nodes[n]));
  sum.stress_error /= largest;
  sum.unknowns = field.unknowns();
  estimate_errors(table);
  table.mesh_error = sum.stress_error;
  table.design_hash = table_hash(design, open) ^ static_cast<std::uint64_t>(field.unknowns());
  char text[160];
  std::snprintf(text, sizeof text, "three dimensions, %zu x %zu nodes, %d unknowns, %s, %g turns",
                table.psi.size(), table.gap.size(), sum.unknowns, design.steel.name().c_str(), design.turns);
  table.description = text;
  if (report) *report = sum;
  return table;
}

}  // namespace powbench::sim
