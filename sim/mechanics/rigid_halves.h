#pragma once

/// The kernels of the rigid contactor for processors with AVX2 and no wider registers; built on x86-64 only. `lanes` is
/// a RigidLanes<double>, `sign` a Lanes<double>[rigid_groups]: they have one layout for eight lanes and for two halves.

namespace powbench::sim {

/// As rigid_rhs.
void rigid_rhs_in_halves(const void* lanes, const double* s, double pull, double* ds, double* losses);
/// As rigid_signed_depths.
void rigid_guards_in_halves(const void* lanes, const void* sign, const double* s, const double* ds,
                            double* value, double* rate, double* curve);

}  // namespace powbench::sim
