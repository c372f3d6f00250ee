#pragma once

#include <map>
#include <vector>

#include "sim/magnetics/plane/mesh.h"
#include "sim/magnetics/plane/msh.h"

namespace powbench::sim {

/// The triangles and quadrangles (cut in two) of a mesh file as a plane mesh: x and y times `metres`, only the
/// corners of each element. `region_of_group`: region of each physical group of surfaces; A = 0 on the lines of the
/// physical groups `zero_groups`. Nodes that no element touches are left out. Throws std::invalid_argument for a
/// line with A = 0 inside the mesh, a surface without a region, one with two, a mesh without triangles, and what
/// check_mesh refuses.
Mesh import_plane_mesh(const MshMesh&, double metres, const std::map<int, int>& region_of_group,
                       const std::vector<int>& zero_groups);

}  // namespace powbench::sim
