#pragma once

#include "host/export/vtu.h"
#include "sim/magnetics/plane/field_problem.h"

namespace powbench::host {

/// A plane or axisymmetric solution as a grid of its own triangles, quadratic ones with six points, the strip at its
/// true height: A [Wb/m] at the points; B [T] as a vector, |B| [T] and the region in each triangle. `a` as Newton
/// left it.
VtuGrid field_grid(const sim::FieldProblem&, const std::vector<double>& a);

}  // namespace powbench::host
