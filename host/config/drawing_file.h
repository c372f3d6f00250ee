#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "host/config/bad_input.h"
#include "sim/magnetics/plane/drawn_magnet.h"

/// The drawing file, `my.magnet.toml`: a magnet on a mesh of gmsh (MSH 2.2 or 4.1). Owner: its designer.
///
///   mesh = "core.msh"        as seen from this file
///   unit = "mm"              of the mesh: mm, m, in
///   kind = "plane"           or "axisymmetric": x is the radius
///   symmetry = "half" whole; half: the other one is a mirror image beside; quarter: mirrored at the gap's middle,
///   too opening = "+y" where the armature goes when it opens: +y, -y, in the plane +x and -x, too drawn_gap_mm,
///   residual_gap_um between the faces, as drawn and when closed travel_mm of the armature; tables go to 1.5 times
///   that [group.NAME] for each physical surface: role = fixed, armature, coil, ring, air, stretch; steel or turns
///   [group.NAME] for a physical line: role = "A=0", no flux leaves through it
///
/// Sheets and mesh are looked for beside the file.

namespace powbench::host {

/// True if the name of a file says that it is a drawing: it ends in .magnet.toml.
bool names_drawing(const std::filesystem::path&);

/// Throws BadInput with all mistakes: single keys; groups without a role and roles without a group; iron without
/// steel; coils and rings without turns, without area or out of balance; no line A = 0; a size or gap that shows a
/// wrong unit; an armature that nothing lets move; a mesh that turns inside out on the way to the closed magnet.
std::shared_ptr<const sim::DrawnMagnet> read_drawing(const std::filesystem::path&);

}  // namespace powbench::host
