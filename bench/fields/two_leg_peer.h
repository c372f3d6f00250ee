#pragma once

#include <optional>
#include <string>

#include "sim/magnetics/plane/magnet_field.h"

/// A U- or C-core by FreeFem++: unstructured mesh of gmsh, quadratic elements, full Newton steps, pull by the stress
/// weighted with a displacement that is linear in the gap. Steel `reference` only, stack factor 1, no ring.

namespace powbench::bench {

struct TwoLegPeer {
  double flux = 0, pull = 0;  ///< Wb, N
  int unknowns = 0, iterations = 0;
  double same_mesh_flux = 0;  ///< Wb, the own elements and Newton on the peer's mesh
};

/// At the whole gap, residual gap included, m. `size` scales all cells. Nothing without gmsh or FreeFem++, or where one
/// fails; everything is written into `folder`.
std::optional<TwoLegPeer> two_legs_by_freefem(const std::string& folder, const sim::MagnetDesign&, double gap,
                                              double current, double size);

}  // namespace powbench::bench
