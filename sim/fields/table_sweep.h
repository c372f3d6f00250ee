#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/fields/table_build.h"

/// The loop that fills a table from any field in the plane or around an axis. A `Field` has
///
///   unknowns(), set_gap(gap), at_flux(psi, ring, start, ring_open) -> FieldPoint, tangent(winding) -> da/dflux.

namespace powbench::sim::table_sweep {

/// Solves all fluxes of one gap. Starts follow the tangent of the point before.
template <class Field>
class Sweep {
 public:
  Sweep(Field& field, const TablePlan& plan, bool ring, double gap)
      : field_(field), plan_(plan), ring_(ring) {
    field_.set_gap(gap);
    gap_ = gap;
  }

  TableSlice run() {
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
    slice_.report.beyond_data += point.beyond_data;
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
    slice_.steel_field.push_back(point.largest_field);
    if (ring_)
      slice_.nodes.insert(slice_.nodes.end(), {r.energy, r.current, r.ring_current, r.current_ring, r.pull,
                                               r.current_gap, r.ring_gap, 0});
    else
      slice_.nodes.insert(slice_.nodes.end(), {r.energy, r.current, r.pull, r.current_gap});
    slice_.largest_pull = std::max(slice_.largest_pull, std::fabs(r.pull));
    slice_.stress_distance = std::max(slice_.stress_distance, std::fabs(r.pull - point.stress_pull));
  }

  Field& field_;
  const TablePlan& plan_;
  bool ring_;
  double gap_ = 0;
  TableSlice slice_;
};

/// Inverse inductances with air in place of steel.
template <class Field>
std::vector<double> air_of(Field& air, bool ring, double gap) {
  air.set_gap(gap);
  const auto coil = air.at_flux(1e-3, 0, {}, !ring).response;
  if (!ring) return {coil.current_psi, coil.current_gap / 1e-3};
  const auto one = air.at_flux(0, 1e-6).response;
  return {coil.current_psi, coil.current_gap / 1e-3, one.ring_ring, one.ring_gap / 1e-6};
}

/// A table without its estimates, hash and description. `make` and `make_air` return a worker's own field, the second
/// with air in place of steel; gaps are shared out over the team. Empty where `source` leaves out a gap.
template <class Make, class MakeAir>
PotentialTable fill_table(const TablePlan& plan, bool ring, Team& team, const Make& make,
                          const MakeAir& make_air, TableReport* report, const SliceSource& source = {}) {
  std::vector<std::optional<TableSlice>> slices(plan.gap.size());
  team.run([&](int worker) {
    auto field = make();
    auto air = make_air();
    for (auto g = static_cast<std::size_t>(worker); g < slices.size();
         g += static_cast<std::size_t>(team.workers())) {
      const auto solve = [&] {
        TableSlice slice = Sweep(field, plan, ring, plan.gap[g]).run();
        slice.report.unknowns = field.unknowns();
        slice.air = air_of(air, ring, plan.gap[g]);
        return slice;
      };
      slices[g] = source ? source(g, solve) : solve();
    }
  });
  if (!std::all_of(slices.begin(), slices.end(), [](const auto& s) { return s.has_value(); })) return {};
  PotentialTable t;
  t.psi = plan.psi;
  t.ring = plan.ring;
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

}  // namespace powbench::sim::table_sweep
