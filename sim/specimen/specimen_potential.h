#pragma once

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/potential.h"
#include "sim/specimen/specimen.h"

/// The lumped circuit of `sim/magnetics/circuit/magnetic_circuit.h` behind the interface of magnetics: the states
/// are the flux linkage of the coil with its leakage, psi = N phi + L i, and the flux through the shading ring.
/// Also defined for a gap below zero, faces pressed together.

namespace powbench::sim {

/// Throws std::invalid_argument for a drawn magnet whose circuit is not stated (Specimen::lumped).
void require_circuit(const Specimen&);
/// Why a specimen has no lumped circuit; empty: it has.
std::string no_circuit(const Specimen&);

/// Throws as require_circuit.
class SpecimenPotential : public MagneticPotential {
 public:
  explicit SpecimenPotential(const Specimen&);

  bool has_ring() const override { return circuit_.has_ring(); }
  MagneticResponse at(const MagneticState&) const override;
  double ring_resistance() const { return circuit_.ring_resistance(); }

 private:
  MagneticCircuit circuit_;
  double turns_;
  double leakage_;
};

}  // namespace powbench::sim
