#include "sim/magnetics/plane/table_build.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/random.h"
#include "sim/magnetics/plane/table_sweep.h"

namespace powbench::sim {

namespace {

constexpr double mesh_share = 0.4;  ///< of the wanted error, for the mesh

int nodes_for(double accuracy) {
  return std::clamp(static_cast<int>(std::lround(24 * std::pow(accuracy / 0.005, -0.2))), 12, 48);
}

std::string describe(const MagnetDesign& d, const TablePlan& plan, int unknowns) {
  char text[200];
  std::snprintf(text, sizeof text, "%zu x %zu x %zu nodes, %d unknowns, %s, %g turns, residual gap %g um",
                plan.psi.size(), std::max<std::size_t>(1, plan.ring.size()), plan.gap.size(), unknowns,
                d.steel.name().c_str(), d.turns, d.residual_gap * 1e6);
  return text;
}

void check(const TableOptions& o) {
  if (!(o.accuracy >= 5e-4 && o.accuracy <= 0.05))
    throw std::invalid_argument("accuracy = " + std::to_string(o.accuracy * 100) + " %, allowed 0.05 .. 5 %");
  for (const int n : {o.psi_nodes, o.gap_nodes, o.ring_nodes})
    if (n != 0 && (n < 4 || n > 200))
      throw std::invalid_argument("nodes of a table = " + std::to_string(n) + ", allowed 4 .. 200");
  if (!(o.largest_gap >= 0.1e-3 && o.largest_gap <= 50e-3))
    throw std::invalid_argument("largest gap = " + std::to_string(o.largest_gap * 1e3) +
                                " mm, allowed 0.1 .. 50");
  if (!(o.largest_field >= 0.5 && o.largest_field <= 5))
    throw std::invalid_argument("largest field = " + std::to_string(o.largest_field) +
                                " T, allowed 0.5 .. 5");
}

}  // namespace

bool with_ring(const MagnetDesign& d, const TableOptions& o) {
  return o.ring && d.shape.ring_share > 0;
}

TablePlan plan_table(const TableOptions& o, double largest_psi) {
  check(o);
  TablePlan plan;
  const int by_accuracy = nodes_for(o.accuracy);
  const int np = o.psi_nodes ? o.psi_nodes : by_accuracy, ng = o.gap_nodes ? o.gap_nodes : by_accuracy;
  for (int k = 0; k < np; ++k) plan.psi.push_back(largest_psi * k / (np - 1));
  constexpr double grade = 0.3e-3;  // m: nodes are even in ln(gap + grade)
  const double reach = std::log1p(o.largest_gap / grade);
  for (int k = 0; k < ng; ++k) plan.gap.push_back(grade * std::expm1(reach * k / (ng - 1)));
  plan.gap.back() = o.largest_gap;
  plan.mesh_error = mesh_share * o.accuracy;
  plan.field.sizes = sizes_for(plan.mesh_error);
  plan.field.largest_gap = o.largest_gap;
  plan.field.newton.tolerance = 1e-8;
  return plan;
}

TablePlan plan_table(const MagnetDesign& d, const TableOptions& o) {
  check_shape(d.shape);
  const double iron = d.shape.centre_width * d.shape.stack * d.shape.stack_factor;
  TablePlan plan = plan_table(o, d.turns * iron * o.largest_field);
  if (with_ring(d, o)) {
    const int nr = o.ring_nodes ? o.ring_nodes : std::max(8, nodes_for(o.accuracy) * 2 / 3);
    const double inner = d.shape.ring_share * (d.shape.outer_width - d.shape.ring_slot);
    const double ring = d.shape.outer_legs() * inner * d.shape.stack * d.shape.stack_factor * o.largest_field;
    for (int k = 0; k < nr; ++k) plan.ring.push_back(ring * (2.0 * k / (nr - 1) - 1));
  }
  return plan;
}

NewtonOptions newton_of_table(double accuracy, bool ring) {
  return {std::clamp(accuracy * accuracy / (ring ? 25 : 2.5), 1e-8, 1e-5)};
}

PotentialTable build_table(const MagnetDesign& d, const TableOptions& o, Team& team, TableReport* report,
                           const SliceSource& source) {
  const TablePlan plan = plan_table(d, o);
  const bool ring = with_ring(d, o);
  const CoreGap prototype(d, plan.field);
  auto t = fill_table(plan, ring, team, prototype, newton_of_table(o.accuracy, ring), report, source);
  if (t.nodes.empty()) return t;
  if (ring) fill_triple(t);
  estimate_errors(t);
  t.mesh_error = plan.mesh_error;
  t.data_end = d.steel.stacked(d.shape.stack_factor).data_end();
  t.design_hash = table_hash(d, o);
  t.description = describe(d, plan, prototype.problem().size());
  return t;
}

void fill_triple(PotentialTable& t) {
  const std::size_t plane = t.psi.size() * t.ring.size();
  const std::size_t last = t.gap.size() - 1;
  const auto value = [&](std::size_t n, std::size_t g) { return t.nodes[(n + plane * g) * 8 + 3]; };
  for (std::size_t n = 0; n < plane; ++n)
    for (std::size_t g = 0; g <= last; ++g) {
      const std::size_t m = std::clamp<std::size_t>(g, 1, last - 1);
      const double a = t.gap[m] - t.gap[m - 1], b = t.gap[m + 1] - t.gap[m];
      const double left = (value(n, m) - value(n, m - 1)) / a, right = (value(n, m + 1) - value(n, m)) / b;
      const double bend = (right - left) / (a + b);
      t.nodes[(n + plane * g) * 8 + 7] = left + bend * (2 * t.gap[g] - t.gap[m - 1] - t.gap[m]);
    }
}

double table_end(double stated, const std::function<double()>& saturated) {
  if (!(stated > 0)) return saturated();
  double at = 0;
  try {
    at = saturated();
  } catch (const std::invalid_argument&) {
    return stated;  // nothing to compare it with
  }
  constexpr double least = 0.02, most = 2.5;
  if (stated >= least * at && stated <= most * at) return stated;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "largest_flux_Wb = %.4g, allowed %.3g .. %.3g Wb: the linkage of all turns, and the closed magnet is "
      "saturated from %.3g Wb on",
      stated, least * at, most * at, at);
  throw std::invalid_argument(text);
}

std::uint64_t mixed_hash(std::uint64_t hash, double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  hash ^= bits;
  return splitmix64(hash);
}

std::uint64_t mixed_hash(std::uint64_t hash, const TableOptions& o) {
  for (const double v : {o.accuracy, static_cast<double>(o.psi_nodes), static_cast<double>(o.gap_nodes),
                         static_cast<double>(o.ring_nodes), o.largest_gap, o.ring ? 1.0 : 0.0})
    hash = mixed_hash(hash, v);
  return hash;
}

std::uint64_t hash_values(const std::vector<double>& values, const Steel& steel) {
  constexpr std::uint64_t version = 6;  // raise when the same input gives another table
  std::uint64_t hash = version;
  const auto mix = [&](double value) { hash = mixed_hash(hash, value); };
  for (const double v : values) mix(v);
  for (const auto& k : steel.knots()) {
    mix(k.b);
    mix(k.h);
    mix(k.slope);
  }
  return hash;
}

std::uint64_t table_hash(const MagnetDesign& d, const TableOptions& o) {
  const auto& s = d.shape;
  const std::uint64_t hash = hash_values({s.centre_width,
                                          s.outer_width,
                                          s.window_width,
                                          s.fixed_window,
                                          s.moving_window,
                                          s.yoke,
                                          s.stack,
                                          s.stack_factor,
                                          s.coil_width,
                                          s.coil_height,
                                          s.coil_offset,
                                          s.ring_share,
                                          s.ring_depth,
                                          s.ring_slot,
                                          s.centre_gap,
                                          static_cast<double>(s.legs),
                                          static_cast<double>(s.closed_leg),
                                          d.turns,
                                          d.residual_gap,
                                          d.end_leakage,
                                          o.accuracy,
                                          static_cast<double>(o.psi_nodes),
                                          static_cast<double>(o.gap_nodes),
                                          static_cast<double>(o.ring_nodes),
                                          o.largest_gap,
                                          o.largest_field,
                                          o.ring ? 1.0 : 0.0},
                                         d.steel);
  return d.ring_leakage == 0 ? hash : mixed_hash(hash, d.ring_leakage);
}

}  // namespace powbench::sim
