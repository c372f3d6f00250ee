#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/space/ladder.h"
#include "sim/magnetics/space/winding.h"

/// A magnet on a mesh of tetrahedra that was drawn elsewhere. The armature moves along z as a rigid body; air, and the
/// iron of a closed leg, stretch where they are named for it. SI.

namespace powbench::sim {

/// One part of the drawing: a region of the mesh.
struct SpacePart {
  std::string name;
  DrawnRole role = DrawnRole::air;
  int steel = -1;  ///< index in SpaceMagnet::steels, of `fixed`, `armature`, and of `stretch` in a closed leg
  space::BoxCoil coil{};  ///< of `coil` and `ring`: its T; the part is its section
  int images = 1;         ///< of the winding: how many like it the device has, mirror images in series
};

struct SpaceMagnet {
  std::string name;
  /// Cell::tet10 as straight_tetrahedra makes it; opens towards +z; regions are indices of `parts`.
  space::Mesh mesh;
  std::vector<SpacePart> parts;
  std::vector<Steel> steels;
  double stack_factor = 1;       ///< share of iron in stacks of sheets
  int sheets = -1;               ///< normal of the sheets: 0 x, 1 y, 2 z; -1: solid iron
  int copies = 1;                ///< 2, 4: mirrored at one or two planes along z, through which no flux goes
  double drawn_gap = 1e-3;       ///< m, between the faces as drawn, see measured_gap
  double residual_gap = 36e-6;   ///< m, between the faces when closed
  double travel = 4e-3;          ///< m, of the armature from open to closed
  double ring_resistance = 0;    ///< ohm; 0: not stated
  double largest_flux = 0;       ///< Wb: where the table ends; 0: by saturation
  std::vector<double> motion{};  ///< by node: rise in m for each m of gap; by space_motion

  bool has_ring() const;
  double turns() const;  ///< of all coils in series
};

/// The motion of a drawing in space, as drawn_motion: 1 in the armature and what is joined to it by parts that do not
/// stretch, 0 in the rest, between them d_0 / (d_0 + d_1) by the distances to what stands still and to what moves.
/// Faces on the outside that lie along z slide, others stand still. Free corners of tetrahedra that would turn inside
/// out from the closed magnet to 1.5 times the travel are moved until none does, if that can be. Throws
/// std::invalid_argument where there is no armature, nothing that stretches, or nothing between armature and fixed
/// iron that does.
std::vector<double> space_motion(const SpaceMagnet&);

/// Smallest distance of the armature from the fixed iron below it, along z, m; iron that stretches does not count as a
/// gap. Infinity: nothing below.
double measured_gap(const SpaceMagnet&);

/// Gaps (faces, residual gap included) over which no tetrahedron turns inside out, m: from (>= 0), to (may be
/// infinite).
std::pair<double, double> usable_gaps(const SpaceMagnet&);

/// A place where tetrahedra are missing.
struct SpaceHole {
  std::string where;  ///< "in the opening of 'coil' at", "beside 'core' at", "around"
  Vec3 at;            ///< m
};

/// A hole of the mesh. Faces of one tetrahedron only lie on the convex hull, and so do planes of symmetry. Faces of air
/// may also make up an outside that is not convex, but neither within the opening of a winding nor as a closed surface
/// of their own. `coil` of the windings has to be set.
std::optional<SpaceHole> unmeshed_place(const SpaceMagnet&);

/// What hinders the T of a winding: "" nothing; else a sentence. Its part has to be the section of the coil, what lies
/// in the opening, between the ends of the section, must be volumes of the mesh that neither move nor stretch.
std::string winding_error(const SpaceMagnet&, std::size_t part);

/// The field of a drawing at any gap; `bare`: with air in place of steel.
space::MagnetField space_field(const SpaceMagnet&, bool bare, const space::NewtonOptions& = {});

/// Estimate of what the mesh errs by, relative: a third of the largest change of current and pull from elements of
/// order one to those of order two on the same tetrahedra, in the closed and in the open magnet at these flux linkages,
/// Wb. Beside edges of iron the error falls with h^(4/3) for either order, and order two has the nodes of order one on
/// tetrahedra of half the size: at most 0.4 of its error. On two meshes of a relay a third is 1.1 and 2.0 times the
/// largest deviation from a finer grid; no bound.
double mesh_error(const SpaceMagnet&, space::MagnetField& field, const std::vector<double>& psi);

/// W(psi, gap) or W(psi, ring, gap) of a drawing in space. `largest_field` and the sizes of `options` do not count: the
/// mesh is that of the drawing. PotentialTable::mesh_error is that at a half and an eighth of the largest flux. Throws
/// std::invalid_argument for options out of range, a ring that links no flux, steel that does not saturate, a mesh that
/// errs by more than 100 %; std::runtime_error where Newton does not converge.
PotentialTable build_table(const SpaceMagnet&, const TableOptions& options, TableReport* report = nullptr,
                           const space::Progress& progress = {});
std::uint64_t table_hash(const SpaceMagnet&, const TableOptions&);

/// Hash of the drawing alone.
std::uint64_t drawing_hash(const SpaceMagnet&);

}  // namespace powbench::sim
