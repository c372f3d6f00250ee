#include "sim/study/parameter.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {
namespace {

struct Bound {
  const char* name;
  double low, high;  ///< in the unit of the key
  bool logarithmic = false;
};

constexpr Bound catalogue[] = {
    {"coil.turns", 1600, 4500},
    {"coil.resistance_ohm", 180, 700},
    {"coil.leakage_H", 0.1, 1.5},
    {"magnet.pole_area_mm2", 150, 360},
    {"magnet.residual_gap_um", 20, 120},
    {"magnet.fringing", 0.3, 2.5},
    {"magnet.shaded_share", 0.25, 0.8},
    {"magnet.ring_resistance_ohm", 1e-4, 3e-3, true},
    {"core.mass_g", 60, 300},
    {"core.travel_mm", 3.82, 6.0},
    {"core.return_preload_N", 3, 16},
    {"core.return_rate_N_per_m", 50, 3000},
    {"core.friction_N", 0.1, 5},
    {"core.stop_stiffness_N_per_m", 5e6, 3e8, true},
    {"core.stop_restitution", 0.06, 0.46, true},
    {"bridges.gap_mm", 2.0, 4.0},
    {"bridges.mass_g", 3, 12},
    {"bridges.preload_N", 1.5, 8},
    {"bridges.rate_N_per_m", 300, 6000},
    {"bridges.contact_stiffness_N_per_m", 4e5, 7e6, true},
    {"bridges.contact_restitution", 0.32, 0.81},
    {"bridges.seat_stiffness_N_per_m", 5e5, 5e6, true},
    {"bridges.seat_damping", 0.02, 0.6},
    {"base.mass_g", 100, 900, true},
    {"base.mode_Hz", 40, 400, true},
    {"base.damping", 0.005, 0.4, true},
};

constexpr Bound of_motion[] = {
    {"coil.leakage_H", 0.05, 1.5, true},
    {"base.mass_g", 30, 300, true},
};

constexpr Bound buffer[] = {
    {"base.core_mass_g", 80, 320},
    {"base.core_mode_Hz", 60, 800, true},
    {"base.core_damping", 0.02, 0.6},
};

}  // namespace

double Parameter::value_at(double coordinate) const {
  const double u = std::clamp(coordinate, 0.0, 1.0);
  return logarithmic ? low * std::pow(high / low, u) : low + u * (high - low);
}

double Parameter::coordinate_of(double value) const {
  if (logarithmic) return std::clamp(std::log(std::max(value, low) / low) / std::log(high / low), 0.0, 1.0);
  return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

const SpecimenField& specimen_field(std::string_view name) {
  for (const auto& f : specimen_fields())
    if (name.size() == f.section.size() + 1 + f.key.size() && name.starts_with(f.section) &&
        name[f.section.size()] == '.' && name.ends_with(f.key))
      return f;
  throw std::invalid_argument("parameter = " + std::string(name) +
                              ": not a number of a specimen; allowed are section.key of the specimen file, "
                              "such as core.mass_g");
}

Parameter parameter(std::string_view name, double low, double high, bool logarithmic) {
  const SpecimenField& f = specimen_field(name);
  const auto fail = [&](const std::string& allowed) {
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(low) + " .. " +
                                std::to_string(high) + ": allowed " + allowed);
  };
  if (!(low < high)) fail("ascending bounds");
  if (!(low >= f.low && high <= f.high)) fail(std::to_string(f.low) + " .. " + std::to_string(f.high));
  if (logarithmic && !(low > 0)) fail("above 0 for a logarithmic parameter");
  return {&f, low * f.si_per_unit, high * f.si_per_unit, logarithmic};
}

Specimen specimen_at(const Specimen& base, std::span<const Parameter> parameters,
                     std::span<const double> point) {
  Specimen s = base;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i].field->set(s, parameters[i].value_at(point[i]));
  return s;
}

std::vector<double> point_of(const Specimen& s, std::span<const Parameter> parameters) {
  std::vector<double> point;
  for (const auto& p : parameters) point.push_back(p.coordinate_of(p.field->get(s)));
  return point;
}

std::vector<Parameter> catalogue_parameters(bool buffered) {
  std::vector<Parameter> list;
  for (const auto& b : catalogue) list.push_back(parameter(b.name, b.low, b.high, b.logarithmic));
  if (!buffered) return list;
  for (const auto& b : buffer) list.push_back(parameter(b.name, b.low, b.high, b.logarithmic));
  return list;
}

std::vector<Parameter> posterior_parameters() {
  auto list = catalogue_parameters();
  for (const auto& b : of_motion)
    for (auto& p : list)
      if (p.field == &specimen_field(b.name)) p = parameter(b.name, b.low, b.high, b.logarithmic);
  return list;
}

}  // namespace powbench::sim
