#pragma once

#include <string>
#include <vector>

#include "host/config/file_kind.h"
#include "sim/magnetics/plane/drawn_magnet.h"

/// The keys of a drawing file and what they fill. Private to drawing_file.cpp and space_file.cpp.

namespace powbench::host {

enum class DrawnUnit { mm, m, in };
enum class DrawnKind { plane, axisymmetric, space };
enum class DrawnSymmetry { whole, half, quarter };
enum class DrawnOpening { up, down, right, left };
enum class DrawnLine { none, zero };

inline constexpr double drawn_metres[] = {1e-3, 1.0, 25.4e-3};
inline const std::vector<std::string> drawn_units{"mm", "m", "in"};
inline const std::vector<std::string> drawn_roles{"air", "stretch", "fixed", "armature", "coil", "ring"};

/// One physical group with what the file says about it.
struct DrawnGroup {
  std::string name;
  int dimension = 2, tag = 0;
  bool filled = false;
  sim::DrawnRole role = sim::DrawnRole::air;
  DrawnLine line = DrawnLine::none;
  std::string steel;
  double turns = 0;
  std::string section() const { return "group." + name; }
};

struct DrawingDraft {
  std::string mesh;
  DrawnUnit unit = DrawnUnit::mm;
  DrawnKind kind = DrawnKind::plane;
  DrawnSymmetry symmetry = DrawnSymmetry::whole;
  DrawnOpening opening = DrawnOpening::up;
  double depth = 1, stack_factor = 1, drawn_gap = 1e-3, residual_gap = 36e-6, travel = 4e-3,
         ring_resistance = 0, largest_flux = 0;
  std::vector<DrawnGroup> groups;
};

/// The key that has to be read first: the groups of the mesh are sections.
FileKind mesh_key(DrawingDraft&);

/// Gaps, travel, ring and end of the table: the same in the plane and in space.
void motion_keys(FileKind&, DrawingDraft&);

/// All keys, with a section for each of the groups.
FileKind drawing_keys(DrawingDraft&);

}  // namespace powbench::host
