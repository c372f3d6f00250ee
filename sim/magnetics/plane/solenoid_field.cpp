#include "sim/magnetics/plane/solenoid_field.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::sim {
namespace {

FieldSetup setup_of(const SolenoidDesign& d, const FieldOptions& o, double conductivity) {
  FieldSetup f;
  f.order = o.order;
  f.axisymmetric = true;
  f.steels = {d.steel};
  f.steel_of_region.assign(SolenoidRegion::count, -1);
  f.steel_of_region[SolenoidRegion::fixed_iron] = f.steel_of_region[SolenoidRegion::plunger] = 0;
  if (d.shape.magnet_length > 0) {
    f.steels.push_back(Steel::linear(d.magnet_permeability));
    f.steel_of_region[SolenoidRegion::magnet] = 1;
  }
  if (conductivity > 0) {
    f.conductivity.assign(SolenoidRegion::count, 0);
    f.conductivity[SolenoidRegion::fixed_iron] = f.conductivity[SolenoidRegion::plunger] = conductivity;
  }
  f.windings = {{{{SolenoidRegion::coil, d.turns}}}};
  return f;
}

void check(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  char text[120];
  std::snprintf(text, sizeof text, "solenoid.%s = %g, allowed %g .. %g", key, value, low, high);
  throw std::invalid_argument(text);
}

const SolenoidDesign& checked(const SolenoidDesign& d) {
  check("residual_gap_um", d.residual_gap * 1e6, 1, 1000);
  check("turns", d.turns, 1, 1e6);
  check("remanence_T", d.remanence, d.shape.magnet_length > 0 ? -2 : 0, d.shape.magnet_length > 0 ? 2 : 0);
  check("magnet_permeability", d.magnet_permeability, 1, 10);
  return d;
}

/// 1 in the plunger, 0 elsewhere.
std::vector<double> body(const Mesh& m) {
  std::vector<double> weight(m.x.size(), 0);
  for (std::size_t t = 0; t < m.triangle.size(); ++t)
    if (m.region[t] == SolenoidRegion::plunger)
      for (const int v : m.triangle[t]) weight[static_cast<std::size_t>(v)] = 1;
  return weight;
}

}  // namespace

SolenoidGap::SolenoidGap(const SolenoidDesign& d, const FieldOptions& o, double iron_conductivity)
    : SolenoidGap(SolenoidGrid(checked(d).shape, o.sizes, d.largest_gap + d.residual_gap), d, o,
                  iron_conductivity) {}

SolenoidGap::SolenoidGap(SolenoidGrid grid, const SolenoidDesign& d, const FieldOptions& o,
                         double iron_conductivity)
    : GapField(FieldProblem(grid.mesh(), setup_of(d, o, iron_conductivity))),
      residual_gap_(d.residual_gap),
      largest_gap_(d.largest_gap),
      grid_(std::move(grid)),
      layer_(body(grid_.mesh())) {
  set_gap(largest_gap_);
}

std::vector<Steel> SolenoidGap::air_steels() const {
  auto steels = problem_.setup().steels;
  steels.front() = Steel::linear(1);
  return steels;
}

void SolenoidGap::set_gap(double gap) {
  check("gap_mm", gap * 1e3, 0, largest_gap_ * 1e3 * (1 + 1e-12));
  const double whole = gap + residual_gap_;
  gap_ = gap;
  problem_.move_vertices(grid_.mesh().x, grid_.heights(whole));
  pull_ = PullForm(problem_.space(), grid_.motion(whole));
  rough_ = PullForm(problem_.space(), layer_);
}

SolenoidField::SolenoidField(const SolenoidDesign& design, const FieldOptions& options,
                             double iron_conductivity)
    : design_(design), options_(options), gap_(design, options, iron_conductivity), newton_(gap_.problem()) {
  if (design.remanence != 0) magnetise();
  if (iron_conductivity > 0) find_columns();
}

/// B = mu0 mu_r H + B_r has the energy (B - B_r)^2 / (2 mu0 mu_r): beside that of a linear material a load, constant
/// because the magnet stands still.
void SolenoidField::magnetise() {
  const auto& space = problem().space();
  const double strength = design_.remanence / (mu0 * design_.magnet_permeability);
  magnet_.assign(static_cast<std::size_t>(unknowns()) + 1, 0);
  for (std::size_t t = 0; t < space.mesh.triangle.size(); ++t) {
    if (space.mesh.region[t] != SolenoidRegion::magnet) continue;
    for (const auto& p : shape_points(space, t, 4))
      for (int n = 0; n < space.nodes; ++n)
        magnet_[static_cast<std::size_t>(space.unknowns(t)[n])] +=
            p.weight * p.curl_y[static_cast<std::size_t>(n)] * strength;
  }
  magnet_.back() = 0;
  newton_.set_quadratic(nullptr, &magnet_);
}

FieldPoint SolenoidField::solve(const Circuit& circuit, std::vector<double> start) {
  return state_in({circuit}, gap_, newton_, std::move(start), options_.newton);
}

FieldPoint SolenoidField::at_flux(double psi, std::vector<double> start) {
  return solve({true, psi, 0}, std::move(start));
}

FieldPoint SolenoidField::at_current(double current, std::vector<double> start) {
  return solve({false, current, 0}, std::move(start));
}

FieldPoint SolenoidField::in_circuit(double b, double r, std::vector<double> start) {
  return solve({true, b, r}, std::move(start));
}

}  // namespace powbench::sim
