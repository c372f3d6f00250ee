#pragma once

#include "sim/magnetics/potential.h"

/// A constant inductance in series with the coil, as a potential of its own: the state is the flux linkage of both.
///
///   W_s(lambda, phi_s, gap) = min over psi of W(psi, phi_s, gap) + (lambda - psi)^2 / (2 L),   lambda = psi + L i

namespace powbench::sim {

class SeriesInductance final : public MagneticPotential {
 public:
  /// `coil` must outlive this. `inductance` L > 0, H. Throws std::invalid_argument for another.
  SeriesInductance(const MagneticPotential& coil, double inductance);

  bool has_ring() const override { return coil_.has_ring(); }
  /// `psi` of the state is lambda.
  MagneticResponse at(const MagneticState&) const override;
  void tried(bool taken) const override { coil_.tried(taken); }

 private:
  const MagneticPotential& coil_;
  double inductance_;
};

}  // namespace powbench::sim
