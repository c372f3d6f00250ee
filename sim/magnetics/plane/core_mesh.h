#pragma once

#include <string>
#include <vector>

#include "sim/magnetics/magnet_shape.h"
#include "sim/magnetics/plane/mesh.h"

/// The mesh of a `MagnetShape` in its air: the half x >= 0 of a core with three legs, the whole one with two; one
/// topology for every gap. The strip between the pole faces is meshed with the height `strip_height`; the true gap
/// scales it (FieldProblem::set_gap).

namespace powbench::sim {

/// Regions of a core mesh.
struct CoreRegion {
  enum : int {
    air,
    strip,
    fixed_iron,
    moving_iron,
    coil,  ///< in the window
    ring_inner,
    ring_outer,
    coil_back,   ///< on the other side of the leg, two legs
    strip_iron,  ///< of a closed leg: stretches with the strip
    count
  };
};

/// Cell sizes, m. The defaults give 0.1 % in psi and in F.
struct CoreMeshSizes {
  double corner = 0.12e-3;  ///< beside the corners of the pole faces
  double other = 1.5e-3;    ///< beside the other corners
  double iron = 3e-3;       ///< largest within the core's outline
  double far = 40e-3;       ///< largest in the air around
  double growth = 2.0;      ///< from cell to cell

  /// All sizes times `factor`; the growth falls with them.
  CoreMeshSizes scaled(double factor) const;
};

inline constexpr double strip_height = 1e-3;  ///< m, the strip as meshed

/// Height of the moving part above the strip is kept when the gap changes. `largest_gap` sets the number of layers in
/// the strip. Throws std::invalid_argument by `check_shape`.
Mesh core_mesh(const MagnetShape&, const CoreMeshSizes&, double largest_gap);

/// The height of the strip's layers as shares of its height, ascending from 0 to 1.
std::vector<double> strip_layers(const CoreMeshSizes&, double largest_gap);

/// One value outside its range.
struct ShapeError {
  std::string key;
  std::string value;  ///< in mm, or plain for shares
  std::string range;
};

/// All errors of a shape: lengths out of range (a slip between mm and m is one), parts that overlap, a ring that
/// does not fit into its pole. Empty = usable.
std::vector<ShapeError> shape_errors(const MagnetShape&);

/// Throws std::invalid_argument with one sentence an error.
void check_shape(const MagnetShape&);

}  // namespace powbench::sim
