#include "sim/mechanics/contact_damping.h"

#include <cmath>

#include "sim/mechanics/unilateral.h"

namespace powbench::sim {
namespace {

double effective(double a, double b) {
  return a * b / (a + b);
}

double damping_for(double rebound, double stiffness, double mass) {
  return 2 * rebound_damping_ratio(rebound) * std::sqrt(stiffness * mass);
}

/// Damping ratio whose free oscillation, which may pull, returns with e: what files before version 0.1 meant.
double former_ratio(double e) {
  if (e <= 0) return 1;
  const double log_e = std::log(e);
  return -log_e / std::sqrt(pi * pi + log_e * log_e);
}

}  // namespace

double pad_mass(const Specimen& s) {
  return effective(s.bridges.mass, s.base.mass);
}
double stop_mass(const Specimen& s) {
  return effective(s.core.mass, s.base.core_mass > 0 ? s.base.core_mass : s.base.mass);
}
double seat_mass(const Specimen& s) {
  return effective(s.bridges.mass, s.core.mass);
}

double pad_damping(const Specimen& s) {
  return damping_for(s.bridges.contact_restitution, s.bridges.contact_stiffness, pad_mass(s));
}
double stop_damping(const Specimen& s) {
  return damping_for(s.core.stop_restitution, s.core.stop_stiffness, stop_mass(s));
}
double seat_damping(const Specimen& s) {
  return 2 * s.bridges.seat_damping * std::sqrt(s.bridges.seat_stiffness * seat_mass(s));
}

double stop_rest_depth(const Specimen& s) {
  const auto& c = s.core;
  if (c.stop_exponent == 1) return c.return_preload / c.stop_stiffness;
  return c.stop_depth * std::pow(c.return_preload / (c.stop_stiffness * c.stop_depth), 1 / c.stop_exponent);
}

std::string rigid_only(const Specimen& s) {
  const auto sentence = [](const char* key, const char* allowed) {
    return std::string(key) + ": allowed " + allowed +
           " where the plant simulates (simulated rig, sweep, describe); sim, ladder and fit know more with "
           "--mechanics rigid";
  };
  if (s.bridges.contact_exponent != 1) return sentence("bridges.contact_exponent", "1");
  if (s.core.stop_exponent != 1) return sentence("core.stop_exponent", "1");
  if (s.base.flex_modes > 0) return sentence("base.flex_modes", "0");
  if (s.core.tilt_inertia > 0) return sentence("core.tilt_inertia_g_mm2", "0");
  return "";
}

Specimen with_rebounds(Specimen s) {
  auto& b = s.bridges;
  b.contact_restitution =
      rebound_ratio(former_ratio(b.contact_restitution) * std::sqrt(b.mass / pad_mass(s)));
  s.core.stop_restitution =
      rebound_ratio(former_ratio(s.core.stop_restitution) * std::sqrt(s.core.mass / stop_mass(s)));
  b.seat_damping *= std::sqrt(b.mass / seat_mass(s));
  return s;
}

}  // namespace powbench::sim
