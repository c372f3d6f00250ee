#include "sim/solid/explicit_solid.h"

/// Solid bodies in motion: what a run needs to go on later as if it had not stopped.

namespace powbench::sim {

SolidState ExplicitSolid::save() const {
  SolidState s;
  s.time = time_;
  s.dt = dt_;
  s.dt_before = dt_before_;
  s.step = steps_;
  s.u = u_;
  s.v = v_;
  s.cells = cells_.memory();
  if (contact_) s.contact = contact_->memory();
  s.inertia = inertia_.momentum();
  s.booked = {booked_external_, booked_damping_,    booked_frozen_, largest_,       limit_,
              energies_.start,  begun_ ? 1.0 : 0.0, transit_,       booked_contact_};
  s.rigid = rigid_;
  return s;
}

void ExplicitSolid::restore(const SolidState& s) {
  if (s.u.size() != u_.size() || s.booked.size() != 9 || s.inertia.size() != inertia_.momentum().size())
    throw std::invalid_argument("restart: the saved state belongs to another mesh");
  stopped_ = false;
  cells_.restore_memory(s.cells);
  if (contact_) contact_->restore_memory(s.contact);
  inertia_.set_momentum(s.inertia);
  time_ = s.time;
  dt_ = s.dt;
  dt_before_ = s.dt_before;
  steps_ = s.step;
  u_ = s.u;
  v_ = s.v;
  booked_external_ = s.booked[0];
  booked_damping_ = s.booked[1];
  booked_frozen_ = s.booked[2];
  largest_ = s.booked[3];
  limit_ = s.booked[4];
  energies_.start = s.booked[5];
  begun_ = s.booked[6] != 0;
  transit_ = s.booked[7];
  booked_contact_ = s.booked[8];
  rigid_ = s.rigid;
}

}  // namespace powbench::sim
