#include "sim/mechanics/rigid_parts.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace powbench::sim {
namespace {

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", v);
  return text;
}

void require(bool good, const std::string& key, double value, const std::string& range) {
  if (!good) throw std::invalid_argument("rigid: " + key + " = " + number(value) + ", allowed " + range);
}
void positive(const std::string& key, double value) {
  require(value > 0 && std::isfinite(value), key, value, "above 0");
}
void not_negative(const std::string& key, double value) {
  require(value >= 0 && std::isfinite(value), key, value, "0 and above");
}

void check_law(const std::string& key, const ContactLaw& law) {
  positive(key + ".stiffness", law.stiffness);
  require(law.exponent == 1 || law.exponent == 1.5 || law.exponent == 2, key + ".exponent", law.exponent,
          "1, 1.5 and 2");
  const bool restitution = law.form == DampingForm::flores || law.form == DampingForm::lankarani_nikravesh;
  if (restitution)
    require(law.damping > 0 && law.damping <= 1, key + ".damping", law.damping, "above 0 .. 1 (restitution)");
  else
    not_negative(key + ".damping", law.damping);
  if (law.form == DampingForm::ramped) positive(key + ".ramp", law.ramp);
}

void check_bridge(const RigidParts& p, std::size_t j) {
  const auto& b = p.bridges[j];
  const std::string key = "bridge " + std::to_string(j + 1) + ".";
  positive(key + "mass", b.mass);
  positive(key + "inertia", b.inertia);
  positive(key + "preload", b.preload);
  positive(key + "rate", b.rate);
  not_negative(key + "damping", b.damping);
  not_negative(key + "turning_rate", b.turning_rate);
  positive(key + "pad_arm", b.pad_arm);
  positive(key + "seat_arm", b.seat_arm);
  for (const double gap : b.gap)
    require(gap > 0 && gap < p.travel, key + "gap", gap,
            "above 0 (parts overlap at t = 0 otherwise), below " + number(p.travel) + " (travel)");
}

}  // namespace

void require_valid(const RigidParts& p) {
  positive("core_mass", p.core_mass);
  positive("core_inertia", p.core_inertia);
  positive("tilt_rate", p.tilt_rate);
  not_negative("tilt_damping", p.tilt_damping);
  positive("travel", p.travel);
  positive("return_preload", p.return_preload);
  positive("return_rate", p.return_rate);
  not_negative("core_damping", p.core_damping);
  not_negative("core_friction", p.core_friction);
  positive("pole_arm", p.pole_arm);
  positive("static_mass", p.static_mass);
  positive("buffer_rate", p.buffer_rate);
  not_negative("buffer_damping", p.buffer_damping);
  require(p.bridges.size() <= most_bridges, "bridges", static_cast<double>(p.bridges.size()), "0 .. 8");
  require(p.modes.size() <= most_base_modes, "modes", static_cast<double>(p.modes.size()), "0 .. 4");
  for (std::size_t j = 0; j < p.bridges.size(); ++j) check_bridge(p, j);
  for (std::size_t i = 0; i < p.modes.size(); ++i) {
    const std::string key = "mode " + std::to_string(i + 1) + ".";
    positive(key + "mass", p.modes[i].mass);
    positive(key + "hertz", p.modes[i].hertz);
    not_negative(key + "damping", p.modes[i].damping);
  }
  check_law("pad", p.pad);
  check_law("seat", p.seat);
  check_law("pole", p.pole);
  check_law("stop", p.stop);
  positive("pull.rise", p.pull.rise);
  positive("pull.range", p.pull.range);
}

}  // namespace powbench::sim
