#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/magnetics/plane/gap_field.h"
#include "sim/magnetics/plane/pull_form.h"
#include "sim/magnetics/plane/table_build.h"

/// A magnet on a mesh that was drawn elsewhere, in the plane or around an axis. The armature moves along y as a rigid
/// body; air that is named for it stretches. SI.

namespace powbench::sim {

enum class DrawnRole { air, stretch, fixed, armature, coil, ring };

/// One part of the drawing: a region of the mesh.
struct DrawnPart {
  std::string name;
  DrawnRole role = DrawnRole::air;
  int steel = -1;    ///< index in DrawnMagnet::steels, of `fixed` and `armature`
  double turns = 0;  ///< of `coil` and `ring`; above 0: out of the plane
};

struct DrawnMagnet {
  std::string name;
  Mesh mesh;  ///< as drawn; the armature opens towards +y; regions are indices of `parts`
  std::vector<DrawnPart> parts;
  std::vector<Steel> steels;  ///< with their share of the stack
  bool axisymmetric = false;
  double depth = 1;  ///< m, planar: of the stack
  int copies = 1;    ///< 1: all of the device, 2: a half, 4: a quarter, mirrored at the gap's middle, too
  double drawn_gap = 1e-3;       ///< m, between the faces as drawn, see measured_gap
  double residual_gap = 36e-6;   ///< m, between the faces when closed
  double travel = 4e-3;          ///< m, of the armature from open to closed
  double ring_resistance = 0;    ///< ohm; 0: not stated
  double largest_flux = 0;       ///< Wb: where the table ends; 0: by saturated_flux
  std::vector<double> motion{};  ///< by vertex: rise in m for each m of gap; by drawn_motion

  bool has_ring() const;
  double turns()
      const;  ///< of the device: all that go out of the plane, or into it, whichever is more; a quarter has two coils
};

/// How far each vertex rises when the gap grows by 1 m: 1 in the armature and what is joined to it by parts that do
/// not stretch (1/2 in a quarter, whose other armature moves, too), 0 in the rest, and in the air that stretches
///
///   m = d_0 / (d_0 + d_1),   d_0, d_1: distance to what stands still and to what moves.
///
/// |grad m| <= 1 / (d_0 + d_1) is nowhere above 1 / drawn gap, so that no point of the air turns inside out down to a
/// gap of 0. Triangles, in which m is linear, may need a little more: their free vertices are moved until none turns
/// over from the closed magnet to 1.5 times the travel, if that can be. Vertices on outer edges along y slide, those
/// on other outer edges of that air stand still. Throws std::invalid_argument where there is no armature or no air
/// that stretches, and where armature and fixed iron are joined by what does not.
std::vector<double> drawn_motion(const DrawnMagnet&);

/// Middle of a hole of the mesh, m: the box around edges of one triangle only that are neither edges with A = 0 nor lie
/// on the convex hull of the mesh. H stands at right angles to such an edge, as on iron that does not
/// saturate. Nothing: no hole. A hole with A = 0 all around is a screen.
std::optional<std::pair<double, double>> unmeshed_place(const Mesh&);

/// Middle of an outer edge of the mesh without A = 0, m; nothing: there is none. On the lower edge of a quarter, the
/// middle of its gap, there need not be any.
std::optional<std::pair<double, double>> open_edge(const Mesh&, bool quarter);

/// Smallest angle of the triangles that do not stretch, rad, with its part and its centre, m.
struct SharpTriangle {
  double angle = 0;
  int part = 0;
  double x = 0, y = 0;
};
SharpTriangle sharpest_triangle(const DrawnMagnet&);

/// How far the outer edge stays from iron and coil, as a share of their size: above, below and beside them, the least.
/// Mirror lines do not count.
double air_around(const DrawnMagnet&);

/// Smallest distance of the armature from the fixed iron below it, along y, m; in a quarter twice that from the lower
/// edge of the mesh. Infinity: nothing below.
double measured_gap(const DrawnMagnet&);

/// The fewest triangles of air on a line along the motion from fixed iron to the armature, as drawn, where the gap is
/// at most 1.25 times its smallest; in a quarter both halves. 0: no such line.
int triangles_across_gap(const DrawnMagnet&);

/// Gaps (faces, residual gap included) over which no triangle turns over, m: from (>= 0), to (may be infinite).
std::pair<double, double> usable_gaps(const DrawnMagnet&);

/// Least angle of the triangles that stretch at such a gap, rad.
double least_angle(const DrawnMagnet&, double face_gap);

/// A drawn magnet at one gap. The pull is the exact derivative of the discrete energy: Maxwell's stress weighted with
/// `motion`; `stress_pull` is by the one layer of triangles around the armature.
class DrawnGap final : public GapField {
 public:
  explicit DrawnGap(std::shared_ptr<const DrawnMagnet>, int order = 2);
  std::unique_ptr<GapField> copy() const override { return std::make_unique<DrawnGap>(*this); }
  const DrawnMagnet& drawing() const { return *drawing_; }

  /// Throws std::invalid_argument where a triangle turns over, too.
  void set_gap(double gap) override;

 private:
  double pull(const std::vector<double>& a, std::vector<double>& slope) const override {
    return pull_.force(a, slope);
  }
  double stress_pull(const std::vector<double>& a) const override { return rough_.force(a); }

  std::shared_ptr<const DrawnMagnet> drawing_;
  std::vector<double> layer_;  ///< 1 on the armature and what moves with it, 0 elsewhere
  PullForm pull_, rough_;      ///< at this gap: by `motion`, and by `layer_`
};

/// States of a drawn magnet.
class DrawnField {
 public:
  DrawnField(std::shared_ptr<const DrawnMagnet> d, const NewtonOptions& o)
      : DrawnField(DrawnGap(std::move(d)), o) {}
  DrawnField(DrawnGap, const NewtonOptions&);
  /// For another thread, or other steels: shares only the drawing, and spares the order of elimination, which takes as
  /// long as 20 states.
  DrawnField(const DrawnField&);
  DrawnField& operator=(const DrawnField&) = delete;

  int unknowns() const { return gap_.problem().size(); }
  bool has_ring() const { return gap_.has_ring(); }
  const FieldProblem& problem() const { return gap_.problem(); }
  const DrawnMagnet& drawing() const { return gap_.drawing(); }

  /// As DrawnGap's.
  void set_gap(double gap) { gap_.set_gap(gap); }

  /// Air in place of steel.
  void set_air() { gap_.set_steels(gap_.air_steels()); }

  /// With both flux linkages given; without a ring, and with `ring_open`, the ring carries no current. `response` lacks
  /// `pull_gap`.
  FieldPoint at_flux(double psi, double ring, std::vector<double> start = {}, bool ring_open = false);

  /// With both currents given; the second derivatives stay zero.
  FieldPoint at_current(double current, double ring_current, std::vector<double> start = {});

  /// Flux linkages of a solution: coil and ring.
  std::pair<double, double> fluxes(const FieldPoint& p) const { return gap_.fluxes(p); }

  /// da/dpsi and da/dring of the last `at_flux`.
  std::vector<double> tangent(std::size_t winding) const { return newton_.flux_tangent(winding); }

 private:
  NewtonOptions options_;
  DrawnGap gap_;
  Newton newton_;
};

/// The same drawing with every triangle cut into four.
DrawnMagnet refined(const DrawnMagnet&);

/// A solution of the drawing on that: the same function of the place, a start for the finer mesh.
std::vector<double> on_refined(const FieldSpace& coarse, const std::vector<double>& a,
                               const FieldSpace& fine);

/// Flux linkage, Wb, from which on the closed magnet's di/dpsi is above `saturated_stiffness` of that of air. By
/// elements of the first order: it is where a table ends, and need not be sharp. Throws std::invalid_argument where
/// the steel does not saturate, or seems to without flux.
double saturated_flux(const std::shared_ptr<const DrawnMagnet>&);

/// Throws std::invalid_argument for an estimated error of the mesh, relative, above 1: the table would mean nothing.
void refuse_mesh_error(double);

/// W(psi, gap) or W(psi, ring, gap) of a drawn magnet. `largest_field` and the sizes of `options` do not count: the
/// mesh is that of the drawing. `mesh_error` is 1.66 times what one halving of all triangles changes in current and
/// pull of the closed and of the open magnet at half of the largest flux. Unless `options` states them, nodes of psi
/// are added until their error is within `accuracy`, three times at most. Throws as build_table, as table_end, as
/// refuse_mesh_error, and where the mesh turns over up to the largest gap.
PotentialTable build_table(const std::shared_ptr<const DrawnMagnet>&, const TableOptions& options, Team&,
                           TableReport* report = nullptr);
std::uint64_t table_hash(const DrawnMagnet&, const TableOptions&);

/// Hash of the drawing alone.
std::uint64_t drawing_hash(const DrawnMagnet&);

}  // namespace powbench::sim
