#pragma once

#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/plane/pull_form.h"
#include "sim/magnetics/plane/solenoid_mesh.h"
#include "sim/magnetics/plane/table_build.h"

/// A solenoid by finite elements around its axis: states, table and closing. Eddy currents flow in a closing with the
/// field in the loop, on wish; states and tables leave them out.

namespace powbench::sim {

struct SolenoidDesign {
  SolenoidShape shape;
  Steel steel = builtin_steel("reference");
  double turns = 1000;
  double remanence =
      0;  ///< B_r, T, of SolenoidShape::magnet_length, -2 .. 2; above 0: along the flux of a current above 0
  double magnet_permeability = 1.05;  ///< relative, 1 .. 10: B = mu0 mu_r H + B_r
  double residual_gap = 0.1e-3;       ///< m, at the stop of the closed solenoid, 1 um .. 1 mm
  double largest_gap = 10e-3;         ///< m, of the closing: with the residual gap, the reach of the grid
};

/// A solenoid at one gap. The grid moves with it; parts slide past each other, so the pull is Maxwell's stress weighted
/// with a motion that bends only air (SolenoidGrid::motion). That is the exact derivative of the discrete energy for
/// this motion of the vertices; the energies of the grids of two gaps differ by it to the error of the mesh.
/// `stress_pull` is by the one layer of cells around the plunger.
class SolenoidGap final : public GapField {
 public:
  /// As SolenoidField.
  SolenoidGap(const SolenoidDesign&, const FieldOptions&, double iron_conductivity);
  std::unique_ptr<GapField> copy() const override { return std::make_unique<SolenoidGap>(*this); }
  std::vector<Steel> air_steels() const override;  ///< a magnet stays what it is
  const SolenoidGrid& grid() const { return grid_; }
  double gap() const { return gap_; }  ///< m, without the residual gap

  /// m, 0 .. largest gap.
  void set_gap(double gap) override;

 private:
  double pull(const std::vector<double>& a, std::vector<double>& slope) const override {
    return pull_.force(a, slope);
  }
  double stress_pull(const std::vector<double>& a) const override { return rough_.force(a); }

  SolenoidGap(SolenoidGrid, const SolenoidDesign&, const FieldOptions&, double iron_conductivity);

  double residual_gap_, largest_gap_, gap_ = 0;
  SolenoidGrid grid_;
  std::vector<double> layer_;
  PullForm pull_, rough_;
};

/// One state at a time.
class SolenoidField {
 public:
  /// Of `options`, `largest_gap` is taken from the design. Throws std::invalid_argument with key, value and range.
  /// `iron_conductivity`, S/m: of plunger, stop, plate, flange and case, read by `eddy_step` alone.
  SolenoidField(const SolenoidDesign&, const FieldOptions&, double iron_conductivity = 0);

  SolenoidField(const SolenoidField&) = delete;
  SolenoidField& operator=(const SolenoidField&) = delete;

  int unknowns() const { return problem().size(); }
  const FieldProblem& problem() const { return gap_.problem(); }

  /// m, 0 .. largest gap; the residual gap is added.
  void set_gap(double gap) { gap_.set_gap(gap); }

  /// With the coil's flux linkage, Wb, or current, A, given. `response` lacks the derivatives by the ring, and
  /// `pull_gap`.
  FieldPoint at_flux(double psi, std::vector<double> start = {});
  FieldPoint at_current(double current, std::vector<double> start = {});

  /// With c^T a + r i = b in Wb and Wb/A: a step of the circuit.
  FieldPoint in_circuit(double b, double r, std::vector<double> start);

  /// The middle a_m of a step of the implicit midpoint rule with eddy currents, and with c^T a_m + r i = b:
  ///
  ///   H(a_m) = C i - M (a_1 - a_0) / step,   a_m = (a_0 + a_1) / 2,   M = int sigma N_i N_j
  ///
  /// `start` is a_0, `carried` as `carry` gives it; `response.energy` is without meaning.
  FieldPoint eddy_step(double b, double r, double step, std::vector<double> carried);

  /// What `a`, known at another gap, is on the vertices of the present one, each in the frame of its material: the
  /// plunger's move with it, so that a rigid motion alone makes no eddy current. Interpolated along the axis by
  /// quadratics.
  std::vector<double> carry(const std::vector<double>& a, double old_gap) const;

  /// a^T M a, J/s with `a` the change in a second: the power of eddy currents.
  double eddy_power(const std::vector<double>& rate) const;

  /// J, in the field a; without eddy currents this is what `at_flux` gives.
  double energy(const std::vector<double>& a) const;

  double flux(const FieldPoint& p) const { return gap_.fluxes(p).first; }  ///< Wb

 private:
  FieldPoint solve(const Circuit&, std::vector<double> start);
  void magnetise();
  void find_columns();

  SolenoidDesign design_;
  FieldOptions options_;
  SolenoidGap gap_;
  Newton newton_;
  std::vector<double> magnet_;  ///< load of the permanent magnet; empty: none
  std::vector<double> load_, matrix_;
  std::vector<std::vector<int>>
      columns_;  ///< unknowns in the plunger and on its surface, at equal radius, upwards
};

/// W(psi, gap) of a solenoid; `options.largest_gap` is taken from the design, and there is no ring. Throws as
/// build_table, and for a permanent magnet, with which W is not even in psi.
PotentialTable build_table(const SolenoidDesign&, const TableOptions& options, Team&,
                           TableReport* report = nullptr);

/// Hash of everything that table depends on.
std::uint64_t table_hash(const SolenoidDesign&, const TableOptions&);

/// A closing with the field in the loop (see field_transient.h), with eddy currents where `iron_conductivity` is
/// above 0. `sheet_resistance` must be 0: the parts are solid. Throws std::invalid_argument otherwise.
TransientResult run_transient(const SolenoidDesign&, const FieldOptions&, const TransientSetup&);

}  // namespace powbench::sim
