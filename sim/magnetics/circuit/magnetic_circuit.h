#pragma once

#include <cmath>
#include <memory>

#include "core/units.h"
#include "sim/magnetics/circuit/circuit_equations.h"
#include "sim/magnetics/circuit/lumped_magnet.h"
#include "sim/magnetics/steel.h"

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

using Field = FieldOf<OneNumber>;

class MagneticCircuit {
 public:
  /// Throws std::invalid_argument as `steel_of` does.
  explicit MagneticCircuit(const Magnet& magnet, double travel);

  /// False where the ring changes nothing: no shaded share, or a ring that settles within 50 ns at the open
  /// gap. Then phi2 = a2 phi.
  bool has_ring() const { return has_ring_; }
  double ring_resistance() const { return n_.ring_resistance; }
  double shaded_share() const { return n_.share; }
  double area() const { return n_.area; }

  const CircuitNumbers<double>& numbers() const { return n_; }
  /// exponent - 1 where that is an even whole number >= 2 and no steel stands in place of the law, else -1.
  int even_power() const { return steel_ ? -1 : even_power_; }

  /// Air gap per pole at a separation s = travel - (x - z), m. Where the faces are pressed together (s < 0)
  /// the residual gap d shrinks as d^2 / (d - s): never to zero, with the slope continuous at s = 0.
  double gap(double separation) const { return gap_of<OneNumber>(n_, separation); }

  IronOf<OneNumber> iron(double flux_density) const;
  Field field(double phi, double phi2, double separation) const;

  /// The flux of a coil of N turns with L = N ratio in series: the root of N phi + ratio mmf = psi, by Halley's method.
  /// `phi2` counts where there is a ring.
  double flux(double psi, double turns, double ratio, double phi2, double separation) const;

 private:
  double power(double b) const;               ///< |b|^(exponent - 1)
  double bend(double b, double steep) const;  ///< half the derivative of the slope; a steel tells none
  double widening(double gap) const { return 1 / (1 + n_.fringe * gap); }

  CircuitNumbers<double> n_;
  int even_power_;  ///< exponent - 1 where that is an even whole number, else -1
  bool has_ring_;
  std::shared_ptr<const Steel> steel_;  ///< in place of the law; null: the law
};

inline double MagneticCircuit::power(double b) const {
  return even_power_ < 0 ? std::pow(std::fabs(b), n_.exponent - 1) : even_power_of<OneNumber>(even_power_, b);
}

inline IronOf<OneNumber> MagneticCircuit::iron(double b) const {
  if (!steel_) return law_iron<OneNumber>(n_, power(b), b);
  const auto point = steel_->at(std::fabs(b));
  return {n_.iron_length * std::copysign(point.h, b), point.dh_db, n_.volume * point.energy, 0.0};
}

inline double MagneticCircuit::bend(double b, double steep) const {
  return std::fabs(b) < 1e-100 ? 0.0 : 0.5 * n_.exponent * (n_.exponent - 1) * steep * (1 / b);
}

inline double MagneticCircuit::flux(double psi, double turns, double ratio, double phi2,
                                    double separation) const {
  const double g = gap(separation);
  const double r = ratio * (g * widening(g) / n_.mu0_area);
  // without a ring phi1 = (1 - a2) phi
  const double straight = turns + r * (has_ring_ ? n_.one_bare : 2);
  const double sum = has_ring_ ? psi + r * n_.inverse_bare * phi2 : psi;
  const double per_area = 1 / n_.area, per_slope = ratio * n_.iron_length * per_area;
  // from beyond the answer, where the curve is steep: Newton comes down from there
  double phi = sum / (straight + (steel_ ? 0.0 : per_slope * n_.linear));
  const double enough = steel_ ? 1e-9 : 1e-6;  // what is left then is the square, or ten times the cube
  for (int pass = 0; pass < 100; ++pass) {
    const double b = phi * per_area;
    const IronOf<OneNumber> i = iron(b);
    const double miss = sum - straight * phi - ratio * i.mmf, slope = straight + per_slope * i.slope;
    const double change = miss * slope / (slope * slope + miss * (per_slope * per_area) * bend(b, i.steep));
    phi += change;
    if (!(std::fabs(change) > enough * std::fabs(phi))) break;
  }
  return phi;
}

inline Field MagneticCircuit::field(double phi, double phi2, double separation) const {
  return circuit_field(n_, reluctance<OneNumber>(n_, separation), iron(phi / n_.area), phi, phi2);
}

}  // namespace powbench::sim
