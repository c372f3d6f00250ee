#include "bench/fields/blend.h"

#include <stdexcept>
#include <utility>

namespace powbench::bench {

using namespace sim;

BlendedPotential::BlendedPotential(std::shared_ptr<const MagneticPotential> small_gaps,
                                   std::shared_ptr<const MagneticPotential> large_gaps, double from,
                                   double to)
    : small_(std::move(small_gaps)), large_(std::move(large_gaps)), from_(from), to_(to) {
  if (!(from >= 0 && to > from))
    throw std::invalid_argument("blend of two rungs: from >= 0 and to > from are needed");
  if (small_->has_ring() != large_->has_ring())
    throw std::invalid_argument("blend of two rungs: one has a shading ring, the other has none");
}

MagneticResponse BlendedPotential::at(const MagneticState& state) const {
  if (state.gap <= from_) return small_->at(state);
  if (state.gap >= to_) return large_->at(state);
  const double h = 1 / (to_ - from_), x = (state.gap - from_) * h;
  const double s = x * x * x * (10 - 15 * x + 6 * x * x);
  const double s1 = 30 * x * x * (1 - x) * (1 - x) * h;
  const double s2 = 60 * x * (1 - x) * (1 - 2 * x) * h * h;
  const auto a = small_->at(state), b = large_->at(state);
  const auto mix = [&](double MagneticResponse::*f) { return (1 - s) * a.*f + s * b.*f; };
  MagneticResponse r;
  for (const auto f :
       {&MagneticResponse::energy, &MagneticResponse::current, &MagneticResponse::ring_current,
        &MagneticResponse::current_psi, &MagneticResponse::current_ring, &MagneticResponse::ring_ring})
    r.*f = mix(f);
  r.pull = mix(&MagneticResponse::pull) + s1 * (b.energy - a.energy);
  r.current_gap = mix(&MagneticResponse::current_gap) + s1 * (b.current - a.current);
  r.ring_gap = mix(&MagneticResponse::ring_gap) + s1 * (b.ring_current - a.ring_current);
  r.pull_gap = mix(&MagneticResponse::pull_gap) + 2 * s1 * (b.pull - a.pull) + s2 * (b.energy - a.energy);
  r.beyond = a.beyond || b.beyond;
  return r;
}

}  // namespace powbench::bench
