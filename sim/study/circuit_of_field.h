#pragma once

#include <string>
#include <vector>

#include "sim/magnetics/potential.h"
#include "sim/specimen/specimen.h"
#include "sim/team.h"

/// The lumped circuit that is nearest to a field: what a rung of fields says of current and pull, in the numbers that
/// the circuit, the simulated rig and the mock-up unit take.

namespace powbench::sim {

/// Deviation of the circuit from the field, as shares: of the value, or of 2 % of the largest where that is more.
struct CircuitDeviation {
  double gap = 0;  ///< m; of the sum over all gaps without meaning
  double current_rms = 0, current_worst = 0, pull_rms = 0, pull_worst = 0;
};

struct CircuitFit {
  Specimen specimen;  ///< as given, with the numbers of the circuit in `magnet` and `coil.leakage`
  std::vector<CircuitDeviation> by_gap;  ///< from closed to open
  CircuitDeviation all;
  std::vector<std::string>
      at_end;  ///< keys whose number stands at an end of its range: another law would be nearer
};

/// Least squares over 12 flux linkages up to `largest_psi` (Wb) and 12 gaps, 0 .. travel, denser towards 0, with no
/// current in the ring: pole area, iron length or - where the specimen is drawn or its law free - the law a B + b B^n
/// on the stated length, fringing and leakage. The shaded share is the ring's part of the flux, at the middle gap.
/// Residual gap, turns and ring resistance are kept. Deterministic, on any number of threads. Throws
/// std::invalid_argument where the field does not let flux through.
CircuitFit identify_circuit(const Specimen&, const MagneticPotential& field, double largest_psi, Team&);

}  // namespace powbench::sim
