#include "sim/models/contactor_model.h"

#include <cmath>

/// The modes of the contactor: when they end, and what follows.

namespace powbench::sim {

void ContactorModel::reset_modes() {
  for (auto& c : contacts_) c.pressed = false;
  contacts_[1].pressed = true;
  for (int i = 0; i < groups; ++i) {
    const Group& g = group[static_cast<std::size_t>(i)];
    contacts_[static_cast<std::size_t>(g.first_contact)].pressed = true;
    if (g.tilts) contacts_[static_cast<std::size_t>(g.first_contact + 1)].pressed = true;
  }
  friction_ = CoulombFriction<double>(specimen_.core.friction);
}

void ContactorModel::guards(double t, const double* s, double* g) const {
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  for (int k = 0; k < contacts; ++k) g[k] = Equations::contact_guard_at(Alone(*this), k, pen[k], rate[k]);
  for (int k = contacts; k < guard_count(); ++k) g[k] = guard(k, t, s);
}

double ContactorModel::guard(int k, double t, const double* s) const {
  if (k == contacts) return friction_.guard(s[v], [&] { return core_force(s); });
  if (k == contacts + 1) return coil_guard(t, s);
  if (k == contacts + 2) return supply_.next_change() - t;
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  return Equations::contact_guard_at(Alone(*this), k, pen[k], rate[k]);
}

double ContactorModel::coil_guard(double t, const double* s) const {
  if (supply_.watches_open_voltage()) return supply_.guard(t, 0.0, open_voltage(s));
  return supply_.watches() ? supply_.guard(t, coil_current(s), 0.0) : 1.0;
}

void ContactorModel::flip(double t, double* s, std::uint64_t which) {
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  for (int k = 0; k < contacts; ++k)
    if ((which >> k & 1U) != 0) flip_contact(t, k, rate[k]);
  const bool by_current = (which >> (contacts + 1) & 1U) != 0;
  const bool by_time = (which >> (contacts + 2) & 1U) != 0;
  if (by_current || by_time) {
    const double before = stored_energy(s);
    if (by_current) settle_supply(t, s, supply_.pass_guard(t, current(s)), before);
    if (by_time) settle_supply(t, s, supply_.pass(t, current(s)), before);
  }
  const bool friction = (which >> contacts & 1U) != 0;
  if (friction || friction_.sticks()) flip_friction(t, s);
}

void ContactorModel::flip_contact(double t, int k, double rate) {
  auto& c = contacts_[static_cast<std::size_t>(k)];
  c.pressed = !c.pressed;
  using Kind = PlantEvent::Kind;
  const auto& measured = group.front();
  const int first = measured.first_contact;
  if (k == 0) publish(c.pressed ? Kind::core_touch : Kind::core_release, t, rate);
  const bool at_a = k == first + (measured.tilts ? 2 : 1);
  const bool at_b = measured.tilts ? k == first + 3 : at_a;
  if (at_a) publish(c.pressed ? Kind::touch_a : Kind::release_a, t, rate);
  if (at_b) publish(c.pressed ? Kind::touch_b : Kind::release_b, t, rate);
}

/// Stick, or slide in the direction of the force: called where the velocity is zero.
void ContactorModel::flip_friction(double t, double* s) {
  if (friction_.slides_forward() && !contacts_[0].pressed) publish(PlantEvent::Kind::stall, t, 0);
  s[v] = 0;
  friction_.choose(core_force(s));
}

void ContactorModel::publish(PlantEvent::Kind kind, double t, double velocity) {
  events_.push_back({kind, t, velocity});
}

ContactorModel::State ContactorModel::rest(double offset) const {
  State s{};
  if (offset_ < 0 || offset == 0) return s;
  s[static_cast<std::size_t>(offset_)] = offset;
  const double share = circuit_.shaded_share();  // the ring is at rest too
  for (int pass = 0; pass < 60; ++pass) {
    const Field f = circuit_.field(s[phi], share * s[phi], Equations::separation(Alone(*this), s.data()));
    const double change = (f.mmf + n_.turns * offset) / (f.mmf_phi + share * f.mmf_phi2);
    s[phi] -= change;
    if (std::fabs(change) <= 1e-15 * std::fabs(s[phi])) break;
  }
  s[phi2] = share * s[phi];
  return s;
}

bool ContactorModel::near_rest(const State& s) const {
  if (!supply_.sleeps()) return false;
  const State calm = rest(offset(s.data()));
  for (int i = 0; i < ledger; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool displacement = i >= x && (i - x) % 2 == 0;  // friction may hold the core a little off zero
    if (std::fabs(s[k] - calm[k]) > (displacement ? 1e-4 : 1e-5) * scale_[k]) return false;
  }
  return true;
}

void ContactorModel::set_coil(double t, double* s, bool on) {
  const double before = stored_energy(s);
  settle_supply(t, s, supply_.command(t, on, current(s)), before);
}

/// After an event of the supply: a current that was cut is brought to zero, the flux jumps to what remains without it.
void ContactorModel::settle_supply(double t, double* s, SupplyModes::Effect effect, double energy_before) {
  if (effect == SupplyModes::Effect::none) return;
  if (effect != SupplyModes::Effect::blocked) publish(PlantEvent::Kind::coil_open, t, 0);
  if (effect == SupplyModes::Effect::opened) return;
  const double turns = n_.turns;
  const double left = remove_current(remanence_, s[phi], offset(s), [&] {
    const Field f = field(s);
    const double i = f.mmf / turns, slope = Equations::mmf_stiffness(Alone(*this), f) / turns;
    return CoilPoint{i, slope, turns * s[phi] + n_.inductance * i, turns + n_.inductance * slope};
  });
  if (offset_ >= 0) s[offset_] = left;
  if (!circuit_.has_ring()) s[phi2] = circuit_.shaded_share() * s[phi];
  book_loss(s, energy_before - stored_energy(s));
}

}  // namespace powbench::sim
