#pragma once

#include "sim/fields/field_transient.h"
#include "sim/fields/magnet_field.h"
#include "sim/fields/solenoid_mesh.h"
#include "sim/fields/table_build.h"

/// A solenoid by finite elements around its axis: states, table and closing. The iron carries no eddy currents.

namespace powbench::sim {

struct SolenoidDesign {
  SolenoidShape shape;
  Steel steel = builtin_steel("reference");
  double turns = 1000;
  double residual_gap = 0.1e-3;  ///< m, at the stop of the closed solenoid, 1 um .. 1 mm
  double largest_gap = 10e-3;    ///< m, of the closing: with the residual gap, the reach of the grid
};

/// One state at a time. The grid moves with the gap; parts slide past each other, so the pull is Maxwell's stress weighted
/// with a motion that bends only air (SolenoidGrid::motion). That is the exact derivative of the discrete energy for
/// this motion of the vertices; the energies of the grids of two gaps differ by it to the error of the mesh.
class SolenoidField {
 public:
  /// Of `options`, `largest_gap` is taken from the design. Throws std::invalid_argument with key, value and range.
  SolenoidField(const SolenoidDesign&, const FieldOptions&);

  SolenoidField(const SolenoidField&) = delete;
  SolenoidField& operator=(const SolenoidField&) = delete;

  int unknowns() const { return problem_.size(); }
  const FieldProblem& problem() const { return problem_; }

  /// m, 0 .. largest gap; the residual gap is added.
  void set_gap(double gap);

  /// With the coil's flux linkage, Wb, or current, A, given. `response` lacks the derivatives by the ring, and
  /// `pull_gap`; `stress_pull` is by the one layer of cells around the plunger.
  FieldPoint at_flux(double psi, std::vector<double> start = {});
  FieldPoint at_current(double current, std::vector<double> start = {});

  /// With c^T a + r i = b in Wb and Wb/A: a step of the circuit.
  FieldPoint in_circuit(double b, double r, std::vector<double> start);

  double flux(const FieldPoint&) const;  ///< Wb

  /// da/dpsi of the last state.
  std::vector<double> tangent() const { return newton_.flux_tangent(0); }

 private:
  FieldPoint solve(const Circuit&, std::vector<double> start);

  SolenoidDesign design_;
  FieldOptions options_;
  SolenoidGrid grid_;
  FieldProblem problem_;
  Newton newton_;
  std::vector<double> motion_, layer_;
};

/// W(psi, gap) of a solenoid; `options.largest_gap` is taken from the design, and there is no ring. Throws as build_table.
PotentialTable build_table(const SolenoidDesign&, const TableOptions& options, Team&,
                           TableReport* report = nullptr);

/// A closing with the field in the loop (see field_transient.h). `iron_conductivity` must be 0: a bore slides past iron,
/// so that the vertices do not go with the material. Throws std::invalid_argument otherwise.
TransientResult run_transient(const SolenoidDesign&, const FieldOptions&, const TransientSetup&);

}  // namespace powbench::sim
