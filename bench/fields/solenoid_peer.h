#pragma once

#include <optional>
#include <string>

#include "sim/magnetics/plane/solenoid_field.h"

/// A solenoid by FreeFem++: its own unstructured mesh of gmsh, quadratic elements for the flux function r A, full
/// Newton steps, pull by Maxwell's stress with the same weight, or for faces that are not flat with a harmonic one.
/// Steel `reference` only.

namespace powbench::bench {

struct SolenoidPeer {
  double flux = 0, pull = 0;  ///< Wb, N
  int unknowns = 0, iterations = 0;
  double cpu = 0;  ///< s, of FreeFem++ as a process
};

/// At the whole gap, residual gap included, m. `size` scales all cells. Nothing without gmsh or FreeFem++, or where one
/// fails; everything is written into `folder`.
std::optional<SolenoidPeer> solenoid_by_freefem(const std::string& folder, const sim::SolenoidDesign&,
                                                double gap, double current, double size);

}  // namespace powbench::bench
