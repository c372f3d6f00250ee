#pragma once

#include <cmath>
#include <memory>

#include "core/units.h"
#include "sim/fields/steel.h"
#include "sim/specimen.h"

/// Lumped magnetic circuit with one saturable iron path and two parallel outer pole parts, one inside the
/// shading ring.
///
///   N i        = l H(phi / A) + r phi + r phi1 / (1 - a2)   path through the bare part, phi1 = phi - phi2
///   N i + i_sh = l H(phi / A) + r phi + r phi2 / a2         path through the ring
///   d phi2/dt  = -R_sh i_sh
///   psi        = N phi + L i                                flux linkage of the coil
///   r(g)       = g / (mu0 A (1 + c g)),  c = fringing / sqrt(A)
///
/// The stored energy W(phi, phi2, s) is the integral of H dB over the iron + r (phi^2 + phi1^2/(1-a2) +
/// phi2^2/a2) / 2, and the pull is its derivative at constant flux, so what the coil puts in and the core
/// takes out balance exactly. With the fluxes as states every relation is explicit: no B-H inversion is ever
/// needed.

namespace powbench::sim {

inline constexpr double mu0 = 4e-7 * pi;  ///< V s/(A m)

/// Everything the circuit gives at one state.
struct Field {
  double mmf = 0;              ///< N i, A
  double mmf_phi = 0;          ///< d mmf / d phi, A/Wb
  double mmf_phi2 = 0;         ///< d mmf / d phi2
  double mmf_separation = 0;   ///< d mmf / d separation, A/m
  double ring_current = 0;     ///< i_sh, A; its derivative by phi is mmf_phi2
  double ring_phi2 = 0;        ///< d ring_current / d phi2
  double ring_separation = 0;  ///< d ring_current / d separation = d pull / d phi2
  double pull = 0;  ///< N, on the moving core in closing direction; its derivative by phi is mmf_separation
  double pull_separation = 0;  ///< d pull / d separation, N/m
  double energy = 0;           ///< J, stored, without the leakage
};

class MagneticCircuit {
 public:
  /// Throws std::invalid_argument as `steel_of` does.
  explicit MagneticCircuit(const Magnet& magnet, double travel);

  /// False where the ring changes nothing: no shaded share, or a ring that settles within 50 ns at the open
  /// gap. Then phi2 = a2 phi.
  bool has_ring() const { return has_ring_; }
  double ring_resistance() const { return ring_resistance_; }
  double shaded_share() const { return share_; }
  double area() const { return area_; }

  /// The numbers of `field`; even_power < 0: the iron's law is no even power, or a steel stands in its place.
  struct Law {
    double area, iron_length, residual, fringe, inverse_bare, inverse_shaded, linear, saturation, exponent;
    int even_power;
  };
  Law law() const {
    return {area_,           iron_length_, residual_,   fringe_,   inverse_bare_,
            inverse_shaded_, linear_,      saturation_, exponent_, steel_ ? -1 : even_power_};
  }

  /// Air gap per pole at a separation s = travel - (x - z), m. Where the faces are pressed together (s < 0)
  /// the residual gap d shrinks as d^2 / (d - s): never to zero, with the slope continuous at s = 0.
  double gap(double separation) const {
    return separation >= 0 ? residual_ + separation : residual_ * residual_ / (residual_ - separation);
  }

  Field field(double phi, double phi2, double separation) const;

  /// The flux of a coil of N turns with L = N ratio in series: the root of N phi + ratio mmf = psi, by Halley's method.
  /// `phi2` counts where there is a ring.
  double flux(double psi, double turns, double ratio, double phi2, double separation) const;

 private:
  struct Iron {
    double mmf;          ///< A
    double slope, bend;  ///< dH/dB, m/H, and half its derivative by B; a steel tells no bend
    double energy;       ///< J
  };
  double power(double b) const;  ///< |b|^(exponent - 1)
  Iron iron(double b) const;
  double widening(double gap) const { return 1 / (1 + fringe_ * gap); }

  double area_;
  double iron_length_;
  double residual_;
  double fringe_;  ///< c, 1/m
  double share_;
  double inverse_bare_;    ///< 1 / (1 - a2)
  double inverse_shaded_;  ///< 1 / a2, 0 without a shaded share
  double ring_resistance_;
  double linear_;
  double saturation_;
  double exponent_;
  int even_power_;  ///< exponent - 1 where that is an even whole number, else -1
  bool has_ring_;
  std::shared_ptr<const Steel> steel_;  ///< in place of the law; null: the law
};

inline double MagneticCircuit::power(double b) const {
  if (even_power_ < 0) return std::pow(std::fabs(b), exponent_ - 1);
  double result = 1;
  double square = b * b;
  for (int n = even_power_ / 2; n > 0; n /= 2) {
    if (n % 2 == 1) result *= square;
    square *= square;
  }
  return result;
}

inline MagneticCircuit::Iron MagneticCircuit::iron(double b) const {
  const double volume = area_ * iron_length_;
  if (steel_) {
    const auto point = steel_->at(std::fabs(b));
    return {iron_length_ * std::copysign(point.h, b), point.dh_db, 0, volume * point.energy};
  }
  const double steep = saturation_ * power(b);
  const double bend = std::fabs(b) < 1e-100 ? 0.0 : 0.5 * exponent_ * (exponent_ - 1) * steep * (1 / b);
  return {iron_length_ * (linear_ + steep) * b, linear_ + exponent_ * steep, bend,
          volume * b * b * (0.5 * linear_ + steep / (exponent_ + 1))};
}

inline double MagneticCircuit::flux(double psi, double turns, double ratio, double phi2,
                                    double separation) const {
  const double g = gap(separation);
  const double r = ratio * (g * widening(g) / (mu0 * area_));
  // without a ring phi1 = (1 - a2) phi
  const double straight = turns + r * (has_ring_ ? 1 + inverse_bare_ : 2);
  const double sum = has_ring_ ? psi + r * inverse_bare_ * phi2 : psi;
  const double per_area = 1 / area_, per_slope = ratio * iron_length_ * per_area;
  // from beyond the answer, where the curve is steep: Newton comes down from there
  double phi = sum / (straight + (steel_ ? 0.0 : per_slope * linear_));
  const double enough = steel_ ? 1e-9 : 1e-6;  // what is left then is the square, or ten times the cube
  for (int pass = 0; pass < 100; ++pass) {
    const Iron i = iron(phi * per_area);
    const double miss = sum - straight * phi - ratio * i.mmf, slope = straight + per_slope * i.slope;
    const double change = miss * slope / (slope * slope + miss * (per_slope * per_area) * i.bend);
    phi += change;
    if (!(std::fabs(change) > enough * std::fabs(phi))) break;
  }
  return phi;
}

inline Field MagneticCircuit::field(double phi, double phi2, double separation) const {
  const double g = gap(separation);
  const double gap_slope = separation >= 0 ? 1.0 : (g / residual_) * (g / residual_);
  const double wide = widening(g);
  const double r = g * wide / (mu0 * area_);
  const double r_slope = wide * wide * gap_slope / (mu0 * area_);
  const double gap_bend = separation >= 0 ? 0.0 : 2 * g * gap_slope / (residual_ * residual_);
  const double r_bend = wide * wide / (mu0 * area_) * (gap_bend - 2 * fringe_ * wide * gap_slope * gap_slope);
  const double phi1 = phi - phi2;
  const Iron i = iron(phi / area_);
  Field f;
  f.mmf = i.mmf + r * (phi + inverse_bare_ * phi1);
  f.mmf_phi = iron_length_ / area_ * i.slope + r * (1 + inverse_bare_);
  f.mmf_phi2 = -r * inverse_bare_;
  f.mmf_separation = r_slope * (phi + inverse_bare_ * phi1);
  const double unlike = inverse_shaded_ * phi2 - inverse_bare_ * phi1;
  const double squares = phi * phi + inverse_bare_ * phi1 * phi1 + inverse_shaded_ * phi2 * phi2;
  f.ring_current = r * unlike;
  f.ring_phi2 = r * (inverse_shaded_ + inverse_bare_);
  f.ring_separation = r_slope * unlike;
  f.pull = 0.5 * r_slope * squares;
  f.pull_separation = 0.5 * r_bend * squares;
  f.energy = i.energy + 0.5 * r * squares;
  return f;
}

}  // namespace powbench::sim
