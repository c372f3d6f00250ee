#include "sim/mechanics/rigid_contactor.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "sim/mechanics/rigid_halves.h"

/// The right-hand side and the guards of the rigid contactor.

namespace powbench::sim {
namespace {

#ifdef __x86_64__
const bool takes_halves = __builtin_cpu_supports("avx2") && !__builtin_cpu_supports("avx512f");
#else
constexpr bool takes_halves = false;
void rigid_rhs_in_halves(const void*, const double*, double, double*, double*) {}
void rigid_guards_in_halves(const void*, const void*, const double*, const double*, double*, double*,
                            double*) {}
#endif

POWBENCH_CLONES
void rhs_whole(const RigidLanes<double>& p, const double* s, double pull, double* ds, double* losses) {
  rigid_rhs(p, s, pull, ds, losses);
}
void rhs_kernel(const RigidLanes<double>& p, const double* s, double pull, double* ds, double* losses) {
  if (takes_halves)
    rigid_rhs_in_halves(&p, s, pull, ds, losses);
  else
    rhs_whole(p, s, pull, ds, losses);
}
void rhs_kernel(const RigidLanes<long double>& p, const long double* s, long double pull, long double* ds,
                long double* losses) {
  rigid_rhs(p, s, pull, ds, losses);
}

POWBENCH_CLONES
void guards_whole(const RigidLanes<double>& p, const Lanes<double>* sign, const double* s, const double* ds,
                  double* value, double* rate, double* curve) {
  rigid_signed_depths(p, sign, s, ds, value, rate, curve);
}
void guard_kernel(const RigidLanes<double>& p, const Lanes<double>* sign, const double* s, const double* ds,
                  double* value, double* rate, double* curve) {
  if (takes_halves)
    rigid_guards_in_halves(&p, sign, s, ds, value, rate, curve);
  else
    guards_whole(p, sign, s, ds, value, rate, curve);
}
void guard_kernel(const RigidLanes<long double>& p, const LongLanes* sign, const long double* s,
                  const long double* ds, long double* value, long double* rate, long double* curve) {
  rigid_signed_depths(p, sign, s, ds, value, rate, curve);
}

template <class Real>
constexpr Real two_pi = static_cast<Real>(2 * 3.14159265358979323846264338327950288L);

}  // namespace

ContactPlace contact_place(int contact) {
  const int group = contact / rigid_lanes;
  const int lane = contact % rigid_lanes;
  if (group < 2) return {ContactKind::pad, lane, group};
  if (group < core_group) return {ContactKind::seat, lane, group - 2};
  return {lane < 2 ? ContactKind::pole : ContactKind::stop, 0, lane % 2};
}

template <class R>
R RigidContactor<R>::scale(int i) const {
  const int n = lanes_.dof;
  if (i == capacitor_ && capacitor_ >= 0) return 1;
  if (i == offset_ && offset_ >= 0) return static_cast<Real>(drive_.remanence.current);
  if (i >= 2 * n) return i >= ledger_ && ledger_ >= 0 ? Real(0.01L) : Real(0.1L);
  const int q = i % n;
  const bool rate = i >= n;
  Real s = Real(1e-3L);
  if (q == 1) s = Real(0.1L);
  if (q >= 3 && q < 3 + lanes_.modes) s = Real(1e-5L);
  if (q >= 3 + lanes_.modes + lanes_.bridges) s = Real(0.1L);
  return rate ? 1000 * s : s;
}

template <class R>
R RigidContactor<R>::gap(const Real* y) const {
  return touching_ ? Real(0) : separation(y);
}

/// The rung's answer; where the pole faces are pressed together (gap s < 0) the energy goes on along its tangent,
/// W(psi, 0) + s dW/ds, so that pull, currents and energy stay those of one potential.
template <class R>
MagneticResponse RigidContactor<R>::field(const Real* y) const {
  const auto at = [&](int i) { return static_cast<double>(y[electric_ + i]); };
  const double ring = drive_.potential->has_ring() ? at(1) : 0.0;
  const auto s = static_cast<double>(separation(y));
  if (drive_.pressed_gap) return drive_.potential->at({at(0), ring, s});
  auto m = drive_.potential->at({at(0), ring, touching_ ? 0.0 : std::max(s, 0.0)});
  if (!touching_) return m;
  m.energy += s * m.pull;
  m.current += s * m.current_gap;
  m.ring_current += s * m.ring_gap;
  return m;
}

template <class R>
R RigidContactor<R>::pull(Real t, const Real* y) const {
  if (electric_ >= 0) return static_cast<Real>(field(y).pull);
  Real g = gap(y);
  if (lanes_.automatic) g = std::max(separation(y), Real(0));
  const Real wide = 1 + g / static_cast<Real>(given_.range);
  const Real sine = std::sin(two_pi<Real> * static_cast<Real>(given_.hertz) * t);
  const Real share = static_cast<Real>(given_.share);
  return static_cast<Real>(given_.peak) * (1 - std::exp(-t / static_cast<Real>(given_.rise))) *
         (share + (1 - share) * sine * sine) / (wide * wide);
}

template <class R>
MagneticResponse RigidContactor<R>::derivative(Real t, const Real* y, Real* dy) const {
  const bool coil = electric_ >= 0;
  const MagneticResponse m = coil ? field(y) : MagneticResponse{};
  const Real f = coil ? static_cast<Real>(m.pull) : pull(t, y);
  Real losses[2];
  rhs_kernel(lanes_, y, f, dy, ledger_ >= 0 ? losses : nullptr);
  Real i = 0;
  CoilFeed<Real> fed;
  if (coil && supply_.conducts()) {
    i = current(y, m);
    fed = feed(t, y, i);
  }
  if (coil) electric(y, m, i, fed, dy);
  if (ledger_ >= 0) book(y, m, f, i, fed, losses, dy);
  return m;
}

/// Fluxes: dpsi/dt = u - R i while the switch is closed; with it open i = 0 binds psi to the rest.
template <class R>
void RigidContactor<R>::electric(const Real* y, const MagneticResponse& m, Real i, const CoilFeed<Real>& fed,
                                 Real* dy) const {
  const bool ring = drive_.potential->has_ring();
  const Real ring_rate =
      ring ? -static_cast<Real>(drive_.ring_resistance) * static_cast<Real>(m.ring_current) : Real(0);
  if (ring) dy[electric_ + 1] = ring_rate;
  dy[electric_] = supply_.conducts() ? fed.linkage_rate(static_cast<Real>(drive_.resistance), i)
                                     : open_voltage(y, m, ring_rate);
  if (capacitor_ >= 0) dy[capacitor_] = fed.capacitor_rate;
  if (offset_ >= 0) dy[offset_] = drive_.remanence.rate(y[offset_], dy[electric_]);
}

/// dpsi/dt while i = 0.
template <class R>
R RigidContactor<R>::open_voltage(const Real* y, const MagneticResponse& m, Real ring_rate) const {
  const Real gap_rate = y[lanes_.dof + 2] - y[lanes_.dof];
  const Real other =
      static_cast<Real>(m.current_ring) * ring_rate + static_cast<Real>(m.current_gap) * gap_rate;
  const Real turning = offset_ < 0 ? Real(0) : drive_.remanence.stiffness(y[offset_], other < 0);
  return -other / (static_cast<Real>(m.current_psi) + turning);
}

template <class R>
R RigidContactor<R>::open_voltage(const Real* y) const {
  const MagneticResponse m = field(y);
  const bool ring = drive_.potential->has_ring();
  return open_voltage(
      y, m, ring ? -static_cast<Real>(drive_.ring_resistance) * static_cast<Real>(m.ring_current) : Real(0));
}

template <class R>
CoilFeed<R> RigidContactor<R>::feed(Real t, const Real* y, Real current) const {
  auto fed = supply_.feed(t, current, capacitor_ < 0 ? Real(0) : y[capacitor_]);
  const auto stated = static_cast<Real>(stated_.at(static_cast<double>(t)));
  fed.emf += stated;
  fed.supplied += stated * current;
  return fed;
}

template <class R>
int RigidContactor<R>::number_of(int lane_contact) const {
  const int lane = lane_contact % rigid_lanes;
  if (lane_contact >= core_group * rigid_lanes) return lane_contact;
  return lane_contact - lane + number_[static_cast<std::size_t>(lane)];
}

template <class R>
int RigidContactor<R>::lane_of(int contact) const {
  const int bridge = contact % rigid_lanes;
  if (contact >= core_group * rigid_lanes) return contact;
  return contact - bridge + lane_[static_cast<std::size_t>(bridge)];
}

template <class R>
R RigidContactor<R>::lane_depth(int contact, const Real* y) const {
  const auto& p = lanes_;
  const int g = contact / rigid_lanes;
  const int i = contact % rigid_lanes;
  if (g == core_group) return p.to_x[i] * y[0] + p.to_tilt[i] * y[1] + p.to_static[i] * y[2] + p.offset[i];
  const Real at = y[3 + p.modes + i];
  const Real turn = y[3 + p.modes + p.bridges + i] * (g % 2 == 0 ? Real(-1) : Real(1));
  if (g >= 2) return at + p.seat_arm[i] * turn - (y[0] + p.at[i] * y[1]);
  Real under = p.follow * y[2] + p.gap[g][i];
  for (int m = 0; m < p.modes; ++m) under += p.shape[m][g][i] * y[3 + m];
  return at + p.pad_arm[i] * turn - under;
}

template <class R>
R RigidContactor<R>::lane_rate(int contact, const Real* y) const {
  const auto& p = lanes_;
  const Real* v = y + p.dof;
  const int g = contact / rigid_lanes;
  const int i = contact % rigid_lanes;
  if (g == core_group) return p.to_x[i] * v[0] + p.to_tilt[i] * v[1] + p.to_static[i] * v[2];
  const Real vy = v[3 + p.modes + i];
  const Real turn = v[3 + p.modes + p.bridges + i] * (g % 2 == 0 ? Real(-1) : Real(1));
  if (g >= 2) return vy + p.seat_arm[i] * turn - (v[0] + p.at[i] * v[1]);
  Real under = p.follow * v[2];
  for (int m = 0; m < p.modes; ++m) under += p.shape[m][g][i] * v[3 + m];
  return vy + p.pad_arm[i] * turn - under;
}

template <class R>
R RigidContactor<R>::force_of(int contact, const Real* y) const {
  const int at = lane_of(contact);
  const int g = at / rigid_lanes;
  const int i = at % rigid_lanes;
  const Real d = lane_depth(at, y);
  if (!uses(contact) || !is_pressing(contact) || d <= 0) return 0;
  const auto& law = law_of(g, i);
  return std::max(Real(0), raw_force(law, d, lane_rate(at, y), lanes_.lambda[g][i]));
}

template <class R>
R RigidContactor<R>::root_step(int guard, const Real* y) const {
  const int g = guard / rigid_lanes;
  const int i = guard % rigid_lanes;
  const Real d = lane_depth(guard, y);
  return root_scale(lanes_.k[g][i], masses_[g][i], d, lane_rate(guard, y));
}

/// The pressing contact that is nearest to its zero in time, on either side, within a few steps.
template <class R>
int RigidContactor<R>::choose_root(const GuardSet& g, const Real*, Real step, Real& root) const {
  if (lanes_.automatic) return -1;
  constexpr Real slowest = Real(1e-9L);  // m/s: below this a touch stays a matter of picometres
  Real soonest = 3 * step;
  Real deep = 0;
  int best = -1;
  for (std::uint64_t bits = rooted_ & pressing_; bits != 0; bits &= bits - 1) {
    const int c = __builtin_ctzll(bits);
    const Real depth = std::max(g.value[c], Real(0));
    const Real rate = std::fabs(g.rate[c]);
    if (depth >= soonest * rate || rate < slowest) continue;
    soonest = depth / rate;
    best = c;
    deep = depth;
  }
  root = std::sqrt(deep);
  return best;
}

template <class R>
R RigidContactor<R>::core_force(Real t, const Real* y) const {
  alignas(64) Real dy[dop853::padded(capacity + 2)];
  auto free = lanes_;
  free.friction = {};
  rhs_kernel(free, y, pull(t, y), dy, nullptr);
  return dy[lanes_.dof] / lanes_.inverse_core;
}

/// Of a pressing contact: negative where it would pull.
template <class R>
R RigidContactor<R>::pressing_margin(int contact, const Real* y, Real rate) const {
  const int g = contact / rigid_lanes;
  const int i = contact % rigid_lanes;
  const Real stretch = 1 + lanes_.lambda[g][i] * rate;
  if (lanes_.c[g][i] == 0) return stretch;
  const Real d = lane_depth(contact, y);
  const auto& law = law_of(g, i);
  if (law.form == DampingForm::linear)
    return (d > 0 ? elastic_force(law, d) : -elastic_force(law, -d)) * stretch + lanes_.c[g][i] * rate;
  if (d <= 0) return 1;
  return stretch + lanes_.c[g][i] * rate * depth_ramp(d, static_cast<Real>(law.ramp)) / elastic_force(law, d);
}

template <class R>
void RigidContactor<R>::guards(Real t, const Real* y, const Real* dy, GuardSet& g) const {
  guard_kernel(lanes_, sign_, y, dy, g.value, g.rate, g.curve);
  const Real* v = y + lanes_.dof;
  const Real side = touching_ ? Real(-1) : Real(1);
  g.value[gap_guard] = side * separation(y);
  g.rate[gap_guard] = side * (v[2] - v[0]);
  g.curve[gap_guard] = dy == nullptr ? Real(0) : side * (dy[lanes_.dof + 2] - dy[lanes_.dof]);
  plain_guards(t, y, dy, g);
}

/// Guards that are only compared in sign; the rates of the contacts are known.
template <class R>
void RigidContactor<R>::plain_guards(Real t, const Real* y, const Real* dy, GuardSet& g) const {
  Real release = 1;
  for (std::uint64_t bits = pressing_; bits != 0; bits &= bits - 1) {
    const int c = __builtin_ctzll(bits);
    release = std::min(release, pressing_margin(c, y, g.rate[c]));
  }
  g.value[release_guard] = release;
  Real regain = -1;
  for (std::uint64_t bits = detached_; bits != 0; bits &= bits - 1) {
    const int c = __builtin_ctzll(bits);
    regain = std::max(regain, pressing_margin(c, y, g.rate[c]));
  }
  g.value[regain_guard] = -regain;
  g.value[friction_guard] = lanes_.friction.guard(y[lanes_.dof], [&] { return core_force(t, y); });
  g.rate[friction_guard] = lanes_.friction.guard_rate(dy != nullptr ? dy[lanes_.dof] : Real(0));
  Real& coil = g.value[coil_guard];
  coil = 1;
  if (electric_ >= 0 && supply_.watches_open_voltage())
    coil = supply_.guard(t, Real(0), open_voltage(y));
  else if (supply_.watches())
    coil = supply_.guard(t, current(y), Real(0));
  g.value[clock_guard] = static_cast<Real>(supply_.next_change()) - t;
}

template <class R>
R RigidContactor<R>::dip(int k, const GuardSet& begin, const GuardSet& end,
                         const StepEnds<Real>& ends) const {
  if (k == friction_guard)
    return lowest_share(begin.value[k], ends.first * begin.rate[k], end.value[k], ends.last * end.rate[k]);
  if (k != release_guard) return 2;
  Real first = 2;
  for (std::uint64_t bits = pressing_; bits != 0; bits &= bits - 1) {
    const int at = __builtin_ctzll(bits);
    const int g = at / rigid_lanes;
    const int i = at % rigid_lanes;
    const auto& law = law_of(g, i);
    if (law.form != DampingForm::linear) continue;
    const Real c = lanes_.c[g][i];
    const auto force = [&](const GuardSet& s, Real per_share, Real& slope) {
      const Real d = std::max(s.value[at], Real(0));
      const Real stiff = law.exponent == 1 ? static_cast<Real>(law.stiffness)
                         : d > 0           ? static_cast<Real>(law.exponent) * elastic_force(law, d) / d
                                           : Real(0);
      slope = per_share * (stiff * s.rate[at] + c * s.curve[at]);
      return elastic_force(law, d) + c * s.rate[at];
    };
    Real v0 = 0, v1 = 0;
    const Real f0 = force(begin, ends.first, v0), f1 = force(end, ends.last, v1);
    first = std::min(first, lowest_share(f0, v0, f1, v1));
  }
  return first;
}

template <class R>
R RigidContactor<R>::guard(int k, Real t, const Real* y, Real& rate) const {
  if (k < rigid_contacts) {
    const Real sign = sign_[k / rigid_lanes][k % rigid_lanes];
    rate = sign * lane_rate(k, y);
    return sign * lane_depth(k, y);
  }
  GuardSet g;
  guards(t, y, nullptr, g);
  rate = k == gap_guard ? g.rate[k] : k == clock_guard ? Real(-1) : Real(0);
  return g.value[k];
}

template class RigidContactor<double>;
template class RigidContactor<long double>;

}  // namespace powbench::sim
