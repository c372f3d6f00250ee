#pragma once

#include <numbers>
#include <vector>

#include "sim/magnetics/space/problem.h"

/// Problems with exact solutions, for the tests and the table of errors.

namespace powbench::bench {

/// A linear medium of this relative permeability.
inline sim::space::Medium linear_medium(double relative_permeability) {
  return {4e-7 * std::numbers::pi * relative_permeability, nullptr, 0, 1};
}

/// One mesh of parts with the same kind of cell: nodes closer than `tolerance`, m, become one.
sim::space::Mesh join_meshes(const std::vector<sim::space::Mesh>& parts, double tolerance);

/// An eighth of concentric shells with the radii radius[0] < radius[1] < ..., region k between radius[k-1] and
/// radius[k], in a field that is uniform far away and along z: z = 0 has potential 0. `cells` along each edge of the
/// innermost cube and (at least) across each shell.
sim::space::Mesh ball_mesh(const std::vector<double>& radius, int cells,
                           sim::space::Cell cell = sim::space::Cell::hex27);

/// Nodes of the ball's mesh with their potential: 0 at z = 0, potential(point) at the outermost radius.
std::vector<std::pair<int, double>> ball_potentials(const sim::space::Mesh&, double outer,
                                                    const std::function<double(const sim::Vec3&)>& potential);

/// Flux density inside a steel ball in a uniform field B0: the solution of B + 2 mu0 H(B) = 3 B0, T.
double ball_field(const sim::Steel&, double b0);

/// A spherical shell of relative permeability mu, inner radius a, outer b, in a uniform field: field in the cavity
/// over the applied one, and its dipole coefficient d: potential outside -H0 z (1 - d / r^3).
struct ShellExact {
  double cavity, dipole;
};
ShellExact shell_exact(double mu, double a, double b);

/// A sheet of current round a cylinder (radius, length, turns) in air; an eighth of the whole, natural far boundary
/// at 20 times the larger of radius and half length.
sim::space::Problem solenoid(double radius, double length, double turns, int cells,
                             sim::space::Cell cell = sim::space::Cell::hex27);

/// Its inductance, H, by Lorenz's formula with complete elliptic integrals.
double solenoid_inductance(double radius, double length, double turns);

}  // namespace powbench::bench
