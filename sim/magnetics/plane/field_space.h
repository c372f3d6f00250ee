#pragma once

#include <array>
#include <vector>

#include "sim/magnetics/plane/mesh.h"
#include "sim/magnetics/plane/ordering.h"

/// Finite elements for A on straight triangles: linear (order 1) or quadratic (order 2), planar A_z or axisymmetric
/// A_phi.
///
///   planar        B = (dA/dy, -dA/dx),                 volume element depth dx dy
///   axisymmetric  B = (B_r, B_z) = (-dA/dz, A/r + dA/dr), volume element 2 pi r dr dz
///
/// Unknowns are numbered in an order of elimination; a node with A = 0 has the number `size` of the pattern, where
/// every solution vector holds a zero (so vectors have size + 1 entries).

namespace powbench::sim {

struct FieldSpace {
  int order = 2;
  bool axisymmetric = false;
  double depth = 1;  ///< m, planar only; copies of a symmetric model counted
  int nodes = 6;     ///< of an element: corners, then the middles of the edges 01, 12, 20
  int lanes = 8;     ///< nodes, filled up to a whole vector
  Mesh mesh;
  Pattern pattern;
  std::vector<int> unknown;            ///< nodes a triangle
  std::vector<int> position;           ///< of the entries of each triangle's matrix, see element_positions
  std::vector<double> node_x, node_y;  ///< place of each unknown, m

  int size() const { return pattern.size; }
  const int* unknowns(std::size_t triangle) const {
    return unknown.data() + triangle * static_cast<std::size_t>(nodes);
  }
};

FieldSpace make_space(Mesh mesh, int order, bool axisymmetric, double depth);

/// Sets `node_x` and `node_y` by the vertices of the mesh.
void place_unknowns(FieldSpace&);

/// The shape functions at one point of a triangle.
struct ShapePoint {
  double weight = 0;                                  ///< of the quadrature, volume element included
  double r = 0;                                       ///< x, or the radius
  std::array<double, 8> value{}, curl_x{}, curl_y{};  ///< N_i and the two components of B of A = N_i
};

/// Quadrature of one triangle. Degrees: 1 (one point), 2 (three), 4 (six).
std::vector<ShapePoint> shape_points(const FieldSpace&, std::size_t triangle, int degree);

/// The shape functions at barycentric coordinates; weight 0.
ShapePoint shape_at(const FieldSpace&, std::size_t triangle, const std::array<double, 3>& l);

/// Where the entries (i, j) of an element's matrix, i >= j by local number, go in the values of the pattern; entries of
/// a fixed node go behind the last one. Row by row of the local lower triangle.
inline const int* element_positions(const FieldSpace& s, std::size_t triangle) {
  return s.position.data() + triangle * static_cast<std::size_t>(s.nodes * (s.nodes + 1) / 2);
}

/// y = A x for a symmetric matrix given by its lower triangle.
void multiply(const Pattern&, const std::vector<double>& values, const double* x, double* y);

}  // namespace powbench::sim
