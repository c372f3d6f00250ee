#include "sim/contactor_model.h"
#include "sim/lanes/lane_block.h"

/// A contactor's numbers and modes in its lane.

namespace powbench::sim {

bool ContactorModel::lane_layout(LaneLayout& l) const {
  const auto law = circuit_.law();
  const bool known = supply_.feeds() && !supply_.watches() && !supply_.has_capacitor() && offset_ < 0 &&
                     supply_.mains().kind == Mains::Kind::ac && law.even_power >= 0;
  if (!known) return false;
  l = {};
  l.size = size(), l.ledger = ledger_, l.contacts = contact_count_, l.static_core = static_core_;
  l.groups = static_cast<int>(groups_.size());
  l.even_power = law.even_power;
  l.has_ring = circuit_.has_ring();
  for (std::size_t i = 0; i < groups_.size(); ++i)
    l.group[i] = {groups_[i].state, groups_[i].first_contact, groups_[i].tilts};
  return true;
}

void ContactorModel::put_numbers(LaneBlock& b, int lane) const {
  const auto k = static_cast<std::size_t>(lane);
  const auto law = circuit_.law();
  b.area[k] = law.area, b.iron_length[k] = law.iron_length, b.iron_per_area[k] = law.iron_length / law.area;
  b.residual[k] = law.residual, b.fringe[k] = law.fringe, b.mu0_area[k] = mu0 * law.area;
  b.share[k] = circuit_.shaded_share(), b.inverse_bare[k] = law.inverse_bare,
  b.one_bare[k] = 1 + law.inverse_bare;
  b.inverse_shaded[k] = law.inverse_shaded, b.ring_resistance[k] = circuit_.ring_resistance();
  b.linear[k] = law.linear, b.saturation[k] = law.saturation, b.exponent[k] = law.exponent;
  const auto& s = specimen_;
  b.turns[k] = s.coil.turns, b.resistance[k] = resistance_,
  b.inductance_per_turn[k] = inductance_ / s.coil.turns;
  b.travel[k] = s.core.travel, b.return_preload[k] = s.core.return_preload,
  b.return_rate[k] = s.core.return_rate;
  b.core_mass[k] = s.core.mass, b.friction[k] = s.core.friction;
  b.base_mass[k] = s.base.mass, b.base_rate[k] = base_rate_, b.base_damping[k] = base_damping_;
  b.static_mass[k] = s.base.core_mass, b.buffer_rate[k] = buffer_rate_, b.buffer_damping[k] = buffer_damping_;
  b.open_stop_depth[k] = open_stop_depth_, b.seat_depth[k] = seat_depth_;
  b.preload[k] = s.bridges.preload, b.rate[k] = s.bridges.rate, b.bridge_mass[k] = s.bridges.mass;
  b.inertia[k] = s.bridges.inertia, b.half_length[k] = s.bridges.half_length;
  b.seat_half_length[k] = s.bridges.seat_half_length, b.tilt_gap[k] = s.bridges.tilt_gap;
  for (std::size_t i = 0; i < groups_.size(); ++i)
    b.gap[i][k] = groups_[i].gap_a, b.count[i][k] = groups_[i].count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(contact_count_); ++i) {
    b.stiffness[i][k] = contacts_[i].stiffness, b.damping[i][k] = contacts_[i].damping;
    b.damping_time[i][k] = contacts_[i].damping / contacts_[i].stiffness;
  }
}

void ContactorModel::put_modes(LaneBlock& b, int lane) const {
  const auto k = static_cast<std::size_t>(lane);
  for (std::size_t i = 0; i < static_cast<std::size_t>(contact_count_); ++i)
    b.pressed[i][k] = contacts_[i].pressed ? -1 : 0;
  b.stick[k] = friction_.sticks() ? -1 : 0;
  b.slides[k] = friction_.slides() ? -1 : 0;
  b.way[k] = friction_.slides() && !friction_.slides_forward() ? -1 : 1;
  b.sliding_force[k] = friction_.force();
}

}  // namespace powbench::sim
