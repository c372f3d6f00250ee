#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "sim/vec.h"

/// Meshes of solid bodies. A part is a set of cells of one material that shares no node with other parts: parts act on
/// each other through contact alone.

namespace powbench::sim {

/// A hexahedron (8 nodes: bottom face anticlockwise seen from above, then the top face) or a tetrahedron (4 nodes, the
/// fourth on the side to which the first three turn anticlockwise; the rest are -1). The order is that of VTK and gmsh.
struct SolidCell {
  std::array<int, 8> nodes{-1, -1, -1, -1, -1, -1, -1, -1};
  int part = 0;

  bool is_hex() const { return nodes[4] >= 0; }
  int corners() const { return is_hex() ? 8 : 4; }
};

struct SolidMesh {
  std::vector<Vec3> nodes;  ///< m
  std::vector<SolidCell> cells;
  std::vector<std::string> parts;  ///< name of each part

  int add_part(const std::string& name);
};

/// Adds a brick lo .. hi of nx x ny x nz hexahedra to a part and returns the number of its first node. Node (i, j, k)
/// is the first plus i + (nx + 1) (j + (ny + 1) k).
int add_box(SolidMesh&, int part, const Vec3& lo, const Vec3& hi, int nx, int ny, int nz);

/// Adds the cells of a grid given by its planes, where `filled(i, j, k)` says which cells exist; nodes without a cell
/// are not made.
void add_grid(SolidMesh&, int part, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& z, const std::function<bool(int, int, int)>& filled);

/// Moves the nodes `first` .. last by a map.
void map_nodes(SolidMesh&, int first, const std::function<Vec3(const Vec3&)>&);

/// Places of its corners, m; of a tetrahedron the first four.
std::array<Vec3, 8> corners_of(const SolidMesh&, const SolidCell&);

/// Volume of one cell, m3; negative when it is inside out. Exact for trilinear hexahedra.
double cell_volume(const SolidMesh&, const SolidCell&);
double cell_volume(const std::array<Vec3, 8>& corners, bool hex);

/// Sum over the corners of |dV/dx|^2, m4: of the eight of a hexahedron, or the first four of a tetrahedron.
double gradient_square(const std::array<Vec3, 8>& corners, bool hex);

/// Throws std::invalid_argument with the number of the first cell that names a node or part that is not there, or whose
/// volume or whose Jacobian at a corner is not positive.
void check_mesh(const SolidMesh&);

}  // namespace powbench::sim
