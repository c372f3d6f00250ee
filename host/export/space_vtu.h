#pragma once

#include "host/export/vtu.h"
#include "sim/magnetics/space/magnet_field.h"

namespace powbench::host {

/// A solution in space on tetrahedra with ten nodes as a grid, where the nodes are at its gap: the potential u [A] at
/// the points; B [T] as a vector, |B| [T] and the region in the middle of each cell.
VtuGrid space_grid(const sim::space::Coenergy&, const sim::space::State&);

}  // namespace powbench::host
