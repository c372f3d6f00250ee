#include "sim/fields/table_build.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/random.h"

namespace powbench::sim {
namespace {

constexpr double mesh_share = 0.4;  ///< of the wanted error, for the mesh

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

bool with_ring(const MagnetDesign& d, const TableOptions& o) {
  return o.ring && d.shape.ring_share > 0;
}

/// What one gap contributes.
struct Slice {
  std::vector<double> nodes;
  std::vector<double> air;
  TableReport report;
  double largest_pull = 0;
  double stress_distance = 0;
};

/// Solves all fluxes of one gap. Starts follow the tangent of the point before.
class Sweep {
 public:
  Sweep(MagnetField& field, const TablePlan& plan, bool ring, double gap)
      : field_(field), plan_(plan), ring_(ring) {
    field_.set_gap(gap);
    gap_ = gap;
  }

  Slice run() {
    const std::vector<double> no_ring{0};
    const auto& rings = ring_ ? plan_.ring : no_ring;
    std::vector<double> line_start;
    for (std::size_t r = 0; r < rings.size(); ++r) {
      std::vector<double> start = line_start;
      std::vector<double> before;  // tangent one node earlier
      for (std::size_t p = 0; p < plan_.psi.size(); ++p) {
        const FieldPoint point = solve(plan_.psi[p], rings[r], std::move(start));
        store(point);
        if (p + 1 < plan_.psi.size()) {
          const double step = plan_.psi[p + 1] - plan_.psi[p];
          start = point.a;
          auto tangent = field_.tangent(0);
          const double bend = p > 0 ? 0.5 * step * step / (plan_.psi[p] - plan_.psi[p - 1]) : 0;
          for (std::size_t k = 0; k < start.size(); ++k)
            start[k] += step * tangent[k] + (p > 0 ? bend * (tangent[k] - before[k]) : 0);
          before = std::move(tangent);
        }
        if (ring_ && p == 0 && r + 1 < rings.size()) {
          line_start = point.a;
          const auto along = field_.tangent(1);
          for (std::size_t k = 0; k < along.size(); ++k)
            line_start[k] += (rings[r + 1] - rings[r]) * along[k];
        }
      }
    }
    return std::move(slice_);
  }

 private:
  FieldPoint solve(double psi, double ring, std::vector<double> start) {
    auto point = field_.at_flux(psi, ring, std::move(start), !ring_);
    ++slice_.report.solutions;
    slice_.report.iterations += point.newton.iterations;
    slice_.report.most_iterations = std::max(slice_.report.most_iterations, point.newton.iterations);
    if (!point.newton.converged) {
      char text[120];
      std::snprintf(text, sizeof text, "field: no convergence at psi = %g Wb, ring flux = %g Wb, gap = %g mm",
                    psi, ring, gap_ * 1e3);
      throw std::runtime_error(text);
    }
    return point;
  }

  void store(const FieldPoint& point) {
    const auto& r = point.response;
    if (ring_)
      slice_.nodes.insert(slice_.nodes.end(), {r.energy, r.current, r.ring_current, r.current_ring, r.pull,
                                               r.current_gap, r.ring_gap, 0});
    else
      slice_.nodes.insert(slice_.nodes.end(), {r.energy, r.current, r.pull, r.current_gap});
    slice_.largest_pull = std::max(slice_.largest_pull, std::fabs(r.pull));
    slice_.stress_distance = std::max(slice_.stress_distance, std::fabs(r.pull - point.stress_pull));
  }

  MagnetField& field_;
  const TablePlan& plan_;
  bool ring_;
  double gap_ = 0;
  Slice slice_;
};

/// Inverse inductances with air in place of steel.
std::vector<double> air_of(MagnetField& air, bool ring, double gap) {
  air.set_gap(gap);
  const auto coil = air.at_flux(1e-3, 0, {}, !ring).response;
  if (!ring) return {coil.current_psi, coil.current_gap / 1e-3};
  const auto one = air.at_flux(0, 1e-6).response;
  return {coil.current_psi, coil.current_gap / 1e-3, one.ring_ring, one.ring_gap / 1e-6};
}

/// d3W/dpsi dring dgap at the nodes: slopes of the parabolas through three gaps.
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

TablePlan plan_table(const MagnetDesign& d, const TableOptions& o) {
  check(o);
  check_shape(d.shape);
  TablePlan plan;
  const int by_accuracy =
      std::clamp(static_cast<int>(std::lround(24 * std::pow(o.accuracy / 0.005, -0.2))), 12, 48);
  const int np = o.psi_nodes ? o.psi_nodes : by_accuracy, ng = o.gap_nodes ? o.gap_nodes : by_accuracy;
  const int nr = o.ring_nodes ? o.ring_nodes : std::max(8, by_accuracy * 2 / 3);
  const double iron = d.shape.centre_width * d.shape.stack * d.shape.stack_factor;
  const double largest = d.turns * iron * o.largest_field;
  for (int k = 0; k < np; ++k) plan.psi.push_back(largest * k / (np - 1));
  constexpr double grade = 0.3e-3;  // m: nodes are even in ln(gap + grade)
  const double reach = std::log1p(o.largest_gap / grade);
  for (int k = 0; k < ng; ++k) plan.gap.push_back(grade * std::expm1(reach * k / (ng - 1)));
  plan.gap.back() = o.largest_gap;
  if (with_ring(d, o)) {
    const double inner = d.shape.ring_share * (d.shape.outer_width - d.shape.ring_slot);
    const double ring = 2 * inner * d.shape.stack * d.shape.stack_factor * o.largest_field;
    for (int k = 0; k < nr; ++k) plan.ring.push_back(ring * (2.0 * k / (nr - 1) - 1));
  }
  plan.field.sizes = sizes_for(mesh_share * o.accuracy);
  plan.field.largest_gap = o.largest_gap;
  plan.field.newton.tolerance = 1e-8;
  return plan;
}

PotentialTable build_table(const MagnetDesign& d, const TableOptions& o, Team& team, TableReport* report) {
  const TablePlan plan = plan_table(d, o);
  const bool ring = with_ring(d, o);
  const MagnetField prototype(d, plan.field);
  MagnetDesign bare = d;
  bare.steel = Steel::linear(1);
  const MagnetField air_prototype(bare, plan.field);
  std::vector<Slice> slices(plan.gap.size());
  team.run([&](int worker) {
    MagnetField field(prototype), air(air_prototype);
    for (std::size_t g = index(worker); g < slices.size(); g += index(team.workers())) {
      slices[g] = Sweep(field, plan, ring, plan.gap[g]).run();
      slices[g].air = air_of(air, ring, plan.gap[g]);
    }
  });
  PotentialTable t;
  t.psi = plan.psi;
  t.ring = plan.ring;
  t.gap = plan.gap;
  TableReport sum;
  double largest_pull = 0;
  for (const auto& s : slices) {
    t.nodes.insert(t.nodes.end(), s.nodes.begin(), s.nodes.end());
    t.air.insert(t.air.end(), s.air.begin(), s.air.end());
    sum.solutions += s.report.solutions;
    sum.iterations += s.report.iterations;
    sum.most_iterations = std::max(sum.most_iterations, s.report.most_iterations);
    sum.stress_error = std::max(sum.stress_error, s.stress_distance);
    largest_pull = std::max(largest_pull, s.largest_pull);
  }
  sum.stress_error /= std::max(largest_pull, 1e-300);
  sum.unknowns = prototype.unknowns();
  if (ring) fill_triple(t);
  estimate_errors(t);
  t.mesh_error = mesh_share * o.accuracy;
  t.design_hash = table_hash(d, o);
  t.description = describe(d, plan, sum.unknowns);
  if (report) *report = sum;
  return t;
}

std::uint64_t table_hash(const MagnetDesign& d, const TableOptions& o) {
  constexpr std::uint64_t version = 1;  // raise when the same input gives another table
  std::uint64_t hash = version;
  const auto mix = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash ^= bits;
    hash = splitmix64(hash);
  };
  const auto& s = d.shape;
  for (const double v : {s.centre_width,
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
                         d.turns,
                         d.residual_gap,
                         d.end_leakage,
                         o.accuracy,
                         static_cast<double>(o.psi_nodes),
                         static_cast<double>(o.gap_nodes),
                         static_cast<double>(o.ring_nodes),
                         o.largest_gap,
                         o.largest_field,
                         o.ring ? 1.0 : 0.0})
    mix(v);
  for (const auto& k : d.steel.knots()) {
    mix(k.b);
    mix(k.h);
    mix(k.slope);
  }
  return hash;
}

}  // namespace powbench::sim
