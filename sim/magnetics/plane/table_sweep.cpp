#include "sim/magnetics/plane/table_sweep.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace powbench::sim {
namespace {

using Vectors = FieldFour::Vectors;
constexpr std::size_t gaps = FieldFour::gaps;

void extrapolate(Vectors& a, const Vectors& tangent, double step) {
  for (std::size_t g = 0; g < gaps; ++g)
    for (std::size_t k = 0; k < a[g].size(); ++k) a[g][k] += step * tangent[g][k];
}

/// What each node of a table takes from a state.
std::vector<double> node_of(const MagneticResponse& r, bool ring, double ratio) {
  if (!ring) return {r.energy, r.current, r.pull, r.current_gap};
  return {r.energy, r.current,     r.ring_current + ratio * r.current, r.current_ring + ratio * r.current_psi,
          r.pull,   r.current_gap, r.ring_gap + ratio * r.current_gap, 0};
}

/// Solves all fluxes of four gaps, of which the first `wanted` count. Each state starts where the tangents of the two
/// before it lead (Adams and Bashforth's rule, for even nodes; a third tangent makes starts worse at the knee).
class Sweep {
 public:
  Sweep(FieldFour& field, const TablePlan& plan, bool ring, std::size_t first)
      : field_(field), plan_(plan), ring_(ring), wanted_(std::min(gaps, plan.gap.size() - first)) {
    for (std::size_t k = 0; k < gaps; ++k) gap_[k] = plan.gap[first + std::min(k, wanted_ - 1)];
    field_.set_gaps(gap_);
  }

  TableSlice run() {
    const std::vector<double> no_ring{0};
    const auto& rings = ring_ ? plan_.ring : no_ring;
    Vectors line_start;
    for (std::size_t r = 0; r < rings.size(); ++r) {
      Vectors a = line_start;
      Vectors before;  // tangent one node back
      for (std::size_t p = 0; p < plan_.psi.size(); ++p) {
        a = solve(plan_.psi[p] + plan_.ring_ratio * rings[r], rings[r], std::move(a));
        if (ring_ && p == 0 && r + 1 < rings.size()) {
          line_start = a;
          extrapolate(line_start, field_.tangent(1), rings[r + 1] - rings[r]);
          if (plan_.ring_ratio != 0)
            extrapolate(line_start, field_.tangent(0), plan_.ring_ratio * (rings[r + 1] - rings[r]));
        }
        if (p + 1 == plan_.psi.size()) break;
        const double step = plan_.psi[p + 1] - plan_.psi[p];
        auto tangent = field_.tangent(0);
        extrapolate(a, tangent, p == 0 ? step : 1.5 * step);
        if (p > 0) extrapolate(a, before, -0.5 * step);
        before = std::move(tangent);
      }
    }
    slice_.report.unknowns = field_.unknowns();
    const auto air = field_.air(ring_, plan_.ring_ratio);
    for (std::size_t g = 0; g < wanted_; ++g) {
      slice_.nodes.insert(slice_.nodes.end(), nodes_[g].begin(), nodes_[g].end());
      slice_.steel_field.insert(slice_.steel_field.end(), steel_field_[g].begin(), steel_field_[g].end());
      slice_.air.insert(slice_.air.end(), air[g].begin(), air[g].end());
    }
    return std::move(slice_);
  }

 private:
  /// Returns the solutions.
  Vectors solve(double psi, double ring, Vectors start) {
    auto points = field_.at_flux(psi, ring, std::move(start), !ring_);
    Vectors solved;
    for (std::size_t g = 0; g < gaps; ++g) {
      if (!points[g].newton.converged) {
        char text[120];
        std::snprintf(text, sizeof text,
                      "field: no convergence at psi = %g Wb, ring flux = %g Wb, gap = %g mm", psi, ring,
                      gap_[g] * 1e3);
        throw std::runtime_error(text);
      }
      if (g < wanted_) store(g, points[g]);
      solved[g] = std::move(points[g].a);
    }
    return solved;
  }

  void store(std::size_t g, const FieldPoint& point) {
    auto& report = slice_.report;
    ++report.solutions;
    report.iterations += point.newton.iterations;
    report.beyond_data += point.beyond_data;
    report.most_iterations = std::max(report.most_iterations, point.newton.iterations);
    const auto node = node_of(point.response, ring_, plan_.ring_ratio);
    nodes_[g].insert(nodes_[g].end(), node.begin(), node.end());
    steel_field_[g].push_back(point.largest_field);
    const double pull = point.response.pull;
    slice_.largest_pull = std::max(slice_.largest_pull, std::fabs(pull));
    slice_.stress_distance = std::max(slice_.stress_distance, std::fabs(pull - point.stress_pull));
  }

  FieldFour& field_;
  const TablePlan& plan_;
  bool ring_;
  std::size_t wanted_;
  std::array<double, gaps> gap_{};
  std::array<std::vector<double>, gaps> nodes_, steel_field_;
  TableSlice slice_;
};

}  // namespace

PotentialTable fill_table(const TablePlan& plan, bool ring, Team& team, const GapField& prototype,
                          const NewtonOptions& options, TableReport* report, const SliceSource& source,
                          const std::vector<std::function<void()>>& beside) {
  std::vector<std::unique_ptr<FieldFour>> own(static_cast<std::size_t>(team.workers()));
  std::vector<std::optional<TableSlice>> slices((plan.gap.size() + gaps - 1) / gaps);
  std::atomic<std::size_t> next{0}, job{0};
  team.run([&](int worker) {
    for (std::size_t k = job++; k < beside.size(); k = job++) beside[k]();
    auto& field = own[static_cast<std::size_t>(worker)];
    for (std::size_t s = next++; s < slices.size(); s = next++) {
      const auto solve = [&] {
        if (!field) field = std::make_unique<FieldFour>(prototype, options);
        return Sweep(*field, plan, ring, s * gaps).run();
      };
      slices[s] = source ? source(s, solve) : solve();
    }
  });
  if (!std::all_of(slices.begin(), slices.end(), [](const auto& s) { return s.has_value(); })) return {};
  PotentialTable t;
  t.psi = plan.psi;
  t.ring = plan.ring;
  t.ring_ratio = plan.ring_ratio;
  t.gap = plan.gap;
  TableReport sum;
  double largest_pull = 0;
  for (const auto& slice : slices) {
    const TableSlice& s = *slice;
    t.nodes.insert(t.nodes.end(), s.nodes.begin(), s.nodes.end());
    t.air.insert(t.air.end(), s.air.begin(), s.air.end());
    t.steel_field.insert(t.steel_field.end(), s.steel_field.begin(), s.steel_field.end());
    sum.solutions += s.report.solutions;
    sum.iterations += s.report.iterations;
    sum.beyond_data += s.report.beyond_data;
    sum.most_iterations = std::max(sum.most_iterations, s.report.most_iterations);
    sum.unknowns = s.report.unknowns;
    sum.stress_error = std::max(sum.stress_error, s.stress_distance);
    largest_pull = std::max(largest_pull, s.largest_pull);
  }
  sum.stress_error /= std::max(largest_pull, 1e-300);
  if (report) *report = sum;
  return t;
}

}  // namespace powbench::sim
