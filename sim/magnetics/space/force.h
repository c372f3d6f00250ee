#pragma once

#include <vector>

#include "sim/magnetics/space/coenergy.h"

/// Forces from a solution.

namespace powbench::sim::space {

/// Force on a body, N, of the whole (`copies`): minus the tensor of virtual work times the gradient of a weight that is
/// 1 on the nodes of the body and falls to 0 in the air around it, or in iron that stretches,
///
///   F = - int (H (B . grad w) - w'(H) grad w) dV    over cells in which w varies; in linear media w' = B . H / 2.
///
/// When w is how far each node moves with the body, this is the exact derivative of the discrete co-energy at constant
/// currents (virtual work), and force and flux linkage are reciprocal to round-off; sources T must be 0 where w varies.
/// With w falling in one thin layer it is Maxwell's stress on a surface through that layer. The difference of two
/// weights measures the discretisation error.
Vec3 stress_force(const Coenergy&, const State&, const std::vector<double>& weight);

/// Derivative of that force at a state along a direction, N: the direction is of potentials and currents, given
/// potentials stay.
Vec3 stress_force_slope(const Coenergy&, const State&, const State& direction,
                        const std::vector<double>& weight);

}  // namespace powbench::sim::space
