#include "sim/models/contactor_model.h"

#include <cmath>

#include "sim/mechanics/contact_damping.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/specimen/specimen_remanence.h"

namespace powbench::sim {

ContactorModel::ContactorModel(const Specimen& specimen, const Mains& mains, const PlantOptions& options)
    : specimen_(specimen),
      supply_({mains, options.coil_switch, options.suppression}),
      remanence_(remanence(specimen)),
      circuit_(specimen.magnet, specimen.core.travel),
      source_resistance_(mains.resistance) {
  require_circuit(specimen_);
  set_numbers(mains, options.coil_kelvin);
  const auto& core = specimen_.core;
  const double c = stop_damping(specimen_);
  add_contact(core.stop_stiffness, c);
  add_contact(core.stop_stiffness, c);
  const double flux = circuit_.area();  // of 1 T
  scale_ = {flux, flux, 1e-3, 1, 1e-3, 1};
  add_groups();
  for (int i = 0; i < 4; ++i) scale_[static_cast<std::size_t>(ledger + i)] = 1;
  reset_modes();
  start_energy_ = stored_energy(rest().data());
}

void ContactorModel::set_numbers(const Mains& mains, double coil_kelvin) {
  const auto& s = specimen_;
  n_.circuit = circuit_.numbers();
  has_ring = circuit_.has_ring();
  n_.turns = s.coil.turns;
  n_.resistance =
      s.coil.resistance * (1 + s.coil.temperature_coefficient * (coil_kelvin - 293.15)) + mains.resistance;
  n_.inductance = s.coil.leakage + mains.inductance;
  n_.inductance_per_turn = n_.inductance / n_.turns;
  n_.travel = s.core.travel;
  n_.return_preload = s.core.return_preload;
  n_.return_rate = s.core.return_rate;
  n_.core_mass = s.core.mass;
  const double omega = 2 * pi * s.base.hertz, omega_core = 2 * pi * s.base.core_hertz;
  n_.base_mass = s.base.mass;
  n_.base_rate = s.base.mass * omega * omega;
  n_.base_damping = 2 * s.base.damping * s.base.mass * omega;
  n_.static_mass = s.base.core_mass;
  n_.buffer_rate = s.base.core_mass * omega_core * omega_core;
  n_.buffer_damping = 2 * s.base.core_damping * s.base.core_mass * omega_core;
  n_.open_stop_depth = s.core.return_preload / s.core.stop_stiffness;
  n_.seat_depth = s.bridges.preload / s.bridges.seat_stiffness;
  n_.preload = s.bridges.preload;
  n_.rate = s.bridges.rate;
  n_.bridge_mass = s.bridges.mass;
  n_.inertia = s.bridges.inertia;
  n_.half_length = s.bridges.half_length;
  n_.seat_half_length = s.bridges.seat_half_length;
  n_.tilt_gap = s.bridges.tilt_gap;
}

int ContactorModel::add_contact(double stiffness, double damping) {
  const auto k = static_cast<std::size_t>(contacts);
  contacts_[k] = {stiffness, damping, false};
  n_.stiffness[k] = stiffness;
  n_.damping[k] = damping;
  n_.damping_time[k] = damping / stiffness;
  return contacts++;
}

void ContactorModel::add_groups() {
  const auto& b = specimen_.bridges;
  const bool alike = b.gap_spread == 0;
  const double of_seat = seat_damping(specimen_), of_breaks = pad_damping(specimen_);
  int next = first_group;
  for (int pole = 0; pole < (alike ? 1 : b.poles); ++pole) {
    const auto number = static_cast<std::size_t>(groups++);
    Group& g = group[number];
    g.state = next;
    n_.count[number] = alike ? b.poles : 1;
    n_.gap[number] = b.gap + pole * b.gap_spread;
    g.tilts = b.tilt_gap != 0;
    const int parts = g.tilts ? 2 : 1;
    g.first_contact = contacts;
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
  }
  if (specimen_.base.core_mass > 0) {
    static_core = next;
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
  ledger = next;
}

void ContactorModel::penetrations(const double* s, double* pen, double* rate) const {
  Equations::penetrations(Alone(*this), s, pen, rate);
}

void ContactorModel::forces(const double* s, Forces& f) const {
  Equations::forces(Alone(*this), s, f);
}

Field ContactorModel::field(const double* s) const {
  return Equations::field(Alone(*this), s);
}

double ContactorModel::core_force(const double* s) const {
  Forces f;
  forces(s, f);
  return f.core;
}

CoilFeed<double> ContactorModel::feed(double t, const double* s, double current) const {
  return supply_.feed(t, current, capacitor_ < 0 ? 0.0 : s[capacitor_]);
}

double ContactorModel::open_voltage(const double* s) const {
  double rates[2];
  const double linkage_rate = flux_rates(field(s), s, {}, rates);
  return offset_ < 0 ? n_.turns * rates[phi] : linkage_rate;
}

double ContactorModel::flux_rates(const Field& f, const double* s, const CoilFeed<double>& feed,
                                  double* ds) const {
  const Alone alone(*this);
  const double second_rate = Equations::ring_rate(alone, f);
  const double other = Equations::other_rate(alone, f, second_rate, s);
  double linkage_rate = 0;
  if (!supply_.conducts()) {
    const double stiffness = Equations::mmf_stiffness(alone, f);
    double mmf_rate = 0;  // without remanence the current stays zero
    if (remanence_.present()) {
      const double turning = remanence_.stiffness(offset(s), other < 0);
      linkage_rate =
          -n_.turns * other / stiffness / (1 + turning * (n_.turns * n_.turns / stiffness + n_.inductance));
      mmf_rate = -n_.turns * turning * linkage_rate;
    }
    ds[phi] = (mmf_rate - other) / stiffness;
  } else {
    linkage_rate = feed.linkage_rate(n_.resistance, f.mmf / n_.turns + offset(s));
    ds[phi] = Equations::first_rate(alone, f, linkage_rate, other);
  }
  ds[phi2] = has_ring ? second_rate : n_.circuit.share * ds[phi];
  return linkage_rate;
}

void ContactorModel::derivative(double t, const double* s, double* ds) const {
  Forces f;
  forces(s, f);
  const bool on = supply_.conducts();
  const double i = on ? f.field.mmf / n_.turns + offset(s) : 0.0;
  const CoilFeed<double> fed = on ? feed(t, s, i) : CoilFeed<double>{};
  const double linkage_rate = flux_rates(f.field, s, fed, ds);
  Equations::rates(Alone(*this), s, f, ds);
  if (capacitor_ >= 0) ds[capacitor_] = fed.capacitor_rate;
  double* booked = ds + ledger;
  booked[0] = fed.supplied;
  booked[1] = fed.heat(n_.resistance, i);
  if (offset_ < 0) return;
  ds[offset_] = remanence_.rate(s[offset_], linkage_rate);
  booked[3] += remanence_.loss(s[offset_], linkage_rate);
}

}  // namespace powbench::sim
