#include <algorithm>
#include <cmath>

#include "sim/solid/explicit_solid.h"

/// The energy ledger of solid bodies in motion.

namespace powbench::sim {

double ExplicitSolid::damping_work(double half_dt) const {
  double power = 0;
  for (const int n : damped_.touched()) power += dot(damped_[n], velocity(n));
  return -half_dt * power;
}

/// Half a step's work of the forces at its middle, with the speed of that half.
void ExplicitSolid::book_work(double half_dt) {
  for (const auto& load : loads_) booked_external_ += half_dt * dot(load.force, mean(load.on, v_.data()));
  booked_contact_ += damping_work(half_dt);
}

/// Energies of the state this step started from; `v_before` belongs half a step before it, v_ half a step after.
void ExplicitSolid::balance(const std::vector<double>& v_before) {
  SolidEnergies& e = energies_;
  e.strain = e.plastic = e.hourglass = 0;
  std::vector<double> at_start(u_.size());
  for (std::size_t k = 0; k < u_.size(); ++k) at_start[k] = u_[k] - dt_ * v_[k];
  for (int p = 0; p < static_cast<int>(cells_.mesh().parts.size()); ++p) {
    const bool frozen = rigid_.count(p) > 0;
    const CellEnergies c = cells_.energies(p, frozen ? u_ : at_start);
    e.strain += c.strain;
    e.plastic += c.plastic;
    e.hourglass += c.hourglass;
    for (int n = cells_.nodes_begin(p); !frozen && n < cells_.nodes_end(p); ++n)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto at = 4 * static_cast<std::size_t>(n) + i;
        e.kinetic += 0.5 * cells_.masses()[static_cast<std::size_t>(n)] * v_before[at] * v_[at];
      }
  }
  e.contact = load_store_ + (contact_ ? contact_->stored() : 0);
  e.friction = contact_ ? contact_->friction_lost() : 0;
  double ahead = 0;  // half of this step's work belongs to the next balance
  for (const auto& load : loads_) ahead += 0.5 * dt_ * dot(load.force, mean(load.on, v_.data()));
  e.external = booked_external_ - ahead;
  e.contact_damping = booked_contact_ - damping_work(0.5 * dt_);
  e.damping = booked_damping_;
  e.frozen = booked_frozen_;
  if (steps_ == 0) e.start = e.stored() + e.lost() - e.external;
  asked_ = false;
  largest_ = std::max({largest_, std::fabs(e.stored()), std::fabs(e.external), std::fabs(e.start)});
  if (std::fabs(e.residual()) > options_.energy_bound * largest_)
    stop("energy residual " + std::to_string(e.residual() / largest_) + " of the largest energy at t = " +
             std::to_string(time_ * 1e6) + " us, allowed is " + std::to_string(options_.energy_bound),
         -1);
}

}  // namespace powbench::sim
