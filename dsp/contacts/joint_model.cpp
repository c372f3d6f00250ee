#include <algorithm>
#include <cmath>

#include "dsp/contacts/joint_fit.h"

namespace powbench::dsp {

double JointModel::cost() const {
  if (!(dof > 0)) return 1e300;
  return chi2 - (dof + parameters) + left_out_cost * left_out + parameters * std::log(dof);
}

double JointModel::cost_before_settling() const {
  return cost() - left_out_cost * settling_out;
}

void take_out(const JointModel& m, Signal& s) {
  m.ring.add_to(s, -1.0);
  if (m.ring.empty() || !(m.pedestal_span > 0)) return;
  // where the last contact begins is only nearly known: beyond, the pedestal stays a little and then fades
  constexpr double hold = 0.1e-3, fade = 0.2e-3;  // s
  const double end = m.ring.onset + m.pedestal_span;
  for (std::size_t i = s.index_at(m.ring.onset); i < s.index_at(end + hold + fade); ++i) {
    const double t = s.time(i), u = std::min(1.0, (t - m.ring.onset) / m.pedestal_span);
    const double share = std::clamp((end + hold + fade - t) / fade, 0.0, 1.0);
    s.value[i] -= share * (m.pedestal[0] + u * (m.pedestal[1] + u * m.pedestal[2]));
  }
}

}  // namespace powbench::dsp
