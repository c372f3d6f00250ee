#pragma once

#include "sim/fields/potential.h"
#include "sim/magnetic_circuit.h"

/// The lumped magnetic circuit of a specimen as a potential W(psi, phi_s, gap), so that bodies can be driven by it.

namespace powbench::sim {

class LumpedPotential : public MagneticPotential {
 public:
  explicit LumpedPotential(const Specimen&);
  bool has_ring() const override { return circuit_.has_ring(); }
  /// First derivatives exact; second derivatives by central differences of these.
  MagneticResponse at(const MagneticState&) const override;

 private:
  MagneticResponse first(const MagneticState&) const;

  MagneticCircuit circuit_;
  double turns_, leakage_;
};

}  // namespace powbench::sim
