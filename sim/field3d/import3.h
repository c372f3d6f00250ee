#pragma once

#include <map>

#include "sim/field3d/mesh3.h"
#include "sim/fields/msh.h"

namespace powbench::sim {

/// The volume cells of an imported mesh. `region_of_group` gives the region of each physical volume; coordinates are
/// multiplied by `metres` (1e-3 for a mesh in mm). Throws std::invalid_argument: no volume cells, two kinds of cells, a
/// cell without a listed group.
Mesh3 import_mesh3(const MshMesh&, double metres, const std::map<int, int>& region_of_group);

}  // namespace powbench::sim
