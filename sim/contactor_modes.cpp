#include "sim/contactor_model.h"

#include <cmath>

/// The modes of the contactor: when they end, and what follows.

namespace powbench::sim {

void ContactorModel::reset_modes() {
  for (auto& c : contacts_) c.pressed = false;
  contacts_[1].pressed = true;
  for (const auto& g : groups_) {
    contacts_[static_cast<std::size_t>(g.first_contact)].pressed = true;
    if (g.tilts) contacts_[static_cast<std::size_t>(g.first_contact + 1)].pressed = true;
  }
  friction_ = specimen_.core.friction > 0 ? Friction::stick : Friction::none;
  coil_ = Coil::open;
}

void ContactorModel::guards(double, const double* s, double* g) const {
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  for (int k = 0; k < contact_count_; ++k)
    g[k] = contacts_[static_cast<std::size_t>(k)].guard(pen[k], rate[k]);
  double& friction = g[contact_count_];
  switch (friction_) {
    case Friction::none:
      friction = 1;
      break;
    case Friction::stick:
      friction = specimen_.core.friction - std::fabs(core_force(s));
      break;
    case Friction::forward:
      friction = s[v];
      break;
    case Friction::backward:
      friction = -s[v];
      break;
  }
  g[contact_count_ + 1] = coil_ == Coil::opening ? current_sign_ * current(s) : 1.0;
}

void ContactorModel::flip(double t, double* s, std::uint64_t which) {
  double pen[guard_capacity];
  double rate[guard_capacity];
  penetrations(s, pen, rate);
  for (int k = 0; k < contact_count_; ++k)
    if ((which >> k & 1U) != 0) flip_contact(t, k, rate[k]);
  if ((which >> (contact_count_ + 1) & 1U) != 0) {
    coil_ = Coil::open;
    publish(PlantEvent::Kind::coil_open, t, 0);
  }
  const bool friction = (which >> contact_count_ & 1U) != 0;
  if (friction || friction_ == Friction::stick) flip_friction(t, s);
}

void ContactorModel::flip_contact(double t, int k, double rate) {
  auto& c = contacts_[static_cast<std::size_t>(k)];
  c.pressed = !c.pressed;
  using Kind = PlantEvent::Kind;
  const auto& measured = groups_.front();
  const int first = measured.first_contact;
  if (k == 0) publish(c.pressed ? Kind::core_touch : Kind::core_release, t, rate);
  const bool at_a = k == first + (measured.tilts ? 2 : 1);
  const bool at_b = measured.tilts ? k == first + 3 : at_a;
  if (at_a) publish(c.pressed ? Kind::touch_a : Kind::release_a, t, rate);
  if (at_b) publish(c.pressed ? Kind::touch_b : Kind::release_b, t, rate);
}

/// Stick, or slide in the direction of the force: called where the velocity is zero.
void ContactorModel::flip_friction(double t, double* s) {
  if (friction_ == Friction::forward && !contacts_[0].pressed) publish(PlantEvent::Kind::stall, t, 0);
  s[v] = 0;
  const double force = core_force(s);
  if (std::fabs(force) <= specimen_.core.friction) {
    friction_ = Friction::stick;
  } else {
    friction_ = force > 0 ? Friction::forward : Friction::backward;
  }
}

void ContactorModel::publish(PlantEvent::Kind kind, double t, double velocity) {
  events_.push_back({kind, t, velocity});
}

bool ContactorModel::near_rest(const State& s) const {
  if (coil_ != Coil::open) return false;
  for (int i = 0; i < ledger_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool displacement = i >= x && (i - x) % 2 == 0;  // friction may hold the core a little off zero
    if (std::fabs(s[k]) > (displacement ? 1e-4 : 1e-5) * scale_[k]) return false;
  }
  return true;
}

void ContactorModel::set_coil(double t, double* s, bool on) {
  if (on) {
    coil_ = Coil::closed;
    return;
  }
  if (coil_ != Coil::closed) return;
  const double i = current(s);
  if (i == 0) {
    coil_ = Coil::open;
    publish(PlantEvent::Kind::coil_open, t, 0);
    return;
  }
  coil_ = Coil::opening;
  current_sign_ = i > 0 ? 1 : -1;
}

}  // namespace powbench::sim
