#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/units.h"
#include "sim/mechanics/canonical_order.h"
#include "sim/mechanics/rigid_contactor.h"
#include "sim/supply/series_inductance.h"

/// The rigid contactor: from parts to lanes, its modes, and its static equilibrium.

namespace powbench::sim {

template <class R>
RigidContactor<R>::RigidContactor(const RigidParts& given, const CoilDrive& drive, bool ledger)
    : drive_(drive), given_(given.pull), supply_(drive.supply) {
  require_valid(given);
  const auto [parts, number] = in_canonical_order(given);
  number_ = number;
  for (std::size_t lane = 0; lane < number.size(); ++lane)
    lane_[static_cast<std::size_t>(number[lane])] = static_cast<int>(lane);
  if (drive.potential != nullptr && supply_.mains().inductance > 0) {
    with_source_ = std::make_shared<SeriesInductance>(*drive.potential, supply_.mains().inductance);
    drive_.potential = with_source_.get();
  }
  lanes_.bridges = static_cast<int>(parts.bridges.size());
  lanes_.modes = static_cast<int>(parts.modes.size());
  lanes_.dof = 3 + lanes_.modes + 2 * lanes_.bridges;
  travel_ = static_cast<Real>(parts.travel);
  least_energy_ = parts.return_preload * parts.travel;
  laws_[0] = laws_[1] = parts.pad;
  laws_[2] = laws_[3] = parts.seat;
  laws_[4] = parts.pole;
  laws_[5] = parts.stop;
  set_core(parts);
  set_bridges(parts);
  size_ = 2 * lanes_.dof;
  if (drive.potential != nullptr) {
    electric_ = size_;
    size_ += drive.potential->has_ring() ? 2 : 1;
    if (drive.remanence.present()) offset_ = size_++;
    if (supply_.has_capacitor()) capacitor_ = size_++;
  }
  if (ledger) {
    ledger_ = size_;
    size_ += 6;
  }
  lanes_.friction = CoulombFriction<Real>(static_cast<Real>(parts.core_friction));
  events_.reserve(4096);
}

template <class R>
void RigidContactor<R>::set_contact(int group, int lane, const ContactLaw& law, Real inverse_mass) {
  used_ |= std::uint64_t{1} << (group * rigid_lanes + lane);
  auto& p = lanes_;
  p.k[group][lane] = static_cast<Real>(law.stiffness);
  p.linear[group][lane] = law.exponent == 1 ? 1 : 0;
  p.hertz[group][lane] = law.exponent == 1.5 ? 1 : 0;
  p.square[group][lane] = law.exponent == 2 ? 1 : 0;
  p.lambda[group][lane] = law.form == DampingForm::hunt_crossley ? static_cast<Real>(law.damping) : Real(0);
  p.c[group][lane] = static_cast<Real>(law.viscous());
  p.inverse_ramp[group][lane] = law.form == DampingForm::ramped ? 1 / static_cast<Real>(law.ramp) : Real(0);
  p.flat[group][lane] = law.form == DampingForm::linear ? Real(1) : Real(0);
  if (law.viscous() != 0) p.viscous = true;
  if (law.exponent == 1.5) p.rooted = true;
  if (law.exponent == 1.5 && law.viscous() == 0) rooted_ |= std::uint64_t{1} << (group * rigid_lanes + lane);
  masses_[group][lane] = 1 / inverse_mass;
  sign_[group][lane] = -1;
}

template <class R>
void RigidContactor<R>::set_core(const RigidParts& parts) {
  auto& p = lanes_;
  const auto real = [](double v) { return static_cast<Real>(v); };
  p.inverse_core = 1 / real(parts.core_mass);
  p.inverse_tilt = 1 / real(parts.core_inertia);
  p.inverse_static = 1 / real(parts.static_mass);
  p.return_preload = real(parts.return_preload);
  p.return_rate = real(parts.return_rate);
  p.core_damping = real(parts.core_damping);
  p.tilt_rate = real(parts.tilt_rate);
  p.tilt_damping = real(parts.tilt_damping);
  p.buffer_rate = real(parts.buffer_rate);
  p.buffer_damping = real(parts.buffer_damping);
  p.follow = real(parts.pads_follow);
  bodies_[0] = real(parts.core_mass);
  bodies_[1] = real(parts.core_inertia);
  bodies_[2] = real(parts.static_mass);
  for (int i = 0; i < lane_count; ++i) p.offset[i] = -1;
  const Real arm = real(parts.pole_arm);
  for (int side = 0; side < 2; ++side) {
    const Real s = side == 0 ? Real(-1) : Real(1);
    p.to_x[side] = 1;
    p.to_tilt[side] = s * arm;
    p.to_static[side] = -1;
    p.offset[side] = -real(parts.travel);
    p.to_x[2 + side] = -1;
    p.to_tilt[2 + side] = -s * arm;
    p.offset[2 + side] = 0;
    const Real core = p.inverse_core + arm * arm * p.inverse_tilt;
    set_contact(core_group, side, parts.pole, core + p.inverse_static);
    set_contact(core_group, 2 + side, parts.stop, core);
  }
  for (int m = 0; m < p.modes; ++m) {
    const auto& mode = parts.modes[static_cast<std::size_t>(m)];
    const Real mass = real(mode.mass);
    const Real omega = static_cast<Real>(2 * 3.14159265358979323846264338327950288L) * real(mode.hertz);
    p.inverse_mode[m] = 1 / mass;
    p.mode_rate[m] = mass * omega * omega;
    p.mode_damping[m] = 2 * real(mode.damping) * mass * omega;
    bodies_[3 + m] = mass;
    p.foot[m] = real(mode.buffer);
    if (mode.buffer != 0) p.buffer_on_base = true;
    for (int j = 0; j < p.bridges; ++j)
      for (int end = 0; end < 2; ++end) p.shape[m][end][j] = real(mode.shape[j][end]);
  }
}

template <class R>
void RigidContactor<R>::set_bridges(const RigidParts& parts) {
  auto& p = lanes_;
  const auto real = [](double v) { return static_cast<Real>(v); };
  for (auto& gaps : p.gap)
    for (int i = 0; i < lane_count; ++i) gaps[i] = 1;
  for (int j = 0; j < p.bridges; ++j) {
    const auto& b = parts.bridges[static_cast<std::size_t>(j)];
    p.at[j] = real(b.position);
    p.pad_arm[j] = real(b.pad_arm);
    p.seat_arm[j] = real(b.seat_arm);
    p.gap[0][j] = real(b.gap[0]);
    p.gap[1][j] = real(b.gap[1]);
    p.preload[j] = real(b.preload);
    p.rate[j] = real(b.rate);
    p.damping[j] = real(b.damping);
    p.turning[j] = real(b.turning_rate);
    p.inverse_mass[j] = 1 / real(b.mass);
    p.inverse_inertia[j] = 1 / real(b.inertia);
    bodies_[3 + p.modes + j] = real(b.mass);
    bodies_[3 + p.modes + p.bridges + j] = real(b.inertia);
    for (int end = 0; end < 2; ++end) {
      Real pad = p.inverse_mass[j] + p.pad_arm[j] * p.pad_arm[j] * p.inverse_inertia[j] +
                 p.follow * p.follow * p.inverse_static;
      for (int m = 0; m < p.modes; ++m) pad += p.shape[m][end][j] * p.shape[m][end][j] * p.inverse_mode[m];
      set_contact(end, j, parts.pad, pad);
      const Real seat = p.inverse_mass[j] + p.seat_arm[j] * p.seat_arm[j] * p.inverse_inertia[j] +
                        p.inverse_core + p.at[j] * p.at[j] * p.inverse_tilt;
      set_contact(2 + end, j, parts.seat, seat);
    }
  }
}

template <class R>
void RigidContactor<R>::press(int contact, bool on) {
  const std::uint64_t bit = std::uint64_t{1} << contact;
  pressing_ = on ? pressing_ | bit : pressing_ & ~bit;
  const int group = contact / rigid_lanes;
  lanes_.pressing[group][contact % rigid_lanes] = on ? 1 : 0;
  const bool some = (pressing_ >> (group * rigid_lanes) & 0xffU) != 0;
  lanes_.active = some ? lanes_.active | 1U << group : lanes_.active & ~(1U << group);
  const std::uint64_t dents = pressing_ | detached_;
  lanes_.dent[group][contact % rigid_lanes] = (dents & bit) != 0 ? 1 : 0;
  const bool dented = (dents >> (group * rigid_lanes) & 0xffU) != 0;
  lanes_.dented = dented ? lanes_.dented | 1U << group : lanes_.dented & ~(1U << group);
}

template <class R>
void RigidContactor<R>::flip_contact(Real t, const Real* y, int contact) {
  auto& group = sign_[contact / rigid_lanes];
  const int lane = contact % rigid_lanes;
  const bool closes = group[lane] < 0;
  const Real rate = lane_rate(contact, y);
  group[lane] = closes ? Real(1) : Real(-1);
  const bool was_detached = detached_ >> contact & 1U;
  detached_ &= ~(std::uint64_t{1} << contact);
  press(contact, closes);
  if (!was_detached)  // else the force had ended before
    events_.push_back(
        {number_of(contact), closes, static_cast<double>(t), std::fabs(static_cast<double>(rate))});
  if (!closes) return;
  const int g = contact / rigid_lanes;
  const int i = contact % rigid_lanes;
  const auto& law = law_of(g, i);
  if (law.form != DampingForm::none && law.form != DampingForm::hunt_crossley)
    lanes_.lambda[g][i] = static_cast<Real>(law.hysteresis(static_cast<double>(rate)));
}

/// Ends the pressing of contacts that would pull, or resumes it.
template <class R>
void RigidContactor<R>::flip_detached(Real t, const Real* y, bool release) {
  constexpr Real round_off = Real(1e-9L);
  for (std::uint64_t bits = release ? pressing_ : detached_; bits != 0; bits &= bits - 1) {
    const int c = __builtin_ctzll(bits);
    const Real rate = lane_rate(c, y);
    const Real margin = pressing_margin(c, y, rate);
    if (release ? margin > round_off : margin < -round_off) continue;
    detached_ ^= std::uint64_t{1} << c;
    press(c, !release);
    events_.push_back({number_of(c), !release, static_cast<double>(t), std::fabs(static_cast<double>(rate))});
  }
}

template <class R>
void RigidContactor<R>::flip(Real& t, Real* y, std::uint64_t which) {
  for (std::uint64_t bits = which & ((std::uint64_t{1} << rigid_contacts) - 1); bits != 0; bits &= bits - 1)
    flip_contact(t, y, __builtin_ctzll(bits));
  if (which >> release_guard & 1U) flip_detached(t, y, true);
  if (which >> regain_guard & 1U) flip_detached(t, y, false);
  if (which >> gap_guard & 1U) touching_ = !touching_;
  if (which >> coil_guard & 3U) flip_supply(static_cast<double>(t), y, which >> coil_guard);
  if ((which >> friction_guard & 1U) == 0 && !lanes_.friction.sticks()) return;
  y[lanes_.dof] = 0;
  lanes_.friction.choose(core_force(t, y));
}

namespace {

/// Solves a x = b by elimination with row pivots; a and b are overwritten. False: singular.
template <class Real, int Most>
bool solve(int n, Real (&a)[Most][Most], Real (&b)[Most]) {
  for (int c = 0; c < n; ++c) {
    int p = c;
    for (int r = c; r < n; ++r)
      if (std::fabs(a[r][c]) > std::fabs(a[p][c])) p = r;
    if (a[p][c] == 0) return false;
    for (int k = 0; k < n; ++k) std::swap(a[c][k], a[p][k]);
    std::swap(b[c], b[p]);
    for (int r = 0; r < n; ++r) {
      if (r == c) continue;
      const Real f = a[r][c] / a[c][c];
      for (int k = c; k < n; ++k) a[r][k] -= f * a[c][k];
      b[r] -= f * b[c];
    }
  }
  for (int c = 0; c < n; ++c) b[c] /= a[c][c];
  return true;
}

}  // namespace

namespace {

/// Refuses parts that touch at rest although each gap is positive: the seats deflect by some micrometres.
void require_open(int contact, double depth, double gap) {
  const auto place = contact_place(contact);
  if (place.kind != ContactKind::pad && place.kind != ContactKind::pole) return;
  const std::string key =
      place.kind == ContactKind::pad ? "bridge " + std::to_string(place.part + 1) + ".gap" : "travel";
  char text[160];
  std::snprintf(text, sizeof text, "rigid: %s = %.6g, allowed above %.6g (parts overlap at t = 0 otherwise)",
                key.c_str(), gap, gap + depth);
  throw std::invalid_argument(text);
}

}  // namespace

template <class R>
double RigidContactor<R>::equilibrium(Real* y) {
  constexpr int most = 3 + most_base_modes + 2 * most_bridges;
  const int n = lanes_.dof;
  const auto& p = lanes_;
  std::fill_n(y, capacity, Real(0));
  // start: each preload carried by its seat alone
  const auto depth = [](const ContactLaw& law, Real force) {
    return std::pow(force / static_cast<Real>(law.stiffness), 1 / static_cast<Real>(law.exponent));
  };
  y[0] = -depth(laws_[5], p.return_preload / 2);
  for (int j = 0; j < p.bridges; ++j) y[3 + p.modes + j] = y[0] + depth(laws_[2], p.preload[j] / 2);
  auto still = *this;
  still.lanes_.automatic = true;
  still.lanes_.friction = {};
  still.lanes_.followed = -1;
  still.ledger_ = still.electric_ = still.offset_ = still.capacitor_ = -1;
  still.given_.peak = 0;
  alignas(64) Real dy[dop853::padded(capacity + 2)];
  alignas(64) Real moved[dop853::padded(capacity + 2)];
  Real worst = 0;
  for (int pass = 0; pass < 60; ++pass) {
    still.derivative(0, y, dy);
    worst = 0;
    for (int i = 0; i < n; ++i)
      worst = std::max(worst, std::fabs(dy[n + i]) * (i == 1 ? Real(1e-2L) : Real(1)));
    Real a[most][most];
    Real b[most];
    for (int c = 0; c < n; ++c) {
      const Real small = Real(1e-10L);
      const Real at = y[c];
      y[c] = at + small;
      still.derivative(0, y, moved);
      for (int r = 0; r < n; ++r) a[r][c] = (moved[n + r] - dy[n + r]) / small;
      y[c] = at;
    }
    for (int r = 0; r < n; ++r) b[r] = -dy[n + r];
    if (!solve(n, a, b)) break;
    Real change = 0;
    for (int i = 0; i < n; ++i) {
      y[i] += b[i];
      change = std::max(change, std::fabs(b[i]));
    }
    if (change < (std::is_same_v<Real, double> ? Real(1e-20L) : Real(1e-23L))) break;
  }
  if (!(worst < Real(1e-3L))) throw std::runtime_error("rigid: no static equilibrium at t = 0");
  Lanes<Real> d[rigid_groups];
  depths(y, d);
  pressing_ = detached_ = 0;
  for (int c = 0; c < rigid_contacts; ++c) {
    if ((used_ >> c & 1U) == 0) continue;
    const Real pressed = d[c / rigid_lanes][c % rigid_lanes];
    const bool on = pressed > 0;
    const Real gap = c < 2 * rigid_lanes ? p.gap[c / rigid_lanes][c % rigid_lanes] : travel_;
    if (on) require_open(number_of(c), static_cast<double>(pressed), static_cast<double>(gap));
    press(c, on);
    sign_[c / rigid_lanes][c % rigid_lanes] = on ? Real(1) : Real(-1);
  }
  touching_ = separation(y) < 0;
  if (offset_ >= 0) magnetise(y);
  return static_cast<double>(worst);
}

template class RigidContactor<double>;
template class RigidContactor<long double>;

}  // namespace powbench::sim
