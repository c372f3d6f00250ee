#pragma once

#include <vector>

#include "sim/field3d/coenergy3.h"

/// Forces from a solution.

namespace powbench::sim {

/// Force on a body in air, N, of the whole (`copies`): minus the stress tensor times the gradient of a weight that is
/// 1 on the nodes of the body and falls to 0 in the air around it,
///
///   F = - int (B H^T - B.H/2) grad w dV    over cells of linear media in which w varies.
///
/// When w is how far each node moves with the body, this is the exact derivative of the discrete co-energy at constant
/// currents (virtual work), and force and flux linkage are reciprocal to round-off. With w falling in one thin layer
/// it is Maxwell's stress on a surface through that layer. The difference of two weights measures the discretisation
/// error. Throws std::invalid_argument where the weight varies inside iron.
Vec3 stress_force(const Coenergy3&, const State3&, const std::vector<double>& weight);

}  // namespace powbench::sim
