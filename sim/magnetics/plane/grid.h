#pragma once

#include <functional>
#include <vector>

#include "sim/magnetics/plane/mesh.h"

/// Graded tensor grids: the quick way to a mesh whose topology depends on the shape alone.

namespace powbench::sim {

/// A line of the grid that must be there, and the cell size wanted beside it.
struct GridStop {
  double at = 0;    ///< m
  double size = 0;  ///< m; 0: the line sets no size
};

/// Lines through all stops, which must ascend strictly. The cell size grows from each stop's size by the factor
/// `growth` from cell to cell, up to `largest`.
std::vector<double> graded_lines(const std::vector<GridStop>& stops, double growth, double largest);

/// Two triangles a cell, with alternating diagonals. `region(x, y)` is asked at the middle of each cell; a negative
/// region leaves the cell out. A = 0 on the sides of the grid named by the flags.
struct GridSides {
  bool left = true, right = true, bottom = true, top = true;
};
Mesh tensor_mesh(const std::vector<double>& x, const std::vector<double>& y,
                 const std::function<int(double, double)>& region, GridSides zero);

}  // namespace powbench::sim
