#include "sim/models/solenoid/solenoid_live.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {

LiveSolenoid::LiveSolenoid(const SolenoidDesign& design, const FieldOptions& options)
    : field_(design, options), largest_gap_(design.largest_gap), magnet_(design.remanence != 0) {}

MagneticResponse LiveSolenoid::at(const MagneticState& s) const {
  const double gap = std::clamp(s.gap, 0.0, largest_gap_);
  if (gap != gap_) field_.set_gap(gap);
  gap_ = gap;
  auto p = field_.at_flux(s.psi, s.psi == 0 && !magnet_ ? std::vector<double>{} : start_);
  if (!p.newton.converged) throw std::runtime_error("solenoid: the field does not converge");
  start_ = std::move(p.a);
  auto r = p.response;
  const double beyond = s.gap - gap;
  r.energy += r.pull * beyond;
  r.current += r.current_gap * beyond;
  return r;
}

}  // namespace powbench::sim
