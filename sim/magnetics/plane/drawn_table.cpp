#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <stdexcept>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/plane/table_sweep.h"

namespace powbench::sim {
namespace {

/// The error of the mesh at one flux and gap, the larger of current and pull, relative: what the halving of all
/// triangles changes, and what further ones would. At right-angled corners of iron energies err with h^(4/3). On the
/// halved mesh a solution to 1e-3 of the energy says it, from that of the drawn one on.
double halving_error(const DrawnGap& drawn, const DrawnGap& halved, double psi, double gap) {
  DrawnField coarse(drawn, {1e-4}), fine(halved, {1e-3});
  coarse.set_gap(gap);
  fine.set_gap(gap);
  const auto a = coarse.at_flux(psi, 0, {}, true);
  const auto b =
      fine.at_flux(psi, 0, on_refined(coarse.problem().space(), a.a, fine.problem().space()), true);
  const double further = 1 / (1 - std::pow(2.0, -4.0 / 3));  // 1.66
  return further * std::max(std::fabs(a.response.current / b.response.current - 1),
                            std::fabs(a.response.pull / b.response.pull - 1));
}

/// PotentialTable::ring_ratio of the closed magnet. Without flux in the ring the coil saturates what the ring leaves
/// out of the pole, and as long as nothing else does,
///
///   d2W/dpsi dring = -ratio d2W/dpsi2:
///
/// the largest of such ratios on the way to `psi`.
double ring_ratio(const std::shared_ptr<const DrawnMagnet>& d, double psi) {
  DrawnField field(DrawnGap(d, 1), {1e-6});
  field.set_gap(0);
  constexpr int steps = 24;
  constexpr double past = 0.9;  // of the largest ratio: the rest of the magnet saturates, too
  double best = 0;
  std::vector<double> a;
  for (int k = 1; k <= steps; ++k) {
    auto p = field.at_flux(psi * k / steps, 0, std::move(a));
    if (!p.newton.converged) throw std::runtime_error("field: no convergence without flux in the ring");
    const double ratio = -p.response.current_ring / p.response.current_psi;
    if (std::fabs(ratio) > std::fabs(best)) best = ratio;
    if (std::fabs(ratio) < past * std::fabs(best)) break;
    a = std::move(p.a);
  }
  return best;
}

/// The axes of a table with ring: what flux each part of the closed magnet's pole takes when no current flows in the
/// ring, and a little more.
void take_ring(TablePlan& plan, const std::shared_ptr<const DrawnMagnet>& d, const DrawnGap& drawn,
               double largest, int count) {
  constexpr double spare = 1.15;
  DrawnField field(drawn, {1e-6});
  field.set_gap(0);
  const double flux = field.fluxes(field.at_flux(largest, 0, {}, true)).second;
  if (!(std::fabs(flux) > 0)) throw std::invalid_argument("the ring links no flux of the coil");
  plan.ring_ratio = ring_ratio(d, largest);
  double rest = largest - plan.ring_ratio * flux;
  if (!(rest > 0.2 * largest)) {  // the ring is around all of the pole
    plan.ring_ratio = 0;
    rest = largest;
  }
  const double reach = spare * std::fabs(flux);
  for (int k = 0; k < count; ++k) plan.ring.push_back(reach * (2.0 * k / (count - 1) - 1));
  if (plan.ring_ratio == 0) return;
  const double stretch = spare * rest / largest;
  for (double& psi : plan.psi) psi *= stretch;
}

/// Whether the nodes of a table keep what is asked of it, and the current rises with the flux between them.
bool good_enough(const PotentialTable& t, double accuracy) {
  try {
    TablePotential{t};
  } catch (const std::invalid_argument&) {
    return false;
  }
  return t.worst_error() <= accuracy;
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

void refuse_mesh_error(double error) {
  if (error <= 1) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "the mesh errs by about %.0f %%, allowed up to 100 %%: is air around the iron missing, or the mesh "
      "far too coarse?",
      error * 100);
  throw std::invalid_argument(text);
}

PotentialTable build_table(const std::shared_ptr<const DrawnMagnet>& d, const TableOptions& o, Team& team,
                           TableReport* report) {
  check_reach(*d, o.largest_gap);
  const bool ring = o.ring && d->has_ring();
  double largest = 0;
  std::optional<DrawnGap> drawn, halved;
  for_each_index(team, 2, [&](int k) {
    if (k == 0) {
      drawn.emplace(d);
      largest = table_end(d->largest_flux, [&] { return saturated_flux(d); });
    } else {
      halved.emplace(std::make_shared<const DrawnMagnet>(refined(*d)));
    }
  });
  double closed = 0, open = 0;
  std::vector<std::function<void()>> halvings{
      [&] { closed = halving_error(*drawn, *halved, largest / 2, 0); },
      [&] { open = halving_error(*drawn, *halved, largest / 2, d->travel); }};
  TableOptions dense = o;
  // with fewer nodes the current of the saturated core falls somewhere between two of them
  if (ring) dense.accuracy = std::min(o.accuracy, 0.02);
  TableReport sum;
  PotentialTable t;
  double mesh_error = 0;
  for (int refined = 0;; ++refined) {
    TablePlan plan = plan_table(dense, largest);
    if (ring) {
      const int count =
          o.ring_nodes != 0 ? o.ring_nodes : std::max(8, static_cast<int>(plan.psi.size()) * 2 / 3);
      take_ring(plan, d, *drawn, largest, count);
    }
    t = fill_table(plan, ring, team, *drawn, newton_of_table(o.accuracy, ring), &sum, {}, halvings);
    halvings.clear();
    mesh_error = std::max(closed, open);
    refuse_mesh_error(mesh_error);
    if (ring) fill_triple(t);
    estimate_errors(t);
    constexpr int most_refinements = 3;
    if (o.psi_nodes != 0 || refined == most_refinements || good_enough(t, o.accuracy)) break;
    dense.psi_nodes = static_cast<int>(t.psi.size()) * 3 / 2;
  }
  t.mesh_error = mesh_error;
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
  return mixed_hash(drawing_hash(d), o);
}

}  // namespace powbench::sim
