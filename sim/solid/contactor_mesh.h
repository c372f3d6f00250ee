#pragma once

#include "sim/solid/solid_material.h"
#include "sim/solid/solid_mesh.h"
#include "sim/specimen/specimen.h"

/// The contactor's moving parts as hexahedra, from the specimen's masses and lengths. z is the closing direction.
///
///      +==========================================+   base: steel plate, as thick as its mass says,
///      |  post |                          | post  |         with two posts (fixed contacts) for each pole
///      +-------+      +------------+      +-------+
///                     |  hook bar  |  ^ travel        mover: armature block, columns between the poles and a bar
///      ---- gap ----  +------------+                         across, against which springs press the bridges
///      +==========================================+   bridge: copper bar, as thick as its mass says
///                     |  columns   |
///      +------------------------------------------+
///      |              armature                    |
///      +------------------------------------------+

namespace powbench::sim {

struct ContactorMesh {
  SolidMesh mesh;
  std::vector<SolidMaterial> materials;  ///< of each part
  int mover = 0, base = 1;
  std::vector<int> bridges;  ///< parts
  double bridge_thickness = 0;
};

/// `cell`: largest edge of a cell, m, in [0.1 mm, 10 mm]. Throws std::invalid_argument for a specimen whose parts would
/// not fit (a mass too small for the lengths), naming key, value and range.
ContactorMesh contactor_mesh(const Specimen&, double cell);

}  // namespace powbench::sim
