#pragma once

/// The one interface between magnetics and everything that moves. Every rung of the field ladder (lumped circuit,
/// table, 2D and 3D finite elements) is a stored energy W(psi, phi_s, gap) and its derivatives:
///
///   i   =  dW/dpsi      coil current, A
///   i_s =  dW/dphi_s    current in the shading ring (one turn), A
///   F   =  dW/dgap      pull on the moving core, N, positive in closing direction (the one that makes the gap smaller)
///
/// with the flux linkages as states: dpsi/dt = u - R i, dphi_s/dt = -R_s i_s. One potential makes reciprocity
/// exact (dF/dpsi = di/dgap) and lets the energy ledger of a closing end at round-off. SI throughout.

namespace powbench::sim {

struct MagneticState {
  double psi = 0;   ///< Wb, flux linkage of the coil, leakage included
  double ring = 0;  ///< Wb, flux linkage phi_s of the shading ring; without meaning where there is no ring
  double gap = 0;  ///< m, between the pole faces, >= 0; the residual gap of the specimen is added by the rung
};

/// W, its first derivatives by their physical names, and its second derivatives.
struct MagneticResponse {
  double energy = 0;        ///< J, zero without flux
  double current = 0;       ///< A, dW/dpsi
  double ring_current = 0;  ///< A, dW/dphi_s
  double pull = 0;          ///< N, dW/dgap, positive in closing direction
  double current_psi = 0;   ///< A/Wb, d2W/dpsi2 > 0: inverse differential inductance
  double current_ring = 0;  ///< A/Wb, d2W/dpsi dphi_s
  double ring_ring = 0;     ///< A/Wb, d2W/dphi_s2
  double current_gap = 0;   ///< A/m, d2W/dpsi dgap = dF/dpsi
  double ring_gap = 0;      ///< A/m, d2W/dphi_s dgap
  double pull_gap = 0;      ///< N/m, d2W/dgap2
  bool beyond = false;      ///< extrapolated: the state lies outside of what the rung was made from
};

/// A rung. Pure: equal states give equal bits, from any thread.
class MagneticPotential {
 public:
  virtual ~MagneticPotential() = default;

  /// True if the shading ring is a state of its own.
  virtual bool has_ring() const = 0;

  /// W and its derivatives; finite for every finite state with gap >= 0, also far beyond saturation.
  virtual MagneticResponse at(const MagneticState&) const = 0;

  /// Told by an integrator: the step for which states were asked since it was last told was taken, or tried in vain.
  /// For those that count.
  virtual void tried(bool /*taken*/) const {}
};

}  // namespace powbench::sim
