#define POWBENCH_HALF_LANES
#include "sim/mechanics/rigid_halves.h"

#include "sim/mechanics/rigid_lanes.h"

namespace powbench::sim {

void rigid_rhs_in_halves(const void* lanes, const double* s, double pull, double* ds, double* losses) {
  rigid_rhs(*static_cast<const RigidLanes<double>*>(lanes), s, pull, ds, losses);
}

void rigid_guards_in_halves(const void* lanes, const void* sign, const double* s, const double* ds,
                            double* value, double* rate, double* curve) {
  rigid_signed_depths(*static_cast<const RigidLanes<double>*>(lanes), static_cast<const Lanes<double>*>(sign),
                      s, ds, value, rate, curve);
}

}  // namespace powbench::sim
