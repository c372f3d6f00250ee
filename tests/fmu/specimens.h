#pragma once

#include <random>
#include <string>
#include <vector>

#include "core/conditions.h"
#include "core/units.h"
#include "sim/models/rigid_closing.h"

/// Contactors of different kinds, and their native closings.

namespace powbench::test {

struct NamedSpecimen {
  std::string name;
  sim::Specimen specimen;
};

inline std::vector<NamedSpecimen> kinds_of_contactor() {
  std::vector<NamedSpecimen> all{{"reference", {}}};
  auto next = [&](const char* name) -> sim::Specimen& {
    all.push_back({name, {}});
    return all.back().specimen;
  };
  auto& tilted = next("tilted bridges, spread poles");
  tilted.bridges.tilt_gap = 0.1e-3, tilted.bridges.gap_spread = 0.05e-3;
  auto& hertz = next("Hertz contacts");
  hertz.bridges.contact_exponent = 1.5, hertz.core.stop_exponent = 1.5;
  auto& buffered = next("static core on a buffer, remanence");
  buffered.base.core_mass = 0.15, buffered.base.mass = 0.3;
  buffered.magnet.coercive_field = 60;
  auto& bending = next("tilting core, bending housing, one pole");
  bending.core.tilt_inertia = 2e-5, bending.bridges.pitch = 15e-3, bending.base.flex_modes = 2;
  bending.bridges.poles = 1;
  return all;
}

inline Conditions conditions_at(double degrees, double volts = 230) {
  Conditions c;
  c.supply_volts = volts;
  c.mains_hertz = 50;
  c.closing_angle = degrees * pi / 180;
  c.hold_time = 1;
  return c;
}

}  // namespace powbench::test
