#pragma once

#include <functional>
#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/potential.h"

/// A closing with the field in the loop: no table, eddy currents in solid iron on wish. The implicit midpoint rule,
///
///   c_k^T (a_1 - a_0) = dt (u_k - R_k i_k),   H(a_m) = C i - M (a_1 - a_0) / dt,   a_m = (a_0 + a_1) / 2,
///
/// is one bordered Newton solution a step, and exact for the energy of a linear field. The gap follows the pull at
/// its own midpoint, so what the field gives the core takes. Slow: a check of tables, and the reference for solid
/// cores.

namespace powbench::sim {

/// Eddy currents in the sheets of a stack are a resistance R_e beside the coil's flux: i = dW/dpsi + (dpsi/dt) / R_e.

struct TransientSetup {
  std::function<double(double)> voltage;  ///< u(t), V
  double resistance = 1;                  ///< of the coil, ohm
  double ring_resistance = 1e-3;          ///< ohm
  double iron_conductivity = 0;           ///< S/m; 0: laminated
  double sheet_resistance = 0;  ///< ohm, R_e of `lamination_resistance`; 0: no eddy currents in sheets
  double mass = 0.1;            ///< kg; the moving part
  std::function<double(double)> counter_force;  ///< N at a gap, against the closing; empty: none
  double start_gap = 4e-3;  ///< m; the gap stays within [0, start_gap], impacts are plastic
  bool moves = true;
  double step = 50e-6;      ///< s
  double duration = 20e-3;  ///< s
};

/// State after each step.
struct TransientSample {
  double time = 0, psi = 0, current = 0, ring_current = 0, gap = 0, velocity = 0, pull = 0;
};

/// J, from the start; impacts and the counter force take part of `mechanical`.
struct TransientEnergy {
  double supplied = 0;   ///< u i dt
  double coil_loss = 0;  ///< R i^2
  double ring_loss = 0;
  double eddy_loss = 0;     ///< in solid iron or in its sheets
  double mechanical = 0;    ///< pull times way
  double stored = 0;        ///< in the field at the end
  double residual() const;  ///< what is missing, over what was supplied
};

struct TransientResult {
  std::vector<TransientSample> samples;
  TransientEnergy energy;
  double closed_at = -1;  ///< s, first arrival at gap 0; -1: never
  int iterations = 0;     ///< factorisations
};

/// Throws std::invalid_argument for a bad setup, std::runtime_error where Newton does not converge.
TransientResult run_transient(const MagnetDesign&, const FieldOptions&, const TransientSetup&);

/// The same rule, the same setup on any rung. `iron_conductivity` is left out.
TransientResult run_transient(const MagneticPotential&, const TransientSetup&);

}  // namespace powbench::sim
