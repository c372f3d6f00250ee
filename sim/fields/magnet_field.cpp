#include "sim/fields/magnet_field.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/dot.h"

namespace powbench::sim {
namespace {

FieldSetup setup_of(const MagnetDesign& d, const FieldOptions& o, double iron_conductivity) {
  FieldSetup f;
  f.order = o.order;
  const bool half = d.shape.legs == 3;
  f.depth = (half ? 2 : 1) * d.shape.stack;
  f.steels = {d.steel.stacked(d.shape.stack_factor)};
  f.steel_of_region.assign(CoreRegion::count, -1);
  for (const int iron : {CoreRegion::fixed_iron, CoreRegion::moving_iron, CoreRegion::strip_iron})
    f.steel_of_region[static_cast<std::size_t>(iron)] = 0;
  f.windings = {{{{CoreRegion::coil, d.turns}}}};
  if (!half) f.windings[0].parts.emplace_back(CoreRegion::coil_back, -d.turns);
  if (d.shape.ring_share > 0)
    f.windings.push_back({{{CoreRegion::ring_inner, 1.0}, {CoreRegion::ring_outer, -1.0}}});
  if (iron_conductivity > 0) {
    f.conductivity.assign(CoreRegion::count, 0);
    f.conductivity[CoreRegion::fixed_iron] = f.conductivity[CoreRegion::moving_iron] = iron_conductivity;
  }
  f.strip_region = CoreRegion::strip;
  if (d.shape.closed_leg != 0) f.strip_steel_region = CoreRegion::strip_iron;
  f.strip_height = strip_height;
  return f;
}

/// 0 below and 1 above the middle layer of the strip.
std::vector<double> middle_layer(const FieldOptions& o, const Mesh& m) {
  const auto layers = strip_layers(o.sizes, o.largest_gap);
  const double top = layers[layers.size() / 2] * strip_height;
  std::vector<double> weight;
  for (const double y : m.y) weight.push_back(y > top - 1e-9 * strip_height ? 1 : 0);
  return weight;
}

void check(const MagnetDesign& d) {
  if (!(d.residual_gap >= 0.05e-6 && d.residual_gap <= 1e-3))
    throw std::invalid_argument("magnet.residual_gap_um = " + std::to_string(d.residual_gap * 1e6) +
                                ", allowed 0.05 .. 1000");
  if (!(d.turns >= 1 && d.turns <= 1e6))
    throw std::invalid_argument("coil.turns = " + std::to_string(d.turns) + ", allowed 1 .. 1e6");
  if (!(d.end_leakage >= 0)) throw std::invalid_argument("end leakage below 0");
  if (!(d.ring_leakage >= 0)) throw std::invalid_argument("ring leakage below 0");
}

}  // namespace

CoreMeshSizes sizes_for(double accuracy) {
  if (!(accuracy >= 2e-4 && accuracy <= 0.05))
    throw std::invalid_argument("accuracy = " + std::to_string(accuracy * 100) + " %, allowed 0.02 .. 5 %");
  CoreMeshSizes z;
  const double coarser = accuracy / 1e-3;  // the error grows about with the size at the corners
  if (coarser <= 1) return z.scaled(std::pow(coarser, 0.62));
  z.corner = std::min(0.12e-3 * std::pow(coarser, 0.85), 0.8e-3);
  z.other = std::min(1.5e-3 * std::sqrt(coarser), 4e-3);
  z.iron = std::min(3e-3 * std::sqrt(coarser), 6e-3);
  return z;
}

FieldProblem magnet_problem(const MagnetDesign& design, const FieldOptions& options,
                            double iron_conductivity) {
  check(design);
  return FieldProblem(core_mesh(design.shape, options.sizes, options.largest_gap),
                      setup_of(design, options, iron_conductivity));
}

MagnetField::MagnetField(const MagnetDesign& design, const FieldOptions& options)
    : design_(design), options_(options) {
  problem_ = std::make_unique<FieldProblem>(magnet_problem(design, options));
  newton_ = std::make_unique<Newton>(*problem_);
  layer_ = middle_layer(options, problem_->space().mesh);
}

MagnetField::MagnetField(const MagnetField& other)
    : design_(other.design_),
      options_(other.options_),
      problem_(std::make_unique<FieldProblem>(*other.problem_)),
      newton_(std::make_unique<Newton>(*problem_)),
      layer_(other.layer_) {}

MagnetField::~MagnetField() = default;

int MagnetField::unknowns() const {
  return problem_->size();
}

bool MagnetField::has_ring() const {
  return design_.shape.ring_share > 0;
}

const FieldProblem& MagnetField::problem() const {
  return *problem_;
}

void MagnetField::set_gap(double gap) {
  if (!(gap >= 0))
    throw std::invalid_argument("gap_mm = " + std::to_string(gap * 1e3) + ", allowed 0 and above");
  problem_->set_gap(gap + design_.residual_gap);
}

FieldPoint MagnetField::finish(std::vector<double> a, const std::vector<double>& current,
                               NewtonReport report) {
  FieldPoint p;
  p.newton = report;
  p.response.current = current[0];
  if (has_ring()) p.response.ring_current = current[1];
  p.stress_pull = -problem_->stress_force(a.data(), layer_);
  p.largest_field = problem_->largest_field(a.data());
  p.beyond_data = p.largest_field > problem_->setup().steels.front().data_end();
  p.response.energy = newton_->energy() + 0.5 * design_.end_leakage * current[0] * current[0];
  if (has_ring()) p.response.energy += 0.5 * design_.ring_leakage * current[1] * current[1];
  p.a = std::move(a);
  return p;
}

FieldPoint MagnetField::at_flux(double psi, double ring, std::vector<double> a, bool ring_open) {
  a.resize(static_cast<std::size_t>(unknowns()) + 1, 0);
  std::vector<Circuit> circuits{{true, psi, design_.end_leakage}};
  const bool bound = has_ring() && !ring_open;
  if (has_ring()) circuits.push_back({bound, bound ? ring : 0, design_.ring_leakage});
  std::vector<double> current(circuits.size(), 0);
  const auto report = newton_->solve(circuits, a, current, options_.newton);
  const auto d = newton_->derivatives(a);
  auto p = finish(std::move(a), current, report);
  auto& r = p.response;
  r.pull = d.gap;
  r.pull_gap = d.gap_gap;
  r.current_psi = d.flux_flux[0];
  r.current_gap = d.flux_gap[0];
  if (bound) {
    r.current_ring = d.flux_flux[1];
    r.ring_ring = d.flux_flux[3];
    r.ring_gap = d.flux_gap[1];
  }
  return p;
}

FieldPoint MagnetField::at_current(double current, double ring_current, std::vector<double> a) {
  a.resize(static_cast<std::size_t>(unknowns()) + 1, 0);
  std::vector<Circuit> circuits{{false, current, 0}};
  if (has_ring()) circuits.push_back({false, ring_current, 0});
  std::vector<double> currents;
  const auto report = newton_->solve(circuits, a, currents, options_.newton);
  const double pull = problem_->gap_slope(a.data());
  auto p = finish(std::move(a), currents, report);
  p.response.pull = pull;
  return p;
}

std::pair<double, double> MagnetField::fluxes(const FieldPoint& p) const {
  return {dot(problem_->winding(0), p.a) + design_.end_leakage * p.response.current,
          has_ring() ? dot(problem_->winding(1), p.a) + design_.ring_leakage * p.response.ring_current : 0};
}

std::vector<double> MagnetField::tangent(std::size_t winding) const {
  return newton_->flux_tangent(winding);
}

}  // namespace powbench::sim
