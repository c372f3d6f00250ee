#pragma once

#include <functional>
#include <vector>

#include "sim/magnetics/space/mesh.h"

/// Structured meshes: the product of three graded lines.

namespace powbench::sim::space {

/// A plane of the grid and the size wanted for the cells that touch it, m.
struct GridMark {
  double at = 0;
  double size = 0;
};

/// Positions from the first mark to the last. Every mark is one of them; from each mark the cells grow by at most
/// `growth` a cell up to `largest`. Throws std::invalid_argument unless marks rise strictly, sizes are above 0 and
/// growth is above 1.
std::vector<double> graded_line(const std::vector<GridMark>&, double growth, double largest);

/// Hexahedra on the product of three lines. `region` is asked at each cell's centre; cells with a region below 0 are
/// left out. `cell` is hex8, hex20 or hex27.
Mesh grid_mesh(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z,
               Cell cell, const std::function<int(const Vec3&)>& region);

/// Moves every node.
void map_nodes(Mesh&, const std::function<Vec3(const Vec3&)>&);

}  // namespace powbench::sim::space
