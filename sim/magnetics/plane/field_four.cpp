#include "sim/magnetics/plane/field_four.h"

#include <utility>

namespace powbench::sim {

FieldFour::FieldFour(const GapField& prototype, const NewtonOptions& options)
    : each_{prototype.copy(), prototype.copy(), prototype.copy(), prototype.copy()},
      newton_({&each_[0]->problem(), &each_[1]->problem(), &each_[2]->problem(), &each_[3]->problem()}),
      options_(options) {}

void FieldFour::set_gaps(const std::array<double, gaps>& gap) {
  for (std::size_t k = 0; k < gaps; ++k) each_[k]->set_gap(gap[k]);
  newton_.take_places();
}

std::array<FieldPoint, FieldFour::gaps> FieldFour::at_flux(double psi, double ring, Vectors starts,
                                                           bool ring_open) {
  return solve(each_[0]->with_fluxes(psi, ring, ring_open), std::move(starts), options_);
}

std::array<FieldPoint, FieldFour::gaps> FieldFour::solve(const std::vector<Circuit>& circuits, Vectors a,
                                                         const NewtonOptions& options) {
  for (auto& one : a) one.resize(static_cast<std::size_t>(unknowns()) + 1, 0);
  Vectors current;
  const auto reports = newton_.solve(circuits, a, current, options);
  std::array<FluxSlopes, gaps> slopes;
  for (std::size_t c = 0; c < circuits.size(); ++c) {
    if (!circuits[c].flux_given) continue;
    auto tangents = tangent(c);
    for (std::size_t k = 0; k < gaps; ++k) slopes[k].tangents.push_back(std::move(tangents[k]));
  }
  std::array<FieldPoint, gaps> points;
  for (std::size_t k = 0; k < gaps; ++k) {
    slopes[k].flux_flux = newton_.flux_flux(k);
    points[k] = each_[k]->point(std::move(a[k]), newton_.energy(k), current[k], reports[k], &slopes[k]);
  }
  return points;
}

void FieldFour::set_steels(const std::vector<Steel>& steels) {
  for (const auto& one : each_) one->set_steels(steels);
  newton_.take_steels();
}

FieldFour::Vectors FieldFour::air(bool ring, double ratio) {
  constexpr double coil = 1e-3, loop = 1e-6;  // Wb; what is linear needs one step, whatever the flux
  NewtonOptions one_step;
  one_step.most_iterations = 1;
  const auto steels = each_[0]->problem().setup().steels;
  set_steels(each_[0]->air_steels());
  Vectors out;
  const auto by_coil = solve(each_[0]->with_fluxes(coil, 0, !ring), {}, one_step);
  for (std::size_t k = 0; k < gaps; ++k)
    out[k] = {by_coil[k].response.current_psi, by_coil[k].response.current_gap / coil};
  if (ring) {
    const auto by_ring = solve(each_[0]->with_fluxes(ratio * loop, loop, false), {}, one_step);
    for (std::size_t k = 0; k < gaps; ++k) {
      const auto& r = by_ring[k].response;
      out[k].insert(out[k].end(), {r.ring_ring + ratio * (2 * r.current_ring + ratio * r.current_psi),
                                   (r.ring_gap + ratio * r.current_gap) / loop});
    }
  }
  set_steels(steels);
  return out;
}

}  // namespace powbench::sim
