#pragma once

#include <array>
#include <vector>

#include "sim/vec.h"

/// Triangles in space, to ask for the nearest one.

namespace powbench::sim {

using Face3 = std::array<Vec3, 3>;

/// Distance of a point from a triangle.
double distance(const Face3&, const Vec3&);

/// A tree of boxes around triangles.
class FaceTree {
 public:
  explicit FaceTree(std::vector<Face3>);

  /// Distance of a point from the nearest triangle; infinity without any.
  double nearest(const Vec3&) const;

 private:
  struct Box {
    Vec3 low, high;
    int first, count;  ///< triangles, where it is a leaf
    int right;         ///< the left child is the next box; -1: a leaf
  };
  int build(int first, int last);
  void search(int box, const Vec3&, double& least) const;

  std::vector<Face3> faces_;
  std::vector<Box> boxes_;
};

}  // namespace powbench::sim
