#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim/magnetics/space/mesh.h"
#include "sim/magnetics/steel.h"

/// The other bound: a vector potential on the edges of a graded grid, of order 1 or 2, for a problem that the scalar
/// potential of sim/magnetics/space solves too. It makes
///
///   E(a) - I psi(a),   E = integral of w(|B|),   B = curl A,   psi = integral of B . T
///
/// least (T: source field of the winding for 1 A, curl T = J). div B = 0 holds exactly and curl H = J in the mean, so
/// the flux linkage lies below the exact one and rises with the mesh; that of the scalar potential lies above and
/// falls.

namespace powbench::bench {

/// Bricks between the lines; z.front() is a plane with H x n = 0, x.front() is tied to itself turned by 180 degrees
/// about z (y symmetric about 0), and no flux leaves through the other sides.
struct EdgeProblem {
  std::vector<double> x, y, z;                         ///< m, rising
  std::function<bool(const sim::Vec3& centre)> steel;  ///< of a brick; else air
  sim::Steel curve = sim::Steel::linear(1);
  std::function<sim::Vec3(const sim::Vec3&)> source;  ///< T, A/m for 1 A
  double copies = 1;                                  ///< of this part in the whole
  int order = 1;                                      ///< of the elements, 1 or 2
};

struct EdgeSolution {
  std::vector<double> a;  ///< unknowns, Wb
  double psi = 0;         ///< Wb for one turn
  int iterations = 0;     ///< of the problem's order
  bool converged = false;
};

class EdgeField {
 public:
  explicit EdgeField(EdgeProblem);
  ~EdgeField();

  int unknowns() const;

  /// Newton, each step halved until the energy falls; order 1 from zero, order 2 from the solution of order 1. Gauge: a
  /// mass of 1e-6 of the reluctance at 0.1 m on the unknowns of order 1.
  EdgeSolution solve(double current);

  /// Average of B_z over the bricks between these lines of the grid, at height z, T.
  double average(const EdgeSolution&, double x0, double x1, double y0, double y1, double z) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::bench
