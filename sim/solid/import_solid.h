#pragma once

#include "sim/fields/msh.h"
#include "sim/solid/solid_mesh.h"

namespace powbench::sim {

/// The physical volumes of an imported mesh as parts, in the order of the file, each with the name of its group
/// ("volume TAG" without one). Cells are tetrahedra of 4 and hexahedra of 8 nodes, also mixed; coordinates are
/// multiplied by `metres` (1e-3 for a mesh in mm). Nodes that no cell uses are left out; the nodes of a part stand
/// together, in their order in the file. Throws std::invalid_argument in one sentence: no volume cells, cells of
/// second order, a volume in none or in two of the physical groups, a node of two parts, a part outside 0.1 mm .. 1 m
/// (a slip of unit), and what check_mesh refuses.
SolidMesh import_solid_mesh(const MshMesh&, double metres);

}  // namespace powbench::sim
