#pragma once

#include <string>
#include <vector>

#include "sim/magnetics/space/space_magnet.h"

namespace powbench::host {

/// A section through a magnet drawn in space, along z: |B| as colour, the outlines of iron, winding and ring. The plane
/// goes through the middle of the winding, or, where the drawing ends at a plane of symmetry inside the winding, along
/// that; of the two planes along z the one that cuts more iron. The mesh is that of a field at its gap, `b` |B| in the
/// middle of each of its cells, T.
std::string space_svg(const sim::SpaceMagnet&, const sim::space::Mesh&, const std::vector<double>& b,
                      const std::string& title);

}  // namespace powbench::host
