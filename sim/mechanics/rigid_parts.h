#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/mechanics/contact_law.h"

/// The rigid contactor as data: a core with its bracket, a static core on buffer springs, double-break bridges and
/// the modes of the base that carries the fixed contacts. SI; lengths along x point in closing direction.

namespace powbench::sim {

inline constexpr int most_bridges = 8;
inline constexpr int most_base_modes = 4;

/// One double-break bridge: travel y and rotation theta about its middle. End 0 sits at -arm, end 1 at +arm.
struct RigidBridge {
  double mass = 5e-3;       ///< m, kg
  double inertia = 2.8e-7;  ///< J, kg m2
  double position = 0;      ///< m along the tilt axis' lever: the bracket there is at x + position * tilt
  double pad_arm = 10e-3;   ///< r, m
  double seat_arm = 4e-3;   ///< m
  double preload = 4;       ///< F_c0, N
  double rate = 1200;       ///< k_c, N/m
  double damping = 0.05;    ///< of the spring, N s/m
  double turning_rate = 0;  ///< N m/rad: the spring against rotation
  double gap[2] = {3e-3, 3e-3};  ///< m, of both breaks
};

/// One mode of the base: pads move by shape * amplitude.
struct BaseMode {
  double mass = 0.15;                  ///< kg, modal
  double hertz = 820;                  ///< Hz
  double damping = 0.01;               ///< ratio
  double shape[most_bridges][2] = {};  ///< at the fixed contact of bridge j, break s
  double buffer = 0;                   ///< shape at the foot of the static core's buffer springs
};

/// Pull that is given instead of computed:
/// F = peak (1 - exp(-t / rise)) (share + (1 - share) sin^2(2 pi f t)) / (1 + gap / range)^2.
struct GivenPull {
  double peak = 0;     ///< N
  double rise = 3e-3;  ///< s
  double share = 0.55;
  double hertz = 50;
  double range = 2e-3;  ///< m
};

struct RigidParts {
  // core and bracket
  double core_mass = 0.1;
  double core_inertia = 3e-5;      ///< kg m2, tilt
  double tilt_rate = 106.59;       ///< N m/rad: guide and return spring against tilt
  double tilt_damping = 5.655e-3;  ///< N m s/rad
  double travel = 5e-3;            ///< m
  double return_preload = 10;      ///< N, open
  double return_rate = 800;        ///< N/m
  double core_damping = 0.2;       ///< N s/m
  double core_friction = 0;        ///< N, Coulomb
  double pole_arm = 12e-3;         ///< m: pole faces and stops sit at +- this
  // static core on its buffer springs
  double static_mass = 0.12;   ///< kg
  double buffer_rate = 3e5;    ///< N/m
  double buffer_damping = 20;  ///< N s/m
  double pads_follow = 0;  ///< 1: the fixed contacts move with the static core, 0: only with the base modes
  std::vector<RigidBridge> bridges;
  std::vector<BaseMode> modes;
  ContactLaw pad, seat, pole, stop;
  GivenPull pull;
};

/// Throws std::invalid_argument with one sentence for the first value that no contactor can have: key, value,
/// allowed range.
void require_valid(const RigidParts&);

}  // namespace powbench::sim
