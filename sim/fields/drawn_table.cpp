#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/fields/drawn_magnet.h"
#include "sim/fields/table_sweep.h"

namespace powbench::sim {
namespace {

/// What the halving of all triangles changes at one flux and at two gaps: the larger of current and pull, relative.
double halving_error(const std::shared_ptr<const DrawnMagnet>& drawing, double psi, double open, Team& team) {
  const auto fine = std::make_shared<const DrawnMagnet>(refined(*drawing));
  std::array<double, 2> worst{};
  for_each_index(team, 2, [&](int k) {
    DrawnField coarse_field(drawing, {}), fine_field(fine, {});
    const double gap = k == 0 ? 0 : open;
    coarse_field.set_gap(gap);
    fine_field.set_gap(gap);
    const auto a = coarse_field.at_flux(psi, 0, {}, true).response,
               b = fine_field.at_flux(psi, 0, {}, true).response;
    worst[static_cast<std::size_t>(k)] =
        std::max(std::fabs(a.current / b.current - 1), std::fabs(a.pull / b.pull - 1));
  });
  return std::max(worst[0], worst[1]);
}

/// Flux through the open ring of the closed magnet, Wb: without its current no more passes it.
double open_ring_flux(const std::shared_ptr<const DrawnMagnet>& drawing, double psi) {
  DrawnField field(drawing, {});
  field.set_gap(0);
  const double flux = std::fabs(field.fluxes(field.at_flux(psi, 0, {}, true)).second);
  if (!(flux > 0)) throw std::invalid_argument("the ring links no flux of the coil");
  return flux;
}

void check_reach(const DrawnMagnet& d, double largest_gap) {
  const auto [from, to] = usable_gaps(d);
  if (d.residual_gap > from && largest_gap + d.residual_gap < to) return;
  char text[300];
  std::snprintf(text, sizeof text,
                "the mesh turns inside out: the triangles of the air that stretches allow gaps between the "
                "faces of %.4g "
                ".. %.4g mm, wanted %.4g .. %.4g mm; draw that air wider, or the magnet with another gap",
                from * 1e3, to * 1e3, d.residual_gap * 1e3, (largest_gap + d.residual_gap) * 1e3);
  throw std::invalid_argument(text);
}

}  // namespace

PotentialTable build_table(const std::shared_ptr<const DrawnMagnet>& d, const TableOptions& o, Team& team,
                           TableReport* report) {
  check_reach(*d, o.largest_gap);
  const double largest = d->largest_flux > 0 ? d->largest_flux : saturated_flux(d);
  TablePlan plan = plan_table(o, largest);
  const bool ring = o.ring && d->has_ring();
  if (ring) {
    const double reach = 1.15 * open_ring_flux(d, largest);
    const int count =
        o.ring_nodes != 0 ? o.ring_nodes : std::max(8, static_cast<int>(plan.psi.size()) * 2 / 3);
    for (int k = 0; k < count; ++k) plan.ring.push_back(reach * (2.0 * k / (count - 1) - 1));
  }
  auto bare = std::make_shared<DrawnMagnet>(*d);
  for (auto& s : bare->steels) s = Steel::linear(1);
  const DrawnField prototype(d, plan.field.newton), air(std::move(bare), plan.field.newton);
  TableReport sum;
  auto t = table_sweep::fill_table(
      plan, ring, team, [&] { return DrawnField(prototype); }, [&] { return DrawnField(air); }, &sum);
  if (ring) fill_triple(t);
  estimate_errors(t);
  t.mesh_error = halving_error(d, largest / 2, d->travel, team);
  for (const auto& s : d->steels)
    t.data_end = t.data_end == 0 ? s.data_end() : std::min(t.data_end, s.data_end());
  t.design_hash = table_hash(*d, o);
  char text[240];
  std::snprintf(text, sizeof text, "%.60s, %zu x %zu x %zu nodes, %d unknowns, %g turns, residual gap %g um",
                d->name.c_str(), t.psi.size(), std::max<std::size_t>(1, t.ring.size()), t.gap.size(),
                sum.unknowns, d->turns(), d->residual_gap * 1e6);
  t.description = text;
  if (report) *report = sum;
  return t;
}

std::uint64_t drawing_hash(const DrawnMagnet& d) {
  std::vector<double> values{
      d.axisymmetric ? 1.0 : 0.0, d.depth,       static_cast<double>(d.copies), d.drawn_gap, d.residual_gap,
      d.ring_resistance,          d.largest_flux};
  values.insert(values.end(), d.mesh.x.begin(), d.mesh.x.end());
  values.insert(values.end(), d.mesh.y.begin(), d.mesh.y.end());
  values.insert(values.end(), d.mesh.zero.begin(), d.mesh.zero.end());
  for (std::size_t t = 0; t < d.mesh.triangle.size(); ++t) {
    for (const int v : d.mesh.triangle[t]) values.push_back(v);
    values.push_back(d.mesh.region[t]);
  }
  for (const auto& p : d.parts)
    values.insert(values.end(), {static_cast<double>(p.role), static_cast<double>(p.steel), p.turns});
  std::uint64_t hash = hash_values(values, Steel::linear(1));
  for (const auto& s : d.steels) hash = mixed_hash(hash, static_cast<double>(hash_values({}, s)));
  return hash;
}

std::uint64_t table_hash(const DrawnMagnet& d, const TableOptions& o) {
  std::uint64_t hash = drawing_hash(d);
  for (const double v : {o.accuracy, static_cast<double>(o.psi_nodes), static_cast<double>(o.gap_nodes),
                         static_cast<double>(o.ring_nodes), o.largest_gap, o.ring ? 1.0 : 0.0})
    hash = mixed_hash(hash, v);
  return hash;
}

}  // namespace powbench::sim
