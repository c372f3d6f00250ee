#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

/// Meshes from gmsh: file formats MSH 2.2 and 4.1, text or binary (little endian), from memory to nodes, elements and
/// physical groups. Format: gmsh reference manual, "MSH file format version 4.1" and "version 2 (Legacy)". In version
/// 2.2 an element of two physical groups stands there twice. Coordinates are passed on as they stand in the file;
/// whoever knows the unit scales them to m.

namespace powbench::sim {

enum class MshShape { point, line, triangle, quadrangle, tetrahedron, hexahedron };

/// Dimension of a shape: 0 .. 3.
int msh_dimension(MshShape);

/// Elements of one kind on one geometric entity.
struct MshBlock {
  MshShape shape = MshShape::point;
  int order = 1;              ///< of the shape functions: 1 or 2
  int entity = 0;             ///< tag of the geometric entity
  std::vector<int> groups;    ///< tags of the physical groups it belongs to, in the order of the file
  int nodes_per_element = 1;  ///< 1, 2, 3, 4, 8 (order 1); 3, 6, 8, 9, 10, 20, 27 (order 2)
  std::vector<int> nodes;  ///< indices into MshMesh::nodes, element after element, in gmsh's order of nodes

  int elements() const { return static_cast<int>(nodes.size()) / nodes_per_element; }
};

/// A physical group. Groups without a name in the file have an empty one.
struct MshGroup {
  int dimension = 0;
  int tag = 0;
  std::string name;
};

struct MshMesh {
  std::vector<std::array<double, 3>> nodes;
  std::vector<MshBlock> blocks;
  std::vector<MshGroup> groups;  ///< each pair of dimension and tag once

  /// The group of that name and dimension, null if there is none.
  const MshGroup* group(std::string_view name, int dimension) const;
};

/// Throws std::invalid_argument with one sentence that begins "line N:" ("byte N:" inside binary data) for whatever is
/// not a mesh of points, lines, triangles, quadrangles, tetrahedra and hexahedra of order 1 or 2. Unknown sections
/// ($Periodic, $NodeData, ...) are passed over.
MshMesh read_msh(std::string_view content);

}  // namespace powbench::sim
