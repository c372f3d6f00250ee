#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/magnetics/potential.h"

/// The magnet as system simulators want it: flux linkage and force over current and position, the shading ring at rest.

namespace powbench::host {

/// Position x = travel - gap, m: 0 open, rising in closing direction, so that F = integral of dPhi/dx di is the pull.
/// Currents begin at 0; Phi(-i, x) = -Phi(i, x), F(-i, x) = F(i, x).
struct ActuatorTable {
  std::vector<double> current, position;  ///< A, m
  /// By current, then position: Wb, N, H, Wb/m.
  std::vector<double> linkage, force, linkage_current, linkage_position;
  double linear_error_linkage = 0,
         linear_error_force = 0;  ///< largest in the middle of a cell, as a share of the largest value
  std::vector<std::uint8_t> extrapolated;  ///< by current, then position: 1 outside of the potential's nodes
  double beyond = 0;                       ///< share of these
  std::size_t at(std::size_t i, std::size_t x) const { return i * position.size() + x; }
};

/// Currents 0 .. `largest_current` and positions 0 .. `travel`, denser towards 0 and towards the closed core. The
/// potential has no ring. Throws BadInput where no current of that size is reached.
ActuatorTable actuator_table(const sim::MagneticPotential&, double largest_current, double travel,
                             std::size_t currents = 81, std::size_t positions = 61);

/// One line a state: current, position, flux linkage, force, both derivatives, with units in the header, extrapolated.
std::string actuator_csv(const ActuatorTable&);

/// Text file of Modelica's table blocks: the matrices `flux_linkage` and `force`, current down (u1), position across
/// (u2).
std::string actuator_modelica(const ActuatorTable&, const std::string& title);

/// MAT-file of level 5. For Simscape's FEM-Parameterized Linear Actuator the vectors i, x and the matrices Phi,
/// dPhi_di, dPhi_dx, F; for Modelica's table blocks the matrices `flux_linkage` and `force` with their axes.
std::string actuator_mat(const ActuatorTable&);

}  // namespace powbench::host
