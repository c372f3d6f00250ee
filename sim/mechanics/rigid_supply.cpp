#include <algorithm>
#include <cmath>

#include "sim/mechanics/rigid_contactor.h"

/// The rigid contactor at the events of its supply.

namespace powbench::sim {

template <class R>
void RigidContactor<R>::set_coil(Real t, Real* y, bool on) {
  const double before = energies(y).magnetic;
  settle_supply(y, supply_.command(static_cast<double>(t), on, fed_current(y)), before);
}

/// `which`: bit 0 the current, bit 1 the clock.
template <class R>
void RigidContactor<R>::flip_supply(double t, Real* y, std::uint64_t which) {
  const double before = energies(y).magnetic;
  if (which & 1U) settle_supply(y, supply_.pass_guard(t, fed_current(y)), before);
  if (which & 2U) settle_supply(y, supply_.pass(t, fed_current(y)), before);
}

/// A current that was cut is brought to zero; the energy the flux loses on the way is booked beside the coil's.
template <class R>
void RigidContactor<R>::settle_supply(Real* y, SupplyModes::Effect effect, double energy_before) {
  if (effect == SupplyModes::Effect::none || effect == SupplyModes::Effect::opened) return;
  const double left = remove_current(drive_.remanence, y[electric_], static_cast<double>(offset(y)), [&] {
    const MagneticResponse m = field(y);
    return CoilPoint{m.current, m.current_psi, static_cast<double>(y[electric_]), 1};
  });
  if (offset_ >= 0) y[offset_] = static_cast<Real>(left);
  if (ledger_ >= 0) y[ledger_ + 1] += static_cast<Real>(energy_before - energies(y).magnetic);
}

/// The flux without current, ring at rest, that the offset at the start leaves.
template <class R>
void RigidContactor<R>::magnetise(Real* y) const {
  const double start = drive_.remanence.start();
  const auto state =
      remanent_state(*drive_.potential, start, std::max(static_cast<double>(separation(y)), 0.0));
  y[offset_] = static_cast<Real>(start);
  y[electric_] = static_cast<Real>(state.psi);
  if (drive_.potential->has_ring()) y[electric_ + 1] = static_cast<Real>(state.ring);
}

template <class R>
double RigidContactor<R>::fed_current(const Real* y) const {
  return supply_.conducts() ? static_cast<double>(current(y)) : 0.0;
}

template <class R>
double RigidContactor<R>::current_rate(const Real* y, const Real* dy, const MagneticResponse& m) const {
  const int n = lanes_.dof;
  double rate = m.current_psi * static_cast<double>(dy[electric_]) +
                m.current_gap * static_cast<double>(y[n + 2] - y[n]);
  if (drive_.potential->has_ring()) rate += m.current_ring * static_cast<double>(dy[electric_ + 1]);
  return rate;
}

template class RigidContactor<double>;
template class RigidContactor<long double>;

}  // namespace powbench::sim
