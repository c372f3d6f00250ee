#pragma once

#include <functional>

#include "sim/magnetics/plane/grid.h"

/// Meshes of the cases with closed solutions.

namespace powbench::bench {

/// Evenly spaced lines.
std::vector<double> even_lines(double from, double to, int cells);

/// A quarter of a disc of this radius in its surroundings, out to `far`: region 1 inside, 0 outside; a square grid bent
/// so that the disc's edge is a line of the grid. A = 0 on x = 0 and on the far side.
sim::Mesh quarter_disc(double radius, double far, int cells, int outer_cells);

/// A wedge of `degrees` of the disc from x = 0, region 0; A = 0 on its outer edge.
sim::Mesh disc_wedge(double degrees, const std::vector<double>& radii);

}  // namespace powbench::bench
