#include "sim/magnetics/plane/magnet_field.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

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

CoreGap::CoreGap(const MagnetDesign& design, const FieldOptions& options)
    : GapField(magnet_problem(design, options), design.end_leakage, design.ring_leakage),
      residual_gap_(design.residual_gap),
      layer_(middle_layer(options, problem_.space().mesh)) {}

void CoreGap::set_gap(double gap) {
  if (!(gap >= 0))
    throw std::invalid_argument("gap_mm = " + std::to_string(gap * 1e3) + ", allowed 0 and above");
  problem_.set_gap(gap + residual_gap_);
}

double CoreGap::pull(const std::vector<double>& a, std::vector<double>& slope) const {
  slope.resize(a.size());
  problem_.gap_gradient(a.data(), slope.data());
  return problem_.gap_slope(a.data());
}

double CoreGap::stress_pull(const std::vector<double>& a) const {
  return -problem_.stress_force(a.data(), layer_);
}

MagnetField::MagnetField(const MagnetDesign& design, const FieldOptions& options)
    : gap_(design, options), options_(options.newton), newton_(gap_.problem()) {}

MagnetField::MagnetField(const MagnetField& other)
    : gap_(other.gap_), options_(other.options_), newton_(gap_.problem()) {}

FieldPoint MagnetField::at_flux(double psi, double ring, std::vector<double> start, bool ring_open) {
  auto p = state_in(gap_.with_fluxes(psi, ring, ring_open), gap_, newton_, std::move(start), options_);
  p.response.pull_gap = newton_.gap_gap(p.a);
  return p;
}

FieldPoint MagnetField::at_current(double current, double ring_current, std::vector<double> start) {
  return state_in(gap_.with_currents(current, ring_current), gap_, newton_, std::move(start), options_);
}

}  // namespace powbench::sim
