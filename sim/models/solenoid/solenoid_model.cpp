#include "sim/models/solenoid/solenoid_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "sim/supply/series_inductance.h"

namespace powbench::sim {
namespace {

/// Throws where a supply does not suit a solenoid; then as for every supply.
const Supply& suited(const SolenoidSpecimen& s, const Supply& supply) {
  require_valid(s);
  if (supply.mains.kind == Mains::Kind::ac)
    throw std::invalid_argument(
        "supply.kind = ac, allowed dc, half_wave, full_wave for a solenoid: its iron is solid");
  if (supply.mains.inductance > 0 && s.coil.hold_turns > 0)
    throw std::invalid_argument("supply.inductance_mH: allowed 0 with a hold winding");
  require_valid(supply);
  return supply;
}

}  // namespace

SolenoidModel::SolenoidModel(const SolenoidSpecimen& specimen, const MagneticPotential& potential,
                             const Supply& supply, double coil_kelvin)
    : specimen_(specimen), potential_(&potential), supply_(suited(specimen, supply)) {
  if (supply.mains.inductance > 0) {
    with_source_ = std::make_shared<SeriesInductance>(potential, supply.mains.inductance);
    potential_ = with_source_.get();
  }
  const auto& c = specimen.coil;
  const double warm = 1 + c.temperature_coefficient * (coil_kelvin - 293.15);
  source_resistance_ = supply.mains.resistance;
  resistance_ = c.resistance * warm + source_resistance_;
  hold_resistance_ = resistance_ + c.hold_resistance * warm;
  hold_ratio_ = 1 + c.hold_turns / specimen.design.turns;
  const auto& p = specimen.plunger;
  open_depth_ = (p.return_preload + p.load) / p.stop_stiffness;
  for (auto& stop : stops_)
    stop =
        Unilateral::with_ratio(p.stop_stiffness, rebound_damping_ratio(p.stop_restitution), p.moving_mass());
  stops_[open_stop].pressed = true;
  friction_ = CoulombFriction<double>(p.friction);
  // Wb at 1 T in the plunger, m, m/s
  const double radius = specimen.design.shape.plunger_radius;
  scale_.fill(1);
  scale_[psi] = specimen.design.turns * pi * radius * radius;
  scale_[x] = 1e-3;
  if (supply_.has_capacitor()) capacitor_ = ledger_++;
  start_energy_ = stored_energy(rest().data());
}

MagneticResponse SolenoidModel::field(const double* s) const {
  const auto r = potential_->at({s[psi], 0, specimen_.travel() - s[x]});
  ++states_;
  // an open stop gives by micrometres: that is not meant
  constexpr double compliance = 0.1e-3;  // m
  const bool at_open_stop = s[x] < 0 && s[x] > -compliance;
  beyond_ += r.beyond && !at_open_stop ? 1 : 0;
  return r;
}

SolenoidModel::Forces SolenoidModel::forces(const double* s) const {
  const auto& p = specimen_.plunger;
  Forces f;
  f.field = field(s);
  f.closed = stops_[closed_stop].force(s[x] - specimen_.travel(), s[v]);
  f.open = stops_[open_stop].force(open_depth_ - s[x], -s[v]);
  f.sum = f.field.pull - p.return_preload - p.load - p.return_rate * s[x] + f.open - f.closed;
  return f;
}

double SolenoidModel::current(const double* s) const {
  return supply_.conducts() ? field(s).current / turns_ratio() : 0.0;
}

double SolenoidModel::open_rate(const MagneticResponse& r, double velocity) const {
  return r.current_gap * velocity / r.current_psi;
}

void SolenoidModel::derivative(double t, const double* s, double* ds) const {
  const auto& p = specimen_.plunger;
  const Forces f = forces(s);
  ds[x] = friction_.sticks() ? 0 : s[v];
  ds[v] = friction_.net(f.sum) / p.moving_mass();
  CoilFeed<double> feed;
  double i = 0;
  if (supply_.conducts()) {
    i = f.field.current / turns_ratio();
    feed = supply_.feed(t, i, capacitor_ < 0 ? 0.0 : s[capacitor_]);
    ds[psi] = feed.linkage_rate(resistance(), i) / turns_ratio();
  } else {
    ds[psi] = open_rate(f.field, ds[x]);
  }
  if (capacitor_ >= 0) ds[capacitor_] = feed.capacitor_rate;
  ds[ledger_] = feed.supplied;
  ds[ledger_ + 1] = feed.heat(resistance(), i);
  ds[ledger_ + 2] = friction_.loss(ds[x]) +
                    stops_[closed_stop].loss(s[x] - specimen_.travel(), s[v], f.closed) +
                    stops_[open_stop].loss(open_depth_ - s[x], -s[v], f.open);
}

void SolenoidModel::guards(double t, const double* s, double* g) const {
  g[closed_stop] = stops_[closed_stop].guard(s[x] - specimen_.travel(), s[v]);
  g[open_stop] = stops_[open_stop].guard(open_depth_ - s[x], -s[v]);
  g[friction_guard] = friction_.guard(s[v], [&] { return forces(s).sum; });
  g[current_guard] = 1;
  if (supply_.watches_open_voltage())
    g[current_guard] = supply_.guard(t, 0.0, turns_ratio() * open_rate(field(s), s[v]));
  else if (supply_.watches())
    g[current_guard] = supply_.guard(t, field(s).current / turns_ratio(), 0.0);
  g[clock_guard] = supply_.next_change() - t;
  g[tap_guard] = 1;
  if (specimen_.coil.hold_turns > 0) {
    const double past = s[x] - specimen_.coil.hold_from;
    g[tap_guard] = tapped_ ? past : -past;
  }
}

void SolenoidModel::flip(double t, double* s, std::uint64_t which) {
  using Kind = SolenoidEvent::Kind;
  const auto set = [&](int guard) { return (which >> guard & 1U) != 0; };
  for (const int k : {closed_stop, open_stop}) {
    if (!set(k)) continue;
    auto& stop = stops_[static_cast<std::size_t>(k)];
    stop.pressed = !stop.pressed;
    const Kind kind = k == closed_stop ? (stop.pressed ? Kind::seat : Kind::unseat)
                                       : (stop.pressed ? Kind::back : Kind::start);
    publish(kind, t, std::fabs(s[v]));
  }
  if (set(tap_guard)) {
    tapped_ = !tapped_;
    publish(Kind::tap, t, std::fabs(s[v]));
  }
  if (set(current_guard)) settle_supply(s, supply_.pass_guard(t, current(s)));
  if (set(clock_guard)) settle_supply(s, supply_.pass(t, current(s)));
  if (!set(friction_guard) && !friction_.sticks()) return;
  s[v] = 0;
  friction_.choose(forces(s).sum);
}

void SolenoidModel::set_coil(double t, double* s, bool on) {
  const double i = current(s);
  if (!on) publish(SolenoidEvent::Kind::coil_off, t, std::fabs(s[v]));
  settle_supply(s, supply_.command(t, on, i));
}

/// The flux at which the coil carries no current, by Newton.
void SolenoidModel::remove_current(double* s) const {
  for (int pass = 0; pass < 60; ++pass) {
    const auto r = field(s);
    const double change = r.current / r.current_psi;
    s[psi] -= change;
    if (std::fabs(change) <= 1e-12 * scale_[psi]) break;
  }
}

SolenoidModel::State SolenoidModel::rest() const {
  State s{};
  for (int pass = 0; pass < 3; ++pass) {  // the magnet's pull relieves the open stop by micrometres
    remove_current(s.data());
    s[x] = std::clamp(field(s.data()).pull / specimen_.plunger.stop_stiffness, 0.0, open_depth_);
  }
  return s;
}

/// A current that was cut is brought to zero; what the field loses is booked.
void SolenoidModel::settle_supply(double* s, SupplyModes::Effect effect) {
  if (effect == SupplyModes::Effect::none || effect == SupplyModes::Effect::opened) return;
  const double before = field(s).energy;
  remove_current(s);
  s[ledger_ + 1] += before - field(s).energy;
}

double SolenoidModel::stored_energy(const double* s) const {
  const auto& p = specimen_.plunger;
  const double c = capacitor_ < 0 ? 0.0 : s[capacitor_];
  return field(s).energy + 0.5 * supply_.capacitance() * c * c + 0.5 * p.moving_mass() * s[v] * s[v] +
         (p.return_preload + p.load + 0.5 * p.return_rate * s[x]) * s[x] +
         stops_[closed_stop].stored(s[x] - specimen_.travel()) +
         stops_[open_stop].stored(open_depth_ - s[x]) - stops_[open_stop].stored(open_depth_);
}

double SolenoidModel::energy_residual(const double* s) const {
  const double supplied = s[ledger_], lost = s[ledger_ + 1] + s[ledger_ + 2],
               stored = stored_energy(s) - start_energy_;
  return std::fabs(supplied - lost - stored) /
         std::max({std::fabs(supplied), std::fabs(lost), std::fabs(stored), 1e-3});
}

void SolenoidModel::sample(double t, const double* s, SolenoidSample& out) const {
  double ds[capacity];
  derivative(t, s, ds);
  const Forces f = forces(s);
  const double i = supply_.conducts() ? f.field.current / turns_ratio() : 0.0;
  out.time = t;
  out.source_voltage = supply_.voltage_at(t);
  out.coil_voltage = turns_ratio() * ds[psi] + (resistance() - source_resistance_) * i;
  out.current = i;
  out.flux_linkage = s[psi];
  if (with_source_) out.flux_linkage -= supply_.mains().inductance * i;
  out.pull = f.field.pull;
  out.travel = s[x];
  out.velocity = s[v];
  out.stop_force = f.closed;
}

}  // namespace powbench::sim
