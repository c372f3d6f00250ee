#pragma once

#include <vector>

#include "sim/magnetics/magnet_shape.h"
#include "sim/magnetics/potential.h"
#include "sim/magnetics/steel.h"

/// The rung `circuit`: a nonlinear magnetic circuit drawn from the same shape, steel and turns as the field rungs.
///
///   W(psi, phi_s, gap) = min over phi of (psi - N phi)^2 / (2 L) + sum over sections A l w(phi / A)
///                        + P_c^-1 phi^2 / 2 + P_b^-1 (phi - phi_s)^2 / 2 + P_s^-1 phi_s^2 / 2
///
/// phi: flux through the centre leg, phi_s: through the shaded parts of both outer legs together. L: leakage across the
/// windows and of the winding's heads. Each gap has the permeance of its face and of its edges (a half cylinder between
/// the edges and half rings between the flanks):
///
///   P = mu0 (A / g + sum over edges of length (0.26 + ln(1 + 2 flank / g) / pi))
///
/// The ring's slot of width s adds half of what Carter found for a slot opposite to a smooth face to the face at
/// either side of it:
///
///   P_slot = mu0 length (s / g - gamma) / 2,   gamma = (4 / pi) (x atan x - ln(1 + x^2) / 2),   x = s / (2 g)
///
/// With three legs the outer ones and both halves of the yokes are parallel; with two there is one of each. A closed
/// leg has no gap, and its iron gets longer with that of the other leg: A (gap + residual gap) w(phi / A).
///
/// Source of the edge terms: H. C. Roters, Electromagnetic Devices (Wiley 1941), chapter V. All derivatives are
/// analytic.

namespace powbench::sim {

struct CircuitOptions {
  bool stack_ends = true;  ///< edges and leakage at both ends of the stack; false: in the plane, as `plane`
};

class CircuitPotential final : public MagneticPotential {
 public:
  /// `end_leakage`: H, of the winding's heads. Throws std::invalid_argument for a shape, a residual gap or turns that
  /// cannot be.
  CircuitPotential(const MagnetShape&, const Steel&, double turns, double residual_gap,
                   double end_leakage = 0, const CircuitOptions& = {});

  bool has_ring() const override { return shaded_.area > 0; }
  MagneticResponse at(const MagneticState&) const override;

  /// Leakage inductance that is in series with the core, H.
  double leakage() const { return leakage_; }

  /// R_e of the eddy currents in the sheets, ohm (`TransientSetup::sheet_resistance`), for a sheet's thickness in m
  /// and its conductivity in S/m, both above 0:
  ///
  ///   1 / R_e = sigma d^2 / (12 N^2) sum of l / A_iron over the sections that carry phi
  ///
  /// The first term of the law of a sheet, H = B / mu z coth z with z = (1 + j) d / (2 delta), in j omega: good while
  /// the skin depth delta is above half of the thickness. Throws std::invalid_argument for values that cannot be.
  double sheet_resistance(double thickness, double conductivity) const;

  /// Flux through the centre leg for given flux linkages, Wb.
  double core_flux(double psi, double ring, double gap) const;

 private:
  /// A piece of iron: energy A l w(phi / A) and its derivatives by the flux through it.
  struct Section {
    double length = 0, area = 0;
  };
  /// A gap: reluctance 1 / P and its derivatives by the gap.
  struct Reluctance {
    double value = 0, slope = 0, curvature = 0;
  };
  struct Face {
    double area = 0;
    double extra = 0;  ///< m, beside the common gap
    struct Edge {
      double length, flank;
    };
    std::vector<Edge> edges;
    double slot_length = 0, slot = 0;  ///< of the slot beside the face, and its width
  };
  struct Derivatives {
    double energy = 0, first = 0, second = 0;
  };

  Derivatives iron(const std::vector<Section>&, double flux) const;
  Derivatives path(double flux, double gap) const;
  Reluctance reluctance(const Face&, double gap) const;

  Steel steel_;
  double turns_;
  double residual_gap_;
  double leakage_ = 0;
  double stack_factor_ = 1;
  std::vector<Section> path_;         ///< carries phi
  std::vector<Section> column_;       ///< carries phi: 1 m of a closed leg, or nothing
  std::vector<Section> shaded_tips_;  ///< carries phi_s
  std::vector<Section> bare_tips_;    ///< carries phi - phi_s
  Face centre_, bare_, shaded_;
};

}  // namespace powbench::sim
