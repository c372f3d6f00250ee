#include "sim/magnetics/plane/gap_field.h"

#include <utility>

#include "sim/dot.h"

namespace powbench::sim {

std::vector<Steel> GapField::air_steels() const {
  return std::vector<Steel>(problem_.setup().steels.size(), Steel::linear(1));
}

std::vector<Circuit> GapField::with_fluxes(double psi, double ring, bool ring_open) const {
  std::vector<Circuit> circuits{{true, psi, leakage_[0]}};
  if (has_ring()) circuits.push_back({!ring_open, ring_open ? 0 : ring, leakage_[1]});
  return circuits;
}

std::vector<Circuit> GapField::with_currents(double current, double ring_current) const {
  std::vector<Circuit> circuits{{false, current, 0}};
  if (has_ring()) circuits.push_back({false, ring_current, 0});
  return circuits;
}

FieldPoint GapField::point(std::vector<double> a, double energy, const std::vector<double>& current,
                           const NewtonReport& report, const FluxSlopes* slopes) const {
  FieldPoint p;
  p.newton = report;
  auto& r = p.response;
  r.energy = energy;
  r.current = current[0];
  if (has_ring()) r.ring_current = current[1];
  for (std::size_t k = 0; k < current.size(); ++k) r.energy += 0.5 * leakage_[k] * current[k] * current[k];
  std::vector<double> slope;
  r.pull = pull(a, slope);
  p.stress_pull = stress_pull(a);
  p.largest_field = problem_.largest_field(a.data());
  for (const auto& s : problem_.setup().steels)
    p.beyond_data = p.beyond_data || p.largest_field > s.data_end();
  p.beyond_data = p.beyond_data && problem_.share_beyond_data(a.data()) > 0;
  p.a = std::move(a);
  if (!slopes) return p;
  r.current_psi = slopes->flux_flux[0];
  r.current_gap = dot(slope, slopes->tangents[0]);
  if (slopes->tangents.size() < 2) return p;
  r.current_ring = slopes->flux_flux[1];
  r.ring_ring = slopes->flux_flux[3];
  r.ring_gap = dot(slope, slopes->tangents[1]);
  return p;
}

std::pair<double, double> GapField::fluxes(const FieldPoint& p) const {
  const double coil = dot(problem_.winding(0), p.a) + leakage_[0] * p.response.current;
  if (!has_ring()) return {coil, 0};
  return {coil, dot(problem_.winding(1), p.a) + leakage_[1] * p.response.ring_current};
}

FieldPoint state_in(const std::vector<Circuit>& circuits, const GapField& field, Newton& newton,
                    std::vector<double> start, const NewtonOptions& options) {
  start.resize(static_cast<std::size_t>(field.problem().size()) + 1, 0);
  std::vector<double> current;
  const auto report = newton.solve(circuits, start, current, options);
  if (!circuits[0].flux_given) return field.point(std::move(start), newton.energy(), current, report);
  FluxSlopes slopes{newton.flux_flux(), {newton.flux_tangent(0)}};
  if (circuits.size() > 1 && circuits[1].flux_given) slopes.tangents.push_back(newton.flux_tangent(1));
  return field.point(std::move(start), newton.energy(), current, report, &slopes);
}

}  // namespace powbench::sim
