#include <bit>

#include "sim/models/contactor_model.h"
#include "sim/models/lanes/lane_block.h"

/// A contactor's numbers and modes in its lane.

namespace powbench::sim {

bool ContactorModel::lane_layout(LaneLayout& l) const {
  const bool known = supply_.feeds() && !supply_.watches() && !supply_.has_capacitor() && offset_ < 0 &&
                     supply_.mains().kind == Mains::Kind::ac && circuit_.even_power() >= 0;
  if (!known) return false;
  l = {*this, size(), circuit_.even_power()};
  return true;
}

void ContactorModel::put_numbers(LaneBlock& b, int lane) const {
  constexpr std::size_t count = sizeof n_ / sizeof(double);
  static_assert(sizeof b.numbers == count * sizeof(Lane));
  const auto list = std::bit_cast<std::array<double, count>>(n_);
  Lane* lanes = reinterpret_cast<Lane*>(&b.numbers);
  for (std::size_t i = 0; i < count; ++i) lanes[i][static_cast<std::size_t>(lane)] = list[i];
  b.friction[static_cast<std::size_t>(lane)] = specimen_.core.friction;
}

void ContactorModel::put_modes(LaneBlock& b, int lane) const {
  const auto k = static_cast<std::size_t>(lane);
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts); ++i)
    b.pressed[i][k] = contacts_[i].pressed ? -1 : 0;
  b.stick[k] = friction_.sticks() ? -1 : 0;
  b.slides[k] = friction_.slides() ? -1 : 0;
  b.way[k] = friction_.slides() && !friction_.slides_forward() ? -1 : 1;
  b.sliding_force[k] = friction_.force();
}

}  // namespace powbench::sim
