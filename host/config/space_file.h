#pragma once

#include <filesystem>
#include <memory>

#include "host/config/bad_input.h"
#include "sim/magnetics/space/space_magnet.h"

/// The drawing file of a magnet in space, `my.magnet.toml` with kind = "space": a mesh of gmsh (MSH 2.2 or 4.1) of
/// tetrahedra. Owner: its designer. The keys of the plane (drawing_file.h) but depth and symmetry, and
///
///   opening = "+z"            +x, -x, +y, -y, +z, -z
///   mirror = "y"              none, x, y, z, xy, xz, yz: the device is mirrored at the planes x = 0, ... of the mesh,
///                             through which no flux goes, as through all of its outside
///   sheets = "none"           or the normal of the sheets: x, y, z, with stack_factor
///   [group.NAME]              for each physical volume: role, steel, turns as in the plane; of coil and ring
///   axis = "z"                of the winding; its section is the group, a prism that fills the box around it
///   width_mm, corner_mm       of the winding, and the radius of the corners of its opening
///
/// role = "stretch" with a steel is iron that stretches with the gap: a closed leg.

namespace powbench::host {

/// True if a drawing file says kind = "space". Throws BadInput where it cannot be read.
bool is_space_drawing(const std::filesystem::path&);

/// Throws BadInput with all mistakes, as read_drawing; also windings that do not fill their group, whose opening is no
/// volume of the mesh, or moves, and planes of symmetry that the mesh does not end at.
std::shared_ptr<const sim::SpaceMagnet> read_space_drawing(const std::filesystem::path&);

}  // namespace powbench::host
