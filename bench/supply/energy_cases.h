#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/potential.h"
#include "sim/models/closing.h"

/// Switch-ons whose energy is balanced: u i = R i^2 + stored + mechanical + ring loss. Tests and benchmark share them.

namespace powbench::bench {

/// Of one method over some closing angles.
struct EnergyRow {
  std::string method, setting;
  int closings = 0;
  double supplied = 0;  ///< J, of the closing that took least
  double residual = 0;  ///< worst, of the supplied energy
  double limit = 0;
  double cpu_ms = 0;  ///< a closing
  int seated = 0;     ///< closings whose core arrived
};

/// The magnet of the reference specimen as finite elements see it.
sim::MagnetDesign reference_design();

/// Every `step` deg from 0 to below 180, on both models with the specimen's own circuit.
std::vector<EnergyRow> circuit_rows(double step, double tolerance);
/// The same behind supplies and switches, and with remanence; switched off and on to rest.
std::vector<EnergyRow> supply_rows(double step, double tolerance);
/// Another potential under the rigid rung.
EnergyRow potential_row(const std::string& name, const sim::MagneticPotential&, double step,
                        double tolerance);
/// The circuit drawn from the shape of the reference specimen.
std::unique_ptr<sim::MagneticPotential> shape_circuit();
/// A table of that magnet, with or without the flux of the ring, coarse.
std::unique_ptr<sim::MagneticPotential> coarse_table(bool ring);
/// The field itself in the loop, with motion: implicit midpoint steps of `seconds`.
EnergyRow field_row(double step, double seconds, bool ring);

}  // namespace powbench::bench
