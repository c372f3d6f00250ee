#include "sim/magnetics/space/ladder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace powbench::sim::space {
namespace {

/// One gap of a table.
struct Slice {
  std::vector<double> nodes, steel_field;  ///< steel_field: largest flux density in the steel by node, T
  TableReport report;
  double largest_pull = 0, stress_distance = 0;  ///< N
};

/// Solves all fluxes of one gap. Starts follow the tangents of the nodes before.
class Sweep {
 public:
  Sweep(MagnetField& field, const TablePlan& plan, bool ring, double gap)
      : field_(field), plan_(plan), ring_(ring), gap_(gap) {
    field_.set_gap(gap);
  }

  /// Ring fluxes from the middle outwards; a line below it starts from its mirror image, whose start is exact.
  Slice run() {
    const std::size_t rings = ring_ ? plan_.ring.size() : 1;
    slice_.nodes.resize(rings * plan_.psi.size() * (ring_ ? 8 : 4));
    slice_.steel_field.resize(rings * plan_.psi.size());
    State start;
    for (std::size_t r = rings / 2; r < rings; ++r) {
      const double ring = ring_ ? plan_.ring[r] : 0;
      const FieldPoint first = solve(0, ring, start);
      line(r, first);
      const std::size_t mirror = rings - 1 - r;
      if (mirror != r) {
        State other = first.solution.state;
        for (double& u : other.u) u = -u;
        for (double& i : other.current) i = -i;
        line(mirror, solve(0, plan_.ring[mirror], other));
      }
      if (r + 1 == rings) break;
      start = first.solution.state;
      add(start, plan_.ring[r + 1] - ring, along_ring(first));
    }
    return std::move(slice_);
  }

 private:
  static void add(State& s, double factor, const State& direction) {
    for (std::size_t i = 0; i < s.u.size(); ++i) s.u[i] += factor * direction.u[i];
    for (std::size_t k = 0; k < s.current.size(); ++k) s.current[k] += factor * direction.current[k];
  }

  /// How the solution moves when its currents move.
  static State moved(const FieldPoint& p, std::vector<double> current) {
    State d{std::vector<double>(p.solution.state.u.size(), 0), std::move(current)};
    for (std::size_t k = 0; k < d.current.size(); ++k)
      for (std::size_t i = 0; i < d.u.size(); ++i) d.u[i] += d.current[k] * p.tangents[k][i];
    return d;
  }

  static State along_psi(const FieldPoint& p) {
    std::vector<double> current(p.tangents.size(), 0);
    current[0] = p.response.current_psi;
    if (current.size() > 1) current[1] = p.response.current_ring;  // 0 where it is open
    return moved(p, std::move(current));
  }

  static State along_ring(const FieldPoint& p) {
    return moved(p, {p.response.current_ring, p.response.ring_ring});
  }

  /// All fluxes of the coil at ring flux number r, from the solution of the first.
  void line(std::size_t r, FieldPoint point) {
    const auto& psi = plan_.psi;
    State before;
    for (std::size_t p = 0;; ++p) {
      store(point, p + psi.size() * r);
      if (p + 1 == psi.size()) return;
      const double step = psi[p + 1] - psi[p];
      State start = point.solution.state, slope = along_psi(point);
      add(start, step, slope);
      if (p > 0) {  // the tangent bends as it did over the last step
        const double bend = 0.5 * step * step / (psi[p] - psi[p - 1]);
        add(start, bend, slope);
        add(start, -bend, before);
      }
      before = std::move(slope);
      point = solve(psi[p + 1], ring_ ? plan_.ring[r] : 0, start);
    }
  }

  FieldPoint solve(double psi, double ring, const State& start) {
    FieldPoint p = field_.at_flux(psi, ring, start, !ring_);
    auto& report = slice_.report;
    ++report.solutions;
    report.iterations += p.solution.iterations;
    report.most_iterations = std::max(report.most_iterations, p.solution.iterations);
    if (!p.solution.converged) {
      char text[120];
      std::snprintf(text, sizeof text,
                    "field in space: no convergence at psi = %g Wb, ring flux = %g Wb, gap = %g mm", psi,
                    ring, gap_ * 1e3);
      throw std::runtime_error(text);
    }
    return p;
  }

  void store(const FieldPoint& p, std::size_t node) {
    const auto& r = p.response;
    const std::vector<double> values =
        ring_ ? std::vector{r.energy, r.current,     r.ring_current, r.current_ring,
                            r.pull,   r.current_gap, r.ring_gap,     0.0}
              : std::vector{r.energy, r.current, r.pull, r.current_gap};
    std::copy(values.begin(), values.end(),
              slice_.nodes.begin() + static_cast<std::ptrdiff_t>(node * values.size()));
    slice_.steel_field[node] = field_.function().largest_steel_field(p.solution.state);
    slice_.largest_pull = std::max(slice_.largest_pull, std::fabs(r.pull));
    slice_.stress_distance = std::max(slice_.stress_distance, std::fabs(r.pull - p.stress_pull));
  }

  MagnetField& field_;
  const TablePlan& plan_;
  bool ring_;
  double gap_;
  Slice slice_;
};

}  // namespace

std::vector<EndCorrection> end_corrections(const MagnetDesign& design, const CoreMeshSizes& sizes,
                                           double current, const std::vector<double>& gaps) {
  if (!(std::fabs(current) > 0)) throw std::invalid_argument("end corrections: current 0 A, allowed above 0");
  CoreMeshSizes flat = sizes;
  flat.ends = false;
  MagnetField whole(design, sizes), plane(design, flat);
  std::vector<EndCorrection> out;
  for (const double gap : gaps) {
    whole.set_gap(gap);
    plane.set_gap(gap);
    const auto a = whole.at_current(current), b = plane.at_current(current);
    EndCorrection e{gap, (a.psi - b.psi) / current, a.response.pull / b.response.pull,
                    b.ring != 0 ? a.ring / b.ring : 1};
    if (whole.has_ring()) {
      const double alone = 0.1 * design.turns * current;
      e.ring_leakage = (whole.at_current(0, alone).ring - plane.at_current(0, alone).ring) / alone;
    }
    out.push_back(e);
  }
  return out;
}

namespace {

/// The core with air in place of its steel.
MagnetField bare_core(const MagnetDesign& design, const CoreMeshSizes& sizes) {
  MagnetDesign bare = design;
  bare.steel = Steel::linear(1);
  bare.shape.stack_factor = 1;
  return MagnetField(bare, sizes);
}

std::vector<double> air_of_field(MagnetField& air, const std::vector<double>& gaps, bool ring) {
  std::vector<double> out;
  for (const double gap : gaps) {
    air.set_gap(gap);
    constexpr double unit = 1e-3, ring_unit = 1e-6;  // Wb; linear
    const auto coil = air.at_flux(unit, 0, {}, !ring).response;
    out.insert(out.end(), {coil.current_psi, coil.current_gap / unit});
    if (!ring) continue;
    const auto one = air.at_flux(0, ring_unit).response;
    out.insert(out.end(), {one.ring_ring, one.ring_gap / ring_unit});
  }
  return out;
}

}  // namespace

std::vector<double> air_of_core(const MagnetDesign& design, const CoreMeshSizes& sizes,
                                const std::vector<double>& gaps, bool ring) {
  MagnetField air = bare_core(design, sizes);
  return air_of_field(air, gaps, ring);
}

PotentialTable fill_table(MagnetField& field, MagnetField& bare, const TablePlan& plan, TableReport& sum,
                          const Progress& progress) {
  const bool ring = !plan.ring.empty();
  PotentialTable table;
  table.psi = plan.psi;
  table.ring = plan.ring;
  table.gap = plan.gap;
  sum = {};
  sum.unknowns = field.unknowns();
  double largest = 0;
  for (std::size_t g = 0; g < plan.gap.size(); ++g) {
    const Slice s = Sweep(field, plan, ring, plan.gap[g]).run();
    table.nodes.insert(table.nodes.end(), s.nodes.begin(), s.nodes.end());
    table.steel_field.insert(table.steel_field.end(), s.steel_field.begin(), s.steel_field.end());
    sum.solutions += s.report.solutions;
    sum.iterations += s.report.iterations;
    sum.most_iterations = std::max(sum.most_iterations, s.report.most_iterations);
    sum.stress_error = std::max(sum.stress_error, s.stress_distance);
    largest = std::max(largest, s.largest_pull);
    const int of_all = s.report.solutions * static_cast<int>(plan.gap.size());
    if (progress) progress(sum.solutions, of_all);
  }
  sum.stress_error /= largest;
  table.air = air_of_field(bare, plan.gap, ring);
  if (ring) fill_triple(table);
  return table;
}

PotentialTable build_table(const MagnetDesign& design, const CoreMeshSizes& sizes,
                           const TableOptions& options, TableReport* report, const Progress& progress) {
  TablePlan plan = plan_table(design, options);
  close_about_zero(plan.ring);
  MagnetField field(design, sizes, table_newton), bare = bare_core(design, sizes);
  TableReport sum;
  PotentialTable table = fill_table(field, bare, plan, sum, progress);
  estimate_errors(table);
  table.mesh_error = sum.stress_error;
  table.design_hash = table_hash(design, options) ^ static_cast<std::uint64_t>(sum.unknowns);
  char text[160];
  std::snprintf(text, sizeof text, "three dimensions, %zu x %zu x %zu nodes, %d unknowns, %s, %g turns",
                table.psi.size(), std::max<std::size_t>(1, table.ring.size()), table.gap.size(), sum.unknowns,
                design.steel.name().c_str(), design.turns);
  table.description = text;
  if (report) *report = sum;
  return table;
}

void close_about_zero(std::vector<double>& ring) {
  if (ring.empty()) return;
  const double end = ring.back();
  for (double& r : ring) r *= (1 + 2 * std::fabs(r / end)) / 3;
}

}  // namespace powbench::sim::space
