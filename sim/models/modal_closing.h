#pragma once

#include <memory>

#include "sim/magnetics/potential.h"
#include "sim/models/closing.h"
#include "sim/solid/modal_parts.h"

/// The rung `modal`: one closing of the rigid contactor whose base and bridges bend. Bodies along the closing
/// direction:
///
///   M x''       = pull - F_r0 - k_r x - friction - sum_j (f_j - S_j1 - S_j2) - N + P
///   M_s z''     = -pull + N + sum pads - k_b z - c_b z'
///   m y_j''     = f_j - S_j1 - S_j2 - F_j1 - F_j2
///   J theta_j'' = r (F_j1 - F_j2) + l (S_j1 - S_j2)
///   q''         = -2 zeta omega q' - omega^2 q + sum over forces phi f       elastic, of base and each bridge
///
/// with displacements of a place = rigid + sum phi q, springs f_j, pads F, seats S, pole face N, stop P. Contacts and
/// numbers are those of `rigid_parts`: F = max(0, k d + c d') for d > 0. Without elastic coordinates these are the
/// equations of the rung `rigid` without tilt of the core.
///
/// Motion by the central difference; psi and the ring's flux advance in the same step with the current extrapolated
/// to its middle. Second order between impacts, first order at them.

namespace powbench::sim {

struct ModalClosingOptions {
  double step = 0.25;       ///< of the critical step, 0.01 .. 0.9
  double damping = 0.01;    ///< zeta of the elastic coordinates, 0 .. 1
  double duration = 0.08;   ///< s
  double sample = 0;        ///< s between samples, 0: none
  bool pressed_gap = true;  ///< the potential is also defined for gap < 0
};

/// Closes from static equilibrium. The ring's resistance is the specimen's. Trajectory::energy_residual: largest
/// seen, of the energy supplied. Throws std::invalid_argument for bad options, conditions, or a specimen whose static
/// core floats.
Trajectory modal_closing(const Specimen&, const Conditions&, const MagneticPotential&, const ModalParts&,
                         const ModalClosingOptions&);

}  // namespace powbench::sim
