#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/fields/table_build.h"

/// The loop that fills a table from any field in the plane or around an axis. A `Field` has
///
///   unknowns(), set_gap(gap), at_flux(psi, ring, start, ring_open) -> FieldPoint, tangent(winding) -> da/dflux.

namespace powbench::sim::table_sweep {

/// By how much the extrapolated start of each state of one gap missed the solution. It changes little from gap to gap.
using Misses = std::vector<std::vector<float>>;

/// Misses of two gaps that are solved already, and the share of the upper one in a mean.
struct Neighbours {
  const Misses* below = nullptr;
  const Misses* above = nullptr;
  double share = 0;
};

/// Solves all fluxes of one gap. Starts follow the tangent of the point before, corrected by what that missed at the
/// neighbours.
template <class Field>
class Sweep {
 public:
  Sweep(Field& field, const TablePlan& plan, bool ring, double gap, Neighbours neighbours = {},
        Misses* misses = nullptr)
      : field_(field), plan_(plan), ring_(ring), neighbours_(neighbours), misses_(misses) {
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
        const FieldPoint point = solve(plan_.psi[p], rings[r], start);
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
  void correct(std::vector<double>& start) const {
    if (!neighbours_.below || start.empty()) return;
    const auto state = static_cast<std::size_t>(slice_.report.solutions);
    const auto &below = (*neighbours_.below)[state], &above = (*neighbours_.above)[state];
    for (std::size_t k = 0; k < start.size(); ++k)
      start[k] += (1 - neighbours_.share) * static_cast<double>(below[k]) +
                  neighbours_.share * static_cast<double>(above[k]);
  }

  void keep_miss(const std::vector<double>& start, const FieldPoint& point) {
    if (!misses_) return;
    auto& miss = misses_->emplace_back(start.size());
    for (std::size_t k = 0; k < start.size(); ++k) miss[k] = static_cast<float>(point.a[k] - start[k]);
  }

  FieldPoint solve(double psi, double ring, const std::vector<double>& extrapolated) {
    auto start = extrapolated;
    correct(start);
    auto point = field_.at_flux(psi, ring, std::move(start), !ring_);
    keep_miss(extrapolated, point);
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
  Neighbours neighbours_;
  Misses* misses_;
  double gap_ = 0;
  TableSlice slice_;
};

/// How a table is filled.
struct Filling {
  SliceSource source{};            ///< see build_table
  bool from_neighbours = false;    ///< starts are corrected by gaps that are solved already
  std::function<void()> beside{};  ///< one more job, done by one worker while others fill
};

/// Gaps in the order of filling: all at once, or every fourth and the last, then those half way between, then the
/// rest. A pass uses only what the passes before it have solved, so that it does not matter which worker solves what.
std::vector<std::vector<std::size_t>> filling_passes(std::size_t gaps, bool from_neighbours);

/// Misses at the nearest gaps below and above that are known, by the numbers of the gaps, which are even in what the
/// field depends on. Nothing in the first pass.
Neighbours known_neighbours(const std::vector<Misses>&, std::size_t gap);

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
/// with air in place of steel; gaps are shared out over the team. Empty where the source leaves out a gap.
template <class Make, class MakeAir>
PotentialTable fill_table(const TablePlan& plan, bool ring, Team& team, const Make& make,
                          const MakeAir& make_air, TableReport* report, const Filling& filling = {}) {
  struct Own {
    decltype(make()) field;
    decltype(make_air()) air;
  };
  std::vector<std::unique_ptr<Own>> own(static_cast<std::size_t>(team.workers()));
  std::vector<std::optional<TableSlice>> slices(plan.gap.size());
  std::vector<Misses> misses(plan.gap.size());
  const auto fill = [&](Own& o, std::size_t g, Misses* missed) {
    const auto solve = [&] {
      TableSlice slice = Sweep(o.field, plan, ring, plan.gap[g], known_neighbours(misses, g), missed).run();
      slice.report.unknowns = o.field.unknowns();
      slice.air = air_of(o.air, ring, plan.gap[g]);
      return slice;
    };
    slices[g] = filling.source ? filling.source(g, solve) : solve();
  };
  const auto passes = filling_passes(plan.gap.size(), filling.from_neighbours);
  for (const auto& pass : passes) {
    const bool last = &pass == &passes.back();
    std::vector<Misses> fresh(pass.size());
    std::atomic<std::size_t> next{0};
    std::atomic<bool> alone{&pass == &passes.front() && filling.beside};
    team.run([&](int worker) {
      if (alone.exchange(false)) filling.beside();
      auto& mine = own[static_cast<std::size_t>(worker)];
      for (std::size_t k = next++; k < pass.size(); k = next++) {
        if (!mine) mine.reset(new Own{make(), make_air()});
        fill(*mine, pass[k], last ? nullptr : &fresh[k]);
      }
    });
    for (std::size_t k = 0; k < pass.size(); ++k) misses[pass[k]] = std::move(fresh[k]);
  }
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
