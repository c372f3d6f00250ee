#include "sim/models/solenoid/solenoid_specimen.h"

#include <cstdio>
#include <stdexcept>

namespace powbench::sim {

void require_valid(const SolenoidSpecimen& s) {
  check_solenoid(s.design.shape, s.travel() + s.design.residual_gap);
  const auto need = [](bool holds, const char* key, double value, const std::string& range) {
    if (holds) return;
    char text[200];
    std::snprintf(text, sizeof text, "%s = %.6g, allowed %s", key, value, range.c_str());
    throw std::invalid_argument(text);
  };
  need(s.design.remanence == 0 || s.design.shape.magnet_length > 0, "magnet.remanence_T", s.design.remanence,
       "0 without magnet_length_mm");
  const auto& p = s.plunger;
  need(p.mass > 0, "plunger.mass_g", p.mass * 1e3, "above 0");
  need(p.return_preload + p.load >= 0, "plunger.load_N", p.load,
       "-return_preload_N and above: else the plunger closes without current");
  need(p.stop_restitution >= 0.01 && p.stop_restitution <= 1, "plunger.stop_restitution", p.stop_restitution,
       "0.01 .. 1");
  const auto& c = s.coil;
  need(c.resistance > 0, "coil.resistance_ohm", c.resistance, "above 0");
  if (c.hold_turns == 0) {
    need(c.hold_resistance == 0, "coil.hold_resistance_ohm", c.hold_resistance, "0 without hold_turns");
    need(c.hold_from == 0, "coil.hold_from_mm", c.hold_from * 1e3, "0 without hold_turns");
    return;
  }
  need(c.hold_turns > 0, "coil.hold_turns", c.hold_turns, "0 and above");
  need(c.hold_from > 0 && c.hold_from < s.travel(), "coil.hold_from_mm", c.hold_from * 1e3,
       "above 0, below travel_mm");
}

}  // namespace powbench::sim
