#pragma once

#include "sim/mechanics/friction.h"
#include "sim/mechanics/lanes.h"
#include "sim/mechanics/rigid_parts.h"

/// The right-hand side of the rigid contactor over lanes: eight bridges side by side, unused ones with parameters
/// that yield no force. Private to the rigid rung.

namespace powbench::sim {
inline namespace POWBENCH_LANE_SPACE {

/// Contacts in groups of eight lanes: pads of end 0, pads of end 1, seats of end 0, seats of end 1, and core
/// (pole faces 0, 1, stops 0, 1).
inline constexpr int rigid_lanes = lane_count;
inline constexpr int rigid_groups = 5;
inline constexpr int rigid_contacts = rigid_lanes * rigid_groups;
inline constexpr int core_group = 4;

/// Parameters and modes, ready for the kernel. States: q = x, tilt, x_s, modes, y_j, theta_j; then their rates.
template <class Real>
struct RigidLanes {
  using V = Lanes<Real>;
  int bridges = 0;
  int modes = 0;
  int dof = 3;
  bool viscous = false;    ///< some contact has a force beside k d^n (1 + lambda d')
  bool rooted = false;     ///< some contact has n = 1.5
  bool automatic = false;  ///< modes follow the sign of the depth, as a foreign integrator needs it
  int followed = -1;       ///< contact whose root is a state
  Real root = 0;
  // bridges
  V at{}, pad_arm{}, seat_arm{}, gap[2]{}, preload{}, rate{}, damping{}, turning{};
  V inverse_mass{}, inverse_inertia{};
  V shape[most_base_modes][2]{};
  // core contacts: depth = to_x x + to_tilt tilt + to_static x_s + offset
  V to_x{}, to_tilt{}, to_static{}, offset{};
  // contact laws and modes
  V k[rigid_groups]{}, linear[rigid_groups]{}, hertz[rigid_groups]{}, square[rigid_groups]{};
  V lambda[rigid_groups]{}, c[rigid_groups]{}, inverse_ramp[rigid_groups]{};
  V flat[rigid_groups]{};      ///< 1 where the viscous part has no ramp
  V pressing[rigid_groups]{};  ///< 1 or 0
  unsigned active = 0;         ///< bit g: some contact of group g presses
  V dent[rigid_groups]{};      ///< 1 or 0: presses, or has a dent left that relaxes
  unsigned dented = 0;         ///< bit g: some contact of group g does
  // bodies
  Real inverse_core = 0, inverse_tilt = 0, inverse_static = 0;
  Real return_preload = 0, return_rate = 0, core_damping = 0, tilt_rate = 0, tilt_damping = 0;
  Real buffer_rate = 0, buffer_damping = 0;
  CoulombFriction<Real> friction;   ///< on the core
  Real follow = 0;                  ///< of the pads with the static core
  bool buffer_on_base = false;      ///< the buffer's foot moves with the base modes
  Real foot[most_base_modes] = {};  ///< shape of a mode there
  Real mode_rate[most_base_modes] = {}, mode_damping[most_base_modes] = {},
       inverse_mode[most_base_modes] = {};
};

/// Depths of all contacts at q (or, with offsets = 0, their rates at q').
template <class Real>
POWBENCH_INLINE void rigid_depths(const RigidLanes<Real>& p, const Real* q, Real offsets, Lanes<Real>* d) {
  using V = Lanes<Real>;
  V y;
  V theta;
  load<Real>(q + 3 + p.modes, y);
  load<Real>(q + 3 + p.modes + p.bridges, theta);
  V pad0 = offsets * p.gap[0];
  V pad1 = offsets * p.gap[1];
  for (int m = 0; m < p.modes; ++m) {
    pad0 += q[3 + m] * p.shape[m][0];
    pad1 += q[3 + m] * p.shape[m][1];
  }
  const Real z = p.follow * q[2];
  const V turn = p.pad_arm * theta;
  d[0] = -1 * (z - (y - pad0 - turn));
  d[1] = -1 * (z - (y - pad1 + turn));
  const V lift = p.seat_arm * theta;
  const V above = -1 * (q[0] - (y - q[1] * p.at));
  d[2] = above - lift;
  d[3] = above + lift;
  d[4] = q[0] * p.to_x + q[1] * p.to_tilt + q[2] * p.to_static + offsets * p.offset;
}

/// Depths of group g above zero and their roots; those of a followed contact come from its root.
template <class Real>
POWBENCH_INLINE void rigid_dents(const RigidLanes<Real>& p, int g, Lanes<Real>* d, Lanes<Real>& clipped,
                                 Lanes<Real>& root) {
  clip(d[g], clipped);
  root = Lanes<Real>{};
  if (p.rooted) square_root<Real>(clipped, root);
  if (p.followed < 0 || p.followed / lane_count != g) return;
  const int lane = p.followed % lane_count;
  d[g][lane] = p.root * p.root;
  clipped[lane] = p.root * p.root;
  root[lane] = p.root;
}

/// Forces of all contacts; with a followed contact its root replaces the one of its depth.
template <class Real>
POWBENCH_INLINE void rigid_forces(const RigidLanes<Real>& p, Lanes<Real>* d, const Lanes<Real>* rate,
                                  Lanes<Real>* force) {
  using V = Lanes<Real>;
  for (int g = 0; g < rigid_groups; ++g) {
    if ((p.active >> g & 1U) == 0 && !p.automatic) {
      force[g] = V{};
      continue;
    }
    V clipped;
    V root;
    rigid_dents(p, g, d, clipped, root);
    const V elastic = p.k[g] * (p.linear[g] * d[g] + clipped * (p.hertz[g] * root + p.square[g] * clipped));
    force[g] = elastic + elastic * p.lambda[g] * rate[g];
    if (p.viscous) {
      const V share = clipped * p.inverse_ramp[g];
      const V beyond = Real(-1) * (Real(1) - share);
      V u;
      clip(beyond, u);
      u = share - u;  // min(share, 1)
      force[g] += p.c[g] * rate[g] * (p.flat[g] + u * u * (Real(3) - (u + u)));
    }
    if (p.automatic) {
      V pushes;
      clip(force[g], pushes);
      keep(d[g], pushes, force[g]);
    } else {
      force[g] *= p.pressing[g];
    }
  }
}

/// Displacement of the buffer's foot at q (its rate at q').
template <class Real>
POWBENCH_INLINE Real rigid_foot(const RigidLanes<Real>& p, const Real* q) {
  Real foot = 0;
  if (!p.buffer_on_base) return foot;
  for (int m = 0; m < p.modes; ++m) foot += p.foot[m] * q[3 + m];
  return foot;
}

/// W that the layers of all contacts lose: force beside the elastic one, at the rate of the depth. A layer that no
/// longer presses relaxes by itself.
template <class Real>
POWBENCH_INLINE Real rigid_contact_loss(const RigidLanes<Real>& p, Lanes<Real>* d, const Lanes<Real>* rate,
                                        const Lanes<Real>* force) {
  using V = Lanes<Real>;
  V lost{};
  for (int g = 0; g < rigid_groups; ++g) {
    if ((p.dented >> g & 1U) == 0 && !p.automatic) continue;
    V clipped;
    V root;
    rigid_dents(p, g, d, clipped, root);
    const V elastic = p.k[g] * clipped * (p.linear[g] + p.hertz[g] * root + p.square[g] * clipped);
    lost += (force[g] - (p.automatic ? elastic : elastic * p.dent[g])) * rate[g];
  }
  return lane_sum<Real>(lost);
}

/// dy of the mechanical states; `pull` acts on the core and, reversed, on the static core. Writes past the states.
/// `losses`: W in the contacts and in the springs of the bridges, or nullptr.
template <class Real>
POWBENCH_INLINE void rigid_rhs(const RigidLanes<Real>& p, const Real* s, Real pull, Real* ds, Real* losses) {
  using V = Lanes<Real>;
  const int n = p.dof;
  const Real* v = s + n;
  V d[rigid_groups];
  V rate[rigid_groups];
  V f[rigid_groups];
  rigid_depths(p, s, Real(1), d);
  rigid_depths(p, v, Real(0), rate);
  rigid_forces(p, d, rate, f);

  const int first = 3 + p.modes;
  V y;
  V theta;
  V vy;
  load<Real>(s + first, y);
  load<Real>(s + first + p.bridges, theta);
  load<Real>(v + first, vy);
  const V slip = v[0] - (vy - v[1] * p.at);
  const V spring = p.preload + p.rate * (s[0] - (y - s[1] * p.at)) + p.damping * slip;
  if (losses != nullptr) {
    losses[0] = rigid_contact_loss(p, d, rate, f);
    losses[1] = lane_sum<Real>(p.damping * slip * slip);
  }
  const V seat = f[2] + f[3];
  const V pads = f[0] + f[1];
  const V ay = (spring - pads - seat) * p.inverse_mass;
  const V at =
      (p.pad_arm * (f[0] - f[1]) + p.seat_arm * (f[2] - f[3]) - p.turning * theta) * p.inverse_inertia;
  // idle lanes hold neither preload nor rate nor damping, so they add zero
  const V on_core = seat - spring;
  for (int i = 0; i < n; i += lane_count) {
    V part;
    load<Real>(v + i, part);
    store<Real>(part, ds + i);
  }
  Real* a = ds + n;
  const V& c = f[core_group];
  const Real core = pull - p.return_preload - p.return_rate * s[0] - p.core_damping * v[0] +
                    lane_sum<Real>(on_core) - (c[0] + c[1]) + (c[2] + c[3]);
  a[0] = p.friction.net(core) * p.inverse_core;
  a[1] = (lane_sum<Real>(p.at * on_core - p.to_tilt * c) - p.tilt_rate * s[1] - p.tilt_damping * v[1]) *
         p.inverse_tilt;
  const Real squeeze = p.buffer_rate * (s[2] - rigid_foot(p, s));
  const Real resist = p.buffer_damping * (v[2] - rigid_foot(p, v));
  a[2] = ((c[0] + c[1]) - pull - squeeze - resist + p.follow * lane_sum<Real>(pads)) * p.inverse_static;
  for (int m = 0; m < p.modes; ++m) {
    const Real push = (p.active & 3U) != 0 || p.automatic
                          ? lane_sum<Real>(p.shape[m][0] * f[0] + p.shape[m][1] * f[1])
                          : Real(0);
    a[3 + m] =
        (push + p.foot[m] * (squeeze + resist) - p.mode_rate[m] * s[3 + m] - p.mode_damping[m] * v[3 + m]) *
        p.inverse_mode[m];
  }
  store<Real>(ay, a + first);
  store<Real>(at, a + first + p.bridges);
}

/// Depths with the sign of their mode, and their derivatives; idle lanes get 1, 0, 0.
template <class Real>
POWBENCH_INLINE void rigid_signed_depths(const RigidLanes<Real>& p, const Lanes<Real>* sign, const Real* s,
                                         const Real* ds, Real* value, Real* rate, Real* curve) {
  Lanes<Real> d[rigid_groups];
  rigid_depths(p, s, Real(1), d);
  for (int g = 0; g < rigid_groups; ++g)
    store<Real>(sign[g] * d[g] + (Real(1) - sign[g] * sign[g]), value + g * lane_count);
  rigid_depths(p, s + p.dof, Real(0), d);
  for (int g = 0; g < rigid_groups; ++g) store<Real>(sign[g] * d[g], rate + g * lane_count);
  if (ds == nullptr) return;
  rigid_depths(p, ds + p.dof, Real(0), d);
  for (int g = 0; g < rigid_groups; ++g) store<Real>(sign[g] * d[g], curve + g * lane_count);
}

}  // namespace POWBENCH_LANE_SPACE
}  // namespace powbench::sim
