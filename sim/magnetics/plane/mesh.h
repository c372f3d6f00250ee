#pragma once

#include <array>
#include <vector>

/// A mesh of straight triangles in the plane (x, y), or in the half plane (r, z) of an axisymmetric field. m.

namespace powbench::sim {

struct Mesh {
  std::vector<double> x, y;                  ///< vertices
  std::vector<std::array<int, 3>> triangle;  ///< vertices, counter-clockwise
  std::vector<int> region;                   ///< one number for each triangle; its meaning is the owner's
  std::vector<char> zero;                    ///< vertices on a line where A = 0
};

/// Twice the signed area of a triangle, m2.
double twice_area(const Mesh&, const std::array<int, 3>& triangle);

/// Area of all triangles of one region, m2.
double region_area(const Mesh&, int region);

/// Throws std::invalid_argument on sizes that do not fit, an index out of range or a triangle without area; turns
/// clockwise triangles round.
void check_mesh(Mesh&);

}  // namespace powbench::sim
