#include "sim/contactor_model.h"

#include <cmath>

#include "sim/contact_damping.h"
#include "sim/specimen_potential.h"

namespace powbench::sim {

ContactorModel::ContactorModel(const Specimen& specimen, const Mains& mains, const PlantOptions& options)
    : specimen_(specimen),
      supply_({mains, options.coil_switch, options.suppression}),
      remanence_(remanence(specimen)),
      circuit_(specimen.magnet, specimen.core.travel),
      resistance_(specimen.coil.resistance *
                      (1 + specimen.coil.temperature_coefficient * (options.coil_kelvin - 293.15)) +
                  mains.resistance),
      source_resistance_(mains.resistance),
      inductance_(specimen.coil.leakage + mains.inductance),
      open_stop_depth_(specimen.core.return_preload / specimen.core.stop_stiffness),
      seat_depth_(specimen.bridges.preload / specimen.bridges.seat_stiffness) {
  require_circuit(specimen_);
  const auto& base = specimen_.base;
  const double omega = 2 * pi * base.hertz;
  base_rate_ = base.mass * omega * omega;
  base_damping_ = 2 * base.damping * base.mass * omega;
  const double omega_core = 2 * pi * base.core_hertz;
  buffer_rate_ = base.core_mass * omega_core * omega_core;
  buffer_damping_ = 2 * base.core_damping * base.core_mass * omega_core;
  const auto& core = specimen_.core;
  const double c = stop_damping(specimen_);
  add_contact(core.stop_stiffness, c);
  add_contact(core.stop_stiffness, c);
  const double flux = circuit_.area();  // of 1 T
  scale_ = {flux, flux, 1e-3, 1, 1e-3, 1};
  add_groups();
  for (int i = 0; i < 4; ++i) scale_[static_cast<std::size_t>(ledger_ + i)] = 1;
  reset_modes();
  start_energy_ = stored_energy(rest().data());
}

int ContactorModel::add_contact(double stiffness, double damping) {
  contacts_[static_cast<std::size_t>(contact_count_)] = {stiffness, damping, false};
  return contact_count_++;
}

void ContactorModel::add_groups() {
  const auto& b = specimen_.bridges;
  const bool alike = b.gap_spread == 0;
  const double of_seat = seat_damping(specimen_), of_breaks = pad_damping(specimen_);
  int next = first_group;
  for (int pole = 0; pole < (alike ? 1 : b.poles); ++pole) {
    Group g;
    g.state = next;
    g.count = alike ? b.poles : 1;
    g.gap_a = b.gap + pole * b.gap_spread;
    g.tilts = b.tilt_gap != 0;
    const int parts = g.tilts ? 2 : 1;
    g.first_contact = contact_count_;
    for (int i = 0; i < parts; ++i) add_contact(b.seat_stiffness / parts, of_seat / parts);
    for (int i = 0; i < parts; ++i) add_contact(b.contact_stiffness / parts, of_breaks / parts);
    const auto at = static_cast<std::size_t>(next);
    scale_[at] = 1e-3;
    scale_[at + 1] = 1;
    if (g.tilts) {
      scale_[at + 2] = 1e-3 / b.half_length;
      scale_[at + 3] = 1 / b.half_length;
    }
    next += 2 * parts;
    groups_.push_back(g);
  }
  if (specimen_.base.core_mass > 0) {
    static_core_ = next;
    const auto at = static_cast<std::size_t>(next);
    scale_[at] = 1e-3;
    scale_[at + 1] = 1;
    next += 2;
  }
  if (remanence_.present()) {
    scale_[static_cast<std::size_t>(next)] = remanence_.current;
    offset_ = next++;
  }
  if (supply_.has_capacitor()) {
    scale_[static_cast<std::size_t>(next)] = 1;
    capacitor_ = next++;
  }
  ledger_ = next;
}

void ContactorModel::penetrations(const double* s, double* pen, double* rate) const {
  pen[0] = -separation(s);
  rate[0] = s[v] - s[static_core_ + 1];
  pen[1] = open_stop_depth_ - s[x];
  rate[1] = -s[v];
  const auto& b = specimen_.bridges;
  for (const auto& g : groups_) {
    const double* q = s + g.state;
    double* p = pen + g.first_contact;
    double* r = rate + g.first_contact;
    const double seat = seat_depth_ + q[0] - s[x];
    const double seat_rate = q[1] - s[v];
    const double contact = q[0] - s[z] - g.gap_a;
    const double contact_rate = q[1] - s[w];
    if (!g.tilts) {
      p[0] = seat;
      r[0] = seat_rate;
      p[1] = contact;
      r[1] = contact_rate;
      continue;
    }
    p[0] = seat + b.seat_half_length * q[2];
    r[0] = seat_rate + b.seat_half_length * q[3];
    p[1] = seat - b.seat_half_length * q[2];
    r[1] = seat_rate - b.seat_half_length * q[3];
    p[2] = contact + b.half_length * q[2];
    r[2] = contact_rate + b.half_length * q[3];
    p[3] = contact - b.half_length * q[2] - b.tilt_gap;
    r[3] = contact_rate - b.half_length * q[3];
  }
}

void ContactorModel::forces(const double* s, Forces& f) const {
  f.field = circuit_.field(s[phi], second_flux(s), separation(s));
  penetrations(s, f.pen, f.rate);
  for (int k = 0; k < contact_count_; ++k)
    f.contact[k] = contacts_[static_cast<std::size_t>(k)].force(f.pen[k], f.rate[k]);
  const auto& b = specimen_.bridges;
  f.core = f.field.pull - specimen_.core.return_preload - specimen_.core.return_rate * s[x] + f.contact[1] -
           f.contact[0];
  const double on_static_core = f.contact[0] - f.field.pull;
  const double buffer =
      floats() ? buffer_rate_ * (s[static_core_] - s[z]) + buffer_damping_ * (s[static_core_ + 1] - s[w])
               : on_static_core;
  f.static_core = on_static_core - buffer;
  f.base = buffer - base_rate_ * s[z] - base_damping_ * s[w];
  for (const auto& g : groups_) {
    const double* c = f.contact + g.first_contact;
    const double spring = b.preload + b.rate * (s[x] - s[g.state]);
    const double seat = g.tilts ? c[0] + c[1] : c[0];
    const double contact = g.tilts ? c[2] + c[3] : c[1];
    f.core += g.count * (seat - spring);
    f.base += g.count * contact;
  }
}

double ContactorModel::core_force(const double* s) const {
  Forces f;
  forces(s, f);
  return f.core;
}

double ContactorModel::mmf_stiffness(const Field& f) const {
  return circuit_.has_ring() ? f.mmf_phi : f.mmf_phi + circuit_.shaded_share() * f.mmf_phi2;
}

CoilFeed<double> ContactorModel::feed(double t, const double* s, double current) const {
  return supply_.feed(t, current, capacitor_ < 0 ? 0.0 : s[capacitor_]);
}

double ContactorModel::open_voltage(const double* s) const {
  const Field f = circuit_.field(s[phi], second_flux(s), separation(s));
  double rates[2];
  const double linkage_rate = flux_rates(f, offset(s), {}, s[static_core_ + 1] - s[v], rates);
  return offset_ < 0 ? specimen_.coil.turns * rates[phi] : linkage_rate;
}

double ContactorModel::flux_rates(const Field& f, double offset, const CoilFeed<double>& feed,
                                  double separation_rate, double* ds) const {
  const auto& coil = specimen_.coil;
  const bool ring = circuit_.has_ring();
  const double share = circuit_.shaded_share();
  ds[phi2] = ring ? -circuit_.ring_resistance() * f.ring_current : 0.0;
  const double stiffness = mmf_stiffness(f);
  const double ratio = inductance_ / coil.turns;  // L di = ratio d mmf
  double linkage_rate = 0;
  const double other = f.mmf_phi2 * ds[phi2] + f.mmf_separation * separation_rate;
  if (!supply_.conducts()) {
    double mmf_rate = 0;  // without remanence the current stays zero
    if (remanence_.present()) {
      const double turning = remanence_.stiffness(offset, other < 0);
      linkage_rate = -coil.turns * other / stiffness /
                     (1 + turning * (coil.turns * coil.turns / stiffness + inductance_));
      mmf_rate = -coil.turns * turning * linkage_rate;
    }
    ds[phi] = (mmf_rate - other) / stiffness;
  } else {
    linkage_rate = feed.linkage_rate(resistance_, f.mmf / coil.turns + offset);
    ds[phi] = (linkage_rate - ratio * other) / (coil.turns + ratio * stiffness);
  }
  if (!ring) ds[phi2] = share * ds[phi];
  return linkage_rate;
}

double ContactorModel::losses(const double* s, const Forces& f) const {
  double sum = friction_.loss(s[v]) + base_damping_ * s[w] * s[w];
  const auto lost = [&](int k) {
    return contacts_[static_cast<std::size_t>(k)].loss(f.pen[k], f.rate[k], f.contact[k]);
  };
  sum += lost(0) + lost(1);
  if (floats()) {
    const double rate = s[static_core_ + 1] - s[w];
    sum += buffer_damping_ * rate * rate;
  }
  for (const auto& g : groups_)
    for (int k = 0; k < (g.tilts ? 4 : 2); ++k) sum += g.count * lost(g.first_contact + k);
  return sum;
}

void ContactorModel::derivative(double t, const double* s, double* ds) const {
  Forces f;
  forces(s, f);
  const bool on = supply_.conducts();
  const double i = on ? f.field.mmf / specimen_.coil.turns + offset(s) : 0.0;
  const CoilFeed<double> fed = on ? feed(t, s, i) : CoilFeed<double>{};
  const double linkage_rate = flux_rates(f.field, offset(s), fed, s[static_core_ + 1] - s[v], ds);

  const auto& core = specimen_.core;
  ds[x] = s[v];
  ds[v] = friction_.net(f.core) / core.mass;
  ds[z] = s[w];
  ds[w] = f.base / specimen_.base.mass;
  if (floats()) {
    ds[static_core_] = s[static_core_ + 1];
    ds[static_core_ + 1] = f.static_core / specimen_.base.core_mass;
  }

  const auto& b = specimen_.bridges;
  for (const auto& g : groups_) {
    const double* q = s + g.state;
    double* dq = ds + g.state;
    const double* c = f.contact + g.first_contact;
    const double spring = b.preload + b.rate * (s[x] - q[0]);
    dq[0] = q[1];
    if (!g.tilts) {
      dq[1] = (spring - c[0] - c[1]) / b.mass;
      continue;
    }
    dq[1] = (spring - c[0] - c[1] - c[2] - c[3]) / b.mass;
    dq[2] = q[3];
    dq[3] = -(b.half_length * (c[2] - c[3]) + b.seat_half_length * (c[0] - c[1])) / b.inertia;
  }

  if (capacitor_ >= 0) ds[capacitor_] = fed.capacitor_rate;
  double* ledger = ds + ledger_;
  ledger[0] = fed.supplied;
  ledger[1] = fed.heat(resistance_, i);
  ledger[2] =
      circuit_.has_ring() ? circuit_.ring_resistance() * f.field.ring_current * f.field.ring_current : 0.0;
  ledger[3] = losses(s, f);
  if (offset_ < 0) return;
  ds[offset_] = remanence_.rate(s[offset_], linkage_rate);
  ledger[3] += remanence_.loss(s[offset_], linkage_rate);
}

}  // namespace powbench::sim
