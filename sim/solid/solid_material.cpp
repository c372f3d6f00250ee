#include "sim/solid/solid_material.h"

#include <stdexcept>

namespace powbench::sim {

void check_material(const SolidMaterial& m) {
  const auto need = [&](bool good, const char* key, double value, const char* range) {
    if (!good)
      throw std::invalid_argument("material '" + m.name + "': " + key + " = " + std::to_string(value) +
                                  ", must be " + range);
  };
  need(m.density > 0, "density", m.density, "> 0 kg/m3");
  need(m.young > 0, "young", m.young, "> 0 Pa");
  need(m.poisson > -1 && m.poisson < 0.5, "poisson", m.poisson, "in (-1, 0.5)");
  need(m.yield > 0, "yield", m.yield, "> 0 Pa");
  need(m.hardening >= 0, "hardening", m.hardening, ">= 0 Pa");
  need(m.hourglass > 0 && m.hourglass <= 2, "hourglass", m.hourglass, "in (0, 2]");
  need(m.damping >= 0, "damping", m.damping, ">= 0 1/s");
  need(!m.small_displacement || !(m.yield < std::numeric_limits<double>::infinity()), "yield", m.yield,
       "infinite with small_displacement");
}

SolidMaterial known_material(const std::string& name) {
  SolidMaterial m;
  m.name = name;
  const auto with = [&](double density, double young, double poisson) {
    m.density = density;
    m.young = young;
    m.poisson = poisson;
    return m;
  };
  if (name == "steel") return with(7850, 2.1e11, 0.3);
  if (name == "electrical_steel") return with(7650, 1.9e11, 0.28);
  if (name == "copper") return with(8930, 1.2e11, 0.34);
  if (name == "silver") return with(10490, 8.3e10, 0.37);
  if (name == "polyamide") return with(1370, 8.5e9, 0.38);
  throw std::invalid_argument("material = '" + name +
                              "': unknown; one of steel, electrical_steel, copper, silver, polyamide");
}

}  // namespace powbench::sim
