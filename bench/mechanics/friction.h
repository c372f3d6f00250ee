#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

/// Dry friction: a coefficient that falls with speed, a set-valued stick mode with events, and a return map for
/// codes that step without events.

namespace powbench::sim {

/// mu(v) = mu_d + (mu_s - mu_d) exp(-c |v|). At rest it is mu_s; a plus sign in the bracket, as once printed, gives
/// mu_s + 2 mu_d there.
struct FrictionLaw {
  double at_rest = 0;  ///< mu_s
  double sliding = 0;  ///< mu_d
  double decay = 0;    ///< c, s/m
  double coefficient(double speed) const {
    return sliding + (at_rest - sliding) * std::exp(-decay * std::fabs(speed));
  }
};

enum class FrictionMode : std::uint8_t { stick, forward, backward };

/// What follows where the slip speed is zero: stick while the driving force can be held, else slide its way.
inline FrictionMode after_stop(double drive, double limit) {
  if (std::fabs(drive) <= limit) return FrictionMode::stick;
  return drive > 0 ? FrictionMode::forward : FrictionMode::backward;
}

/// Force on the sliding body.
inline double friction_force(FrictionMode mode, double drive, double limit) {
  if (mode == FrictionMode::stick) return -drive;
  return mode == FrictionMode::forward ? -limit : limit;
}

/// Positive while the mode lasts: sliding until the speed is zero, sticking until the drive exceeds the limit.
inline double friction_guard(FrictionMode mode, double speed, double drive, double limit) {
  if (mode == FrictionMode::stick) return limit - std::fabs(drive);
  return mode == FrictionMode::forward ? speed : -speed;
}

/// Elastic-plastic friction for fixed steps: trial force f - k du, cut to the limit in magnitude with its direction
/// kept. While it sticks, tangential damping takes the ringing of k out; without it the rest speed never decays.
struct ReturnMap {
  double stiffness = 0;  ///< k_t, N/m
  double damping = 0;    ///< N s/m, only while sticking
  double elastic = 0;    ///< N, held force
  bool sticks = false;

  /// Force on the body after the slip `du` m at the speed `rate`.
  double step(double du, double rate, double limit) {
    const double trial = elastic - stiffness * du;
    sticks = std::fabs(trial) <= limit;
    elastic = std::clamp(trial, -limit, limit);
    return sticks ? elastic - damping * rate : elastic;
  }
};

}  // namespace powbench::sim
