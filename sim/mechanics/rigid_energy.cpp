#include <algorithm>
#include <cmath>

#include "sim/mechanics/rigid_contactor.h"

/// The rigid contactor: where its energy is, and what was supplied and lost.

namespace powbench::sim {

template <class R>
void RigidContactor<R>::book(const Real* y, const MagneticResponse& m, Real f, Real i,
                             const CoilFeed<Real>& fed, const Real* losses, Real* dy) const {
  const Real* v = y + lanes_.dof;
  const Real squeeze = v[2] - rigid_foot(lanes_, v);
  Real damped = losses[1] + lanes_.core_damping * v[0] * v[0] + lanes_.tilt_damping * v[1] * v[1] +
                lanes_.buffer_damping * squeeze * squeeze;
  for (int k = 0; k < lanes_.modes; ++k) damped += lanes_.mode_damping[k] * v[3 + k] * v[3 + k];
  Real* e = dy + ledger_;
  const Real ring = static_cast<Real>(m.ring_current);
  e[0] = electric_ >= 0 ? fed.supplied : f * (v[0] - v[2]);
  e[1] = fed.heat(static_cast<Real>(drive_.resistance), i);
  if (offset_ >= 0) e[1] += drive_.remanence.loss(y[offset_], dy[electric_]);
  e[2] = static_cast<Real>(drive_.ring_resistance) * ring * ring;
  e[3] = losses[0];
  e[4] = lanes_.friction.loss(v[0]);
  e[5] = damped;
}

template <class R>
EnergyLedger RigidContactor<R>::energies(const Real* y) const {
  const auto& p = lanes_;
  const int n = p.dof;
  const Real* v = y + n;
  EnergyLedger e;
  Real kinetic = 0;
  for (int i = 0; i < n; ++i) kinetic += bodies_[i] * v[i] * v[i] / 2;
  const Real squeeze = y[2] - rigid_foot(p, y);
  Real springs = p.return_preload * y[0] + p.return_rate * y[0] * y[0] / 2 + p.tilt_rate * y[1] * y[1] / 2 +
                 p.buffer_rate * squeeze * squeeze / 2;
  for (int i = 0; i < p.modes; ++i) springs += p.mode_rate[i] * y[3 + i] * y[3 + i] / 2;
  for (int j = 0; j < p.bridges; ++j) {
    const Real theta = y[3 + p.modes + p.bridges + j];
    const Real stretch = y[0] + p.at[j] * y[1] - y[3 + p.modes + j];
    springs += p.preload[j] * stretch + p.rate[j] * stretch * stretch / 2 + p.turning[j] * theta * theta / 2;
  }
  Lanes<Real> d[rigid_groups];
  depths(y, d);
  Real contacts = 0;
  for (int c = 0; c < rigid_contacts; ++c) {
    const int g = c / rigid_lanes;
    const int i = c % rigid_lanes;
    if ((used_ >> c & 1U) == 0 || d[g][i] <= 0) continue;
    const auto& law = law_of(g, i);
    contacts += elastic_force(law, d[g][i]) * d[g][i] / static_cast<Real>(law.exponent + 1);
  }
  e.kinetic = static_cast<double>(kinetic);
  e.springs = static_cast<double>(springs);
  e.contacts = static_cast<double>(contacts);
  if (electric_ >= 0) e.magnetic = field(y).energy + drive_.remanence.stored(static_cast<double>(offset(y)));
  if (capacitor_ >= 0) {
    const auto volts = static_cast<double>(y[capacitor_]);
    e.magnetic += 0.5 * supply_.capacitance() * volts * volts;
  }
  if (ledger_ < 0) return e;
  const auto at = [&](int i) { return static_cast<double>(y[ledger_ + i]); };
  e.supplied = at(0);
  e.coil = at(1);
  e.ring = at(2);
  e.contact_loss = at(3);
  e.friction = at(4);
  e.damping = at(5);
  return e;
}

template <class R>
double RigidContactor<R>::energy_residual(const Real* y) const {
  const auto e = energies(y);
  const double whole =
      std::max({std::fabs(e.supplied), std::fabs(e.stored() - start_energy_), e.lost(), least_energy_});
  return std::fabs(e.stored() - start_energy_ + e.lost() - e.supplied) / whole;
}

template class RigidContactor<double>;
template class RigidContactor<long double>;

}  // namespace powbench::sim
