#include "sim/mechanics/rigid_parts.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "core/units.h"

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

RigidParts without_losses(RigidParts p) {
  p.core_damping = p.core_friction = p.tilt_damping = p.buffer_damping = 0;
  for (auto& b : p.bridges) b.damping = 0;
  for (auto& m : p.modes) m.damping = 0;
  for (ContactLaw* law : {&p.pad, &p.seat, &p.pole, &p.stop}) law->form = DampingForm::none;
  return p;
}

RigidParts reference_closing(double stiffness, double damping) {
  RigidParts p;
  p.core_mass = 0.1;
  p.core_inertia = 3e-5;
  p.tilt_rate = p.core_inertia * 3.553e6;
  p.tilt_damping = 2 * 0.05 * p.core_inertia * 1885;
  const auto hertz = [&](double k, double lambda) {
    return ContactLaw{k * stiffness, 1.5, DampingForm::hunt_crossley, lambda * damping, 0};
  };
  p.pad = hertz(1e8, 0.6);
  p.seat = hertz(1e8, 0.6);
  p.pole = hertz(1e9, 1.2);
  p.stop = hertz(1e8, 1.2);
  p.pull = {160, 3e-3, 0.55, 50, 2e-3};
  const double at[5] = {-14e-3, 0, 14e-3, -24e-3, 24e-3};
  const double gap[5] = {3.00e-3, 3.02e-3, 2.98e-3, 2.2e-3, 2.25e-3};
  const double uneven[5] = {30e-6, -22e-6, 14e-6, 40e-6, -18e-6};
  for (int j = 0; j < 5; ++j) {
    const bool main = j < 3;
    RigidBridge b;
    b.mass = main ? 5e-3 : 1.2e-3;
    const double length = main ? 26e-3 : 16e-3;
    b.inertia = b.mass * length * length / 12;
    b.position = at[j];
    b.pad_arm = main ? 10e-3 : 6e-3;
    b.seat_arm = main ? 4e-3 : 3e-3;
    b.preload = main ? 4 : 0.8;
    b.rate = main ? 1200 : 400;
    b.damping = 0.05;
    b.turning_rate = b.rate * 1e-5;
    b.gap[0] = gap[j] - uneven[j];
    b.gap[1] = gap[j] + uneven[j];
    p.bridges.push_back(b);
  }
  const double frequency[4] = {820, 1530, 2900, 4800};
  for (int i = 0; i < 4; ++i) {
    BaseMode m;
    m.hertz = frequency[i];
    for (int pad = 0; pad < 10; ++pad) m.shape[pad / 2][pad % 2] = 0.5 * std::cos(0.7 * (i + 1) * (pad + 1));
    p.modes.push_back(m);
  }
  return p;
}

}  // namespace powbench::sim
