#pragma once

#include <array>
#include <vector>

#include "sim/magnetics/space/cholesky.h"
#include "sim/magnetics/space/mesh.h"

/// Edge elements (Nedelec, first kind) of order 1 or 2 on bricks between graded lines, without the gradients of edge,
/// face and inner functions: those leave curl A as it is. On a brick of edges h, with t = 0 .. 1 along each,
///
///   A_x = P(x) L(y) L(z) and so on,   L: 1 - t, t, 4 t (1 - t),   P: 1/h, d/dx of the third L
///
/// Order 1 takes the first two L and the first P: 12 functions of a brick. Order 2 takes 35.

namespace powbench::bench {

class EdgeSpace {
 public:
  /// A function of a brick: the component it gives to A, and by direction the number of its factor P or L.
  struct Function {
    int component;
    std::array<int, 3> factor;
    /// Of order 1: only these span gradients.
    bool lowest() const;
  };

  struct Brick {
    std::vector<int> unknown;  ///< [function], -1: zero
    std::vector<double> sign;  ///< [function]
    sim::Vec3 low, size;       ///< m
  };

  /// A x n = 0 at x.back(), y.front(), y.back(), z.back(); the face x.front() is tied to itself turned by 180 degrees
  /// about z, for which y must be symmetric about 0. z.front() is free.
  EdgeSpace(int order, const std::vector<double>& x, const std::vector<double>& y,
            const std::vector<double>& z);

  int count() const { return count_; }
  const std::vector<Function>& functions() const { return functions_; }
  const std::vector<Brick>& bricks() const { return bricks_; }  ///< x runs fastest, z slowest

  /// Curl of each function at t in [0, 1]^3 of a brick with these edges, 1/m2.
  void curls(const sim::Vec3& size, const sim::Vec3& t, std::vector<sim::Vec3>& out) const;

  /// Curl A, T, at a place in a brick, from its functions there.
  sim::Vec3 field(const Brick&, const std::vector<sim::Vec3>& curls, const std::vector<double>& a) const;

  /// Pattern of a matrix over the unknowns, and for each brick the places of its entries: [brick][row][column], -1:
  /// none or in the other triangle.
  sim::space::SymmetricMatrix pattern(std::vector<int>& slot) const;

 private:
  int count_ = 0;
  std::vector<Function> functions_;
  std::vector<Brick> bricks_;
};

}  // namespace powbench::bench
