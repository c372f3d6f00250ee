#pragma once

#include <memory>
#include <vector>

#include "sim/magnetics/plane/core_mesh.h"
#include "sim/magnetics/plane/gap_field.h"

/// The field of the rungs `table` and `solved`: a core in its air, by finite elements in the plane of its laminations.
/// The depth is the stack; the field at the ends of the stack is not in it.

namespace powbench::sim {

/// What the field rungs need of a magnet. SI.
struct MagnetDesign {
  MagnetShape shape;
  Steel steel = builtin_steel("lamination");
  double turns = 2000;
  double residual_gap = 36e-6;  ///< m, between all pole faces of the closed magnet; > 0
  double end_leakage = 0;       ///< H: flux of the winding's heads, in series with the field
  double ring_leakage = 0;      ///< H: the same of the ring's heads, one turn
};

/// Mesh and elements. `accuracy` is the error of psi and pull that the sizes are meant for.
struct FieldOptions {
  CoreMeshSizes sizes;
  int order = 2;
  double largest_gap = 6e-3;  ///< m: sets the layers of the strip; larger gaps are allowed
  NewtonOptions newton;
};

/// Sizes for a wanted relative error of psi and pull, 0.0002 .. 0.05; throws std::invalid_argument otherwise.
CoreMeshSizes sizes_for(double accuracy);

/// The finite elements of a design. Winding 0 is the coil, winding 1 the ring where there is one; `iron_conductivity`
/// in S/m lets eddy currents flow in solid cores (0: laminated).
FieldProblem magnet_problem(const MagnetDesign&, const FieldOptions&, double iron_conductivity = 0);

/// A core at one gap: the strip of air between the poles stretches. The pull is by virtual work.
class CoreGap final : public GapField {
 public:
  CoreGap(const MagnetDesign&, const FieldOptions&);
  std::unique_ptr<GapField> copy() const override { return std::make_unique<CoreGap>(*this); }
  void set_gap(double gap) override;

 private:
  double pull(const std::vector<double>& a, std::vector<double>& slope) const override;
  double stress_pull(const std::vector<double>& a) const override;

  double residual_gap_;
  std::vector<double> layer_;  ///< weight of the stress force: rises in the middle layer of the strip
};

class MagnetField {
 public:
  MagnetField(const MagnetDesign&, const FieldOptions&);
  MagnetField(const MagnetField&);  ///< for another thread; shares nothing
  MagnetField& operator=(const MagnetField&) = delete;

  int unknowns() const { return problem().size(); }
  bool has_ring() const { return gap_.has_ring(); }
  const FieldProblem& problem() const { return gap_.problem(); }

  /// m, >= 0; the residual gap is added.
  void set_gap(double gap) { gap_.set_gap(gap); }

  /// With both flux linkages given; without a ring, and with `ring_open`, the ring carries no current and `ring` is not
  /// read. `start`: a solution near by, or empty.
  FieldPoint at_flux(double psi, double ring, std::vector<double> start = {}, bool ring_open = false);

  /// With both currents given. The second derivatives of the response stay zero.
  FieldPoint at_current(double current, double ring_current, std::vector<double> start = {});

  /// Flux linkages of a solution: coil (with end leakage times `current`) and ring.
  std::pair<double, double> fluxes(const FieldPoint& p) const { return gap_.fluxes(p); }

 private:
  CoreGap gap_;
  NewtonOptions options_;
  Newton newton_;
};

}  // namespace powbench::sim
