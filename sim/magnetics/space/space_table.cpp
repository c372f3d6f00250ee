#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/magnetics/space/space_magnet.h"

namespace powbench::sim {
namespace {

/// Flux linkage, Wb, from which on the closed magnet's di/dpsi is above `saturated_stiffness` of that of air.
double saturation(const SpaceMagnet& d, space::MagnetField& field, space::MagnetField& bare) {
  field.set_gap(0);
  bare.set_gap(0);
  const double wanted = saturated_stiffness * bare.at_flux(1e-3, 0, {}, true).response.current_psi;
  double low = 1e-7 * d.turns(), high = low;  // Wb: far below saturation
  space::State near;
  const auto stiff = [&](double psi) {
    const auto p = field.at_flux(psi, 0, near, true);
    if (!p.solution.converged)
      throw std::runtime_error("field in space: no convergence on the way to saturation");
    near = p.solution.state;
    return p.response.current_psi >= wanted;
  };
  if (stiff(low))
    throw std::invalid_argument(
        "the closed magnet is as stiff as half of air from no flux on: does its iron lack air, or meet "
        "nowhere?");
  constexpr double stride = 4;
  for (int k = 0; !stiff(high); ++k) {
    if (k == 12)
      throw std::invalid_argument("the steel does not saturate up to " + std::to_string(high) +
                                  " Wb: the end of the table, largest_flux_Wb, has to be given");
    low = high;
    high *= stride;
  }
  for (int k = 0; k < 4; ++k) {
    const double middle = std::sqrt(low * high);
    (stiff(middle) ? high : low) = middle;
  }
  return high;
}

/// Even nodes of the ring, to a little more than the flux of the open ring in the closed magnet.
std::vector<double> ring_nodes(space::MagnetField& field, double psi, int count) {
  field.set_gap(0);
  const double flux = std::fabs(field.at_flux(psi, 0, {}, true).ring);
  if (!(flux > 0)) throw std::invalid_argument("the ring links no flux of the coil");
  std::vector<double> out;
  for (int k = 0; k < count; ++k) out.push_back(1.15 * flux * (2.0 * k / (count - 1) - 1));
  space::close_about_zero(out);
  return out;
}

/// The same drawing with elements of order one; the middles of edges are nodes of no cell.
SpaceMagnet order_one(const SpaceMagnet& d) {
  SpaceMagnet out = d;
  out.mesh.cell = space::Cell::tet4;
  out.mesh.cells.clear();
  for (std::size_t c = 0; c < d.mesh.region.size(); ++c)
    for (std::size_t k = 0; k < 4; ++k) out.mesh.cells.push_back(d.mesh.cells[10 * c + k]);
  return out;
}

}  // namespace

double mesh_error(const SpaceMagnet& d, space::MagnetField& field, const std::vector<double>& psi) {
  auto rough = space_field(order_one(d), false, space::table_newton);
  double worst = 0;
  for (const double gap : {0.0, d.travel}) {
    field.set_gap(gap);
    rough.set_gap(gap);
    for (const double flux : psi) {
      const auto a = rough.at_flux(flux, 0, {}, true).response, b = field.at_flux(flux, 0, {}, true).response;
      worst = std::max({worst, std::fabs(a.current / b.current - 1), std::fabs(a.pull / b.pull - 1)});
    }
  }
  return worst / 3;
}

PotentialTable build_table(const SpaceMagnet& d, const TableOptions& options, TableReport* report,
                           const space::Progress& progress) {
  space::MagnetField field = space_field(d, false, space::table_newton),
                     bare = space_field(d, true, space::table_newton);
  const double largest = table_end(d.largest_flux, [&] { return saturation(d, field, bare); });
  TablePlan plan = plan_table(options, largest);
  if (options.ring && d.has_ring())
    plan.ring = ring_nodes(field, largest,
                           options.ring_nodes != 0 ? options.ring_nodes
                                                   : std::max(8, static_cast<int>(plan.psi.size()) * 2 / 3));
  const double error = mesh_error(d, field, {largest / 2, largest / 8});
  refuse_mesh_error(error);
  TableReport sum;
  PotentialTable t = space::fill_table(field, bare, plan, sum, progress);
  estimate_errors(t);
  t.mesh_error = error;
  for (const auto& s : d.steels) {
    const double end = d.sheets < 0 ? s.data_end() : s.stacked(d.stack_factor).data_end();
    t.data_end = t.data_end == 0 ? end : std::min(t.data_end, end);
  }
  t.design_hash = table_hash(d, options);
  char text[240];
  std::snprintf(text, sizeof text,
                "%.60s, in space, %zu x %zu x %zu nodes, %d unknowns, %g turns, residual gap %g um",
                d.name.c_str(), t.psi.size(), std::max<std::size_t>(1, t.ring.size()), t.gap.size(),
                sum.unknowns, d.turns(), d.residual_gap * 1e6);
  t.description = text;
  if (report) *report = sum;
  return t;
}

std::uint64_t drawing_hash(const SpaceMagnet& d) {
  constexpr double in_space = 3;  // no plane drawing has this in the first place
  std::vector<double> values{in_space,
                             d.stack_factor,
                             static_cast<double>(d.sheets),
                             static_cast<double>(d.copies),
                             d.drawn_gap,
                             d.residual_gap,
                             d.ring_resistance,
                             d.largest_flux};
  for (const auto& n : d.mesh.nodes) values.insert(values.end(), {n.x, n.y, n.z});
  for (const int n : d.mesh.cells) values.push_back(n);
  for (const int r : d.mesh.region) values.push_back(r);
  for (const auto& p : d.parts) {
    const auto& c = p.coil;
    values.insert(values.end(),
                  {static_cast<double>(p.role), static_cast<double>(p.steel), c.turns,
                   static_cast<double>(c.axis), c.width, c.radius, static_cast<double>(p.images)});
  }
  std::uint64_t hash = hash_values(values, Steel::linear(1));
  for (const auto& s : d.steels) hash = mixed_hash(hash, static_cast<double>(hash_values({}, s)));
  return hash;
}

std::uint64_t table_hash(const SpaceMagnet& d, const TableOptions& o) {
  return mixed_hash(drawing_hash(d), o);
}

}  // namespace powbench::sim
