#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

/// Laws of a contact that presses: F(d, d') of the depth d > 0 and its rate, SI. All are written
///
///   F = k d^n (1 + lambda d') + c ramp(d) d'
///
/// | form                | lambda                     | c, ramp                                           |
/// | none                | 0                          | Hertz for n = 1.5, spring for n = 1               |
/// | hunt_crossley       | the damping itself, s/m    |                                                   |
/// | lankarani_nikravesh | 3 (1 - e^2) / (4 v0)       | e = damping, v0 = speed at touch                  |
/// | flores              | 8 (1 - e) / (5 e v0)       | e = damping                                       |
/// | ramped              | 0                          | c = damping, ramp rises smoothly over `ramp` m    |
/// | linear              | 0                          | c = damping, ramp = 1: F = k d^n + c d' as printed |
///
/// F is cut at zero: a contact never pulls. With `linear` the force jumps to c v at touch, and it leaves with the
/// depth still positive: open, pressing and detached are three states, and the end of pressing is F = 0.

namespace powbench::sim {

enum class DampingForm : std::uint8_t { none, hunt_crossley, lankarani_nikravesh, flores, ramped, linear };

struct ContactLaw {
  double stiffness = 1e8;  ///< k, N/m^n, > 0
  double exponent = 1.5;   ///< n: 1, 1.5 or 2
  DampingForm form = DampingForm::none;
  double damping = 0;  ///< lambda s/m, restitution e, or c N s/m, by form
  double ramp = 0;     ///< m, > 0 for `ramped`

  /// lambda for a touch at the speed v0 > 0, s/m.
  double hysteresis(double v0) const {
    constexpr double slowest = 1e-9;  // m/s: below this the touch is a rest, and any lambda gives the same
    const double v = std::max(v0, slowest);
    switch (form) {
      case DampingForm::hunt_crossley:
        return damping;
      case DampingForm::lankarani_nikravesh:
        return 0.75 * (1 - damping * damping) / v;
      case DampingForm::flores:
        return 1.6 * (1 - damping) / (damping * v);
      default:
        return 0;
    }
  }
  double viscous() const {
    return form == DampingForm::linear || form == DampingForm::ramped ? damping : 0.0;
  }
};

/// k d^n of d > 0.
template <class Real>
inline Real elastic_force(const ContactLaw& law, Real depth) {
  const Real k = static_cast<Real>(law.stiffness);
  if (law.exponent == 1) return k * depth;
  if (law.exponent == 2) return k * depth * depth;
  if (law.exponent == 1.5) return k * depth * std::sqrt(depth);
  return k * std::pow(depth, static_cast<Real>(law.exponent));
}

/// C1 ramp of the viscous part over the depth `width`: 0 at the surface, 1 from `width` on.
template <class Real>
inline Real depth_ramp(Real depth, Real width) {
  const Real u = std::min(depth / width, Real(1));
  return u * u * (3 - 2 * u);
}

/// Force before the cut at zero; `hysteresis` is lambda of this touch. depth > 0.
template <class Real>
inline Real raw_force(const ContactLaw& law, Real depth, Real rate, Real hysteresis) {
  Real f = elastic_force(law, depth) * (1 + hysteresis * rate);
  if (law.form == DampingForm::linear) f += static_cast<Real>(law.damping) * rate;
  if (law.form == DampingForm::ramped)
    f += static_cast<Real>(law.damping) * depth_ramp(depth, static_cast<Real>(law.ramp)) * rate;
  return f;
}

/// Restitution of Hunt and Crossley's law for lambda v: the root e of
/// ln((1 + lambda v) / (1 - lambda e v)) = lambda v (1 + e). Does not depend on k, n or the mass; the common
/// 1 - 2/3 lambda v is its start only (0.600 instead of 0.712 at 0.6).
double hunt_crossley_restitution(double lambda_v);
/// lambda v of a restitution 0 < e <= 1: the inverse, to rounding.
double hunt_crossley_approach(double restitution);

/// Natural length in s (dt = sqrt(d) ds) of an impact that has now the depth d and the rate v.
template <class Real>
inline Real root_scale(Real stiffness, Real mass, Real depth, Real rate) {
  const Real d = std::max(depth, Real(0));
  const Real energy = mass * rate * rate / 2 + stiffness * d * d * std::sqrt(d) / Real(2.5L);
  const Real deepest = std::pow(Real(2.5L) * energy / stiffness + Real(1e-40L), Real(0.4L));
  const Real fastest = std::sqrt(2 * energy / mass + Real(1e-30L));
  return 2 * std::sqrt(deepest) / fastest;
}

}  // namespace powbench::sim
