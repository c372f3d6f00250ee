#include "sim/models/contactor_model.h"

#include <algorithm>
#include <cmath>

/// What the contactor shows: current, energies, samples.

namespace powbench::sim {

double ContactorModel::current(const double* s) const {
  return supply_.conducts() ? coil_current(s) : 0.0;
}

double ContactorModel::coil_current(const double* s) const {
  return field(s).mmf / n_.turns + offset(s);
}

double ContactorModel::current_rate(const Field& f, double separation_rate, const double* rates) const {
  return (f.mmf_phi * rates[phi] + f.mmf_phi2 * rates[phi2] + f.mmf_separation * separation_rate) / n_.turns;
}

double ContactorModel::stored_energy(const double* s) const {
  const auto& b = specimen_.bridges;
  const auto& core = specimen_.core;
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  const double leaking = offset_ < 0 ? current(s) : coil_current(s) - s[offset_];  // that the potential sees
  double e = field(s).energy + 0.5 * n_.inductance * leaking * leaking + remanence_.stored(offset(s));
  if (capacitor_ >= 0) e += 0.5 * supply_.capacitance() * s[capacitor_] * s[capacitor_];
  e += 0.5 * core.mass * s[v] * s[v] + s[x] * (core.return_preload + 0.5 * core.return_rate * s[x]);
  e += 0.5 * specimen_.base.mass * s[w] * s[w] + 0.5 * n_.base_rate * s[z] * s[z];
  if (floats()) {
    const double squeeze = s[static_core] - s[z];
    const double speed = s[static_core + 1];
    e += 0.5 * specimen_.base.core_mass * speed * speed + 0.5 * n_.buffer_rate * squeeze * squeeze;
  }
  e += contacts_[0].stored(pen[0]) + contacts_[1].stored(pen[1]) - contacts_[1].stored(n_.open_stop_depth);
  for (int i = 0; i < groups; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const Group& g = group[j];
    const double* q = s + g.state;
    const double squeeze = s[x] - q[0];
    double one = 0.5 * b.mass * q[1] * q[1] + squeeze * (b.preload + 0.5 * b.rate * squeeze);
    if (g.tilts) one += 0.5 * b.inertia * q[3] * q[3];
    const int parts = g.tilts ? 2 : 1;
    for (int k = 0; k < 2 * parts; ++k) {
      const int at = g.first_contact + k;
      const auto& c = contacts_[static_cast<std::size_t>(at)];
      one += c.stored(pen[at]) - (k < parts ? c.stored(n_.seat_depth) : 0.0);
    }
    e += n_.count[j] * one;
  }
  return e;
}

double ContactorModel::energy_residual(const double* s) const {
  const double* l = s + ledger;
  const double stored = stored_energy(s) - start_energy_, lost = l[1] + l[2] + l[3];
  // early on the coil may have given back nearly all it took: the work of the return spring is the least scale
  const double least = specimen_.core.return_preload * specimen_.core.travel;
  return std::fabs(l[0] - lost - stored) / std::max({std::fabs(l[0]), std::fabs(stored), lost, least, 1e-6});
}

void ContactorModel::sample(double t, const double* s, PlantSample& out) const {
  Forces f;
  forces(s, f);
  const bool on = supply_.conducts();
  const auto& measured = group.front();
  const double* c = f.contact + measured.first_contact;
  out.time = t;
  out.mains_voltage = supply_.voltage_at(t);
  out.coil_current = on ? f.field.mmf / n_.turns + offset(s) : 0.0;
  const double leaking = offset_ < 0 ? out.coil_current : f.field.mmf / n_.turns;
  out.flux_linkage = n_.turns * s[phi] + specimen_.coil.leakage * leaking;
  const double apart = s[static_core + 1] - s[v];
  double rates[2];
  if (on) {
    const auto fed = feed(t, s, out.coil_current);
    const bool alternating = supply_.mains().kind == Mains::Kind::ac && supply_.feeds();
    out.coil_voltage = (alternating ? out.mains_voltage : fed.emf) -
                       (source_resistance_ + fed.resistance) * out.coil_current;
    const double source_inductance = supply_.mains().inductance;
    if (source_inductance > 0) {
      flux_rates(f.field, s, {.emf = out.mains_voltage}, rates);
      out.coil_voltage -= source_inductance * current_rate(f.field, apart, rates);
    }
  } else {
    const double linkage_rate = flux_rates(f.field, s, {}, rates);
    out.coil_voltage = offset_ < 0 ? n_.turns * rates[phi] : linkage_rate;
  }
  out.pull = f.field.pull;
  out.travel = s[x];
  out.core_velocity = s[v];
  out.base = s[z];
  out.base_acceleration = f.base / specimen_.base.mass;
  out.core_force = std::max(f.contact[0], 0.0);
  out.force_a = std::max(measured.tilts ? c[2] : 0.5 * c[1], 0.0);
  out.force_b = std::max(measured.tilts ? c[3] : 0.5 * c[1], 0.0);
}

}  // namespace powbench::sim
