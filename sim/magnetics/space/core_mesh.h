#pragma once

#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/space/problem.h"

/// The core of a `MagnetShape` in three dimensions: of three legs a quarter (x >= 0, y >= 0), of two the half y >= 0,
/// with the stack along y, the coil with its heads and the shading rings with theirs, in air. z is the direction of
/// motion; z = 0 is the fixed pole face.

namespace powbench::sim::space {

struct CoreRegion {
  enum : int { air, strip, iron, count };
};

/// Cell sizes, m.
struct CoreMeshSizes {
  double corner = 0.25e-3;  ///< beside the edges of the pole faces
  double other = 2.5e-3;    ///< beside the other edges
  double largest = 5e-3;    ///< within the core's outline
  double far = 40e-3;       ///< largest in the air around
  double growth = 3.2;      ///< from cell to cell
  int layers = 3;           ///< of cells in the gap
  bool ends = true;         ///< false: the plane problem, one layer of cells between the ends of the stack

  CoreMeshSizes scaled(double factor) const;
};

/// Windings: the coil with its turns; then, if the shape has them, both rings in series with one turn each. Positive
/// currents drive flux the same way round the windows. The strip has the height `gap`, m, > 0; a closed leg goes
/// through it as iron, which stretches with its nodes. Throws std::invalid_argument by `check_shape`.
Problem core_problem(const MagnetDesign&, const CoreMeshSizes&, double gap);

/// How far each node moves with the moving half: 0 up to the fixed pole face, 1 above the moving one. Weight of the
/// pull.
std::vector<double> core_motion(const Mesh&, double gap);

/// 0 below and 1 above the middle layer of the strip.
std::vector<double> core_layer(const Mesh&, const CoreMeshSizes&, double gap);

}  // namespace powbench::sim::space
