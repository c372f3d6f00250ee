#include "host/config/drawing_keys.h"

namespace powbench::host {

FileKind mesh_key(DrawingDraft& d) {
  FileKind kind("drawing", "a magnet on a mesh");
  kind.text("mesh", d.mesh, "mesh of gmsh, MSH 2.2 or 4.1").need = Need::required;
  return kind;
}

void motion_keys(FileKind& kind, DrawingDraft& d) {
  kind.number("drawn_gap_mm", d.drawn_gap, {1e-3, 100},
              "between the faces of armature and fixed iron, as drawn", Need::required);
  kind.number("residual_gap_um", d.residual_gap, {1, 1000}, "between the faces when closed", Need::required);
  kind.number("travel_mm", d.travel, {0.1, 33},
              "of the armature from open to closed; tables go to 1.5 times that", Need::required);
  kind.number("ring_resistance_ohm", d.ring_resistance, {1e-9, 1}, "of the ring, one turn");
  kind.number("largest_flux_Wb", d.largest_flux, {1e-6, 1e4},
              "of the coil, where the table ends; left out: in saturation");
}

FileKind drawing_keys(DrawingDraft& d) {
  FileKind kind = mesh_key(d);
  kind.choice("unit", d.unit, drawn_units, "of the mesh's coordinates");
  kind.choice("kind", d.kind, {"plane", "axisymmetric", "space"},
              "axisymmetric: x is the radius, y the axis; space: tetrahedra");
  kind.number("depth_mm", d.depth, {0.1, 1000}, "plane: depth of the stack");
  kind.number("stack_factor", d.stack_factor, {0.5, 1}, "plane: share of iron in the stack");
  kind.choice("symmetry", d.symmetry, {"whole", "half", "quarter"}, "how much of the device is drawn");
  kind.choice("opening", d.opening, {"+y", "-y", "+x", "-x"}, "where the armature goes when it opens");
  motion_keys(kind, d);
  for (auto& g : d.groups) {
    kind.section(g.section(), "a physical group of the mesh");
    if (g.dimension == 1) {
      kind.choice("role", g.line, {"none", "A=0"}, "A=0: no flux leaves through the line");
      continue;
    }
    kind.choice("role", g.role, drawn_roles, "what the surface is");
    kind.text("steel", g.steel, "of fixed and armature: built-in name or B-H sheet");
    kind.number("turns", g.turns, {-1e6, 1e6}, "of coil and ring; above 0: out of the plane");
  }
  return kind;
}

}  // namespace powbench::host
