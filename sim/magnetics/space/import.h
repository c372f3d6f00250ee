#pragma once

#include <map>

#include "sim/magnetics/plane/msh.h"
#include "sim/magnetics/space/mesh.h"

namespace powbench::sim::space {

/// The volume cells of an imported mesh. `region_of_group` gives the region of each physical volume; coordinates are
/// multiplied by `metres` (1e-3 for a mesh in mm). Throws std::invalid_argument: no volume cells, two kinds of cells, a
/// cell without a listed group.
Mesh import_mesh(const MshMesh&, double metres, const std::map<int, int>& region_of_group);

}  // namespace powbench::sim::space
