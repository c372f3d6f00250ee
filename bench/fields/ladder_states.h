#pragma once

#include <utility>
#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/space/core_mesh.h"

/// The same states on every rung of the field: gaps and currents of the reference contactor, the ring open.

namespace powbench::bench {

struct FieldState {
  double gap = 0, current = 0;  ///< m, A
  double flux = 0, pull = 0;    ///< Wb, N
};
using FieldStates = std::vector<FieldState>;

FieldStates states_of(const sim::MagnetDesign&, const sim::FieldOptions&);
FieldStates states_of(const sim::MagnetDesign&, const sim::space::CoreMeshSizes&);

/// On a potential: the fluxes where W - i psi is least, from those of `guess`. Throws std::runtime_error where Newton
/// does not arrive.
FieldStates states_of(const sim::MagneticPotential&, const FieldStates& guess);

/// Largest relative errors of flux linkage, and of the pull where it is above 1 N. Zero without states.
std::pair<double, double> worst(const FieldStates&, const FieldStates& truth);

}  // namespace powbench::bench
