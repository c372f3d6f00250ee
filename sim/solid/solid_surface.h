#pragma once

#include <array>
#include <functional>
#include <vector>

#include "sim/solid/solid_material.h"
#include "sim/solid/solid_mesh.h"

/// The skin of a part: faces that belong to one cell, and the sharp edges between them.

namespace powbench::sim {

/// A face, corners anticlockwise seen from outside; the fourth is -1 for a triangle.
struct Facet {
  std::array<int, 4> nodes{-1, -1, -1, -1};
  int cell = 0;
  double stiffness = 0;  ///< Pa/m: wave modulus over the height of the cell, of the penalty

  int corners() const { return nodes[3] >= 0 ? 4 : 3; }
};

/// A convex edge where two faces meet at more than 20 degrees.
struct SharpEdge {
  int from = 0, to = 0;
  int left = 0, right = 0;  ///< facets
};

struct SolidSurface {
  int part = 0;
  std::vector<Facet> facets;
  std::vector<SharpEdge> edges;
  std::vector<int> nodes;         ///< ascending
  std::vector<double> areas;      ///< m2, by place in `nodes`: share of the faces around it, seen along the
                                  ///< face along which it is largest
  std::vector<double> stiffness;  ///< Pa/m, mean over its faces, by place in `nodes`
  std::vector<std::vector<int>> facets_at;  ///< around a node, by place in `nodes`

  int place_of(int node) const;  ///< in `nodes`, which must hold it

  /// m2: a node's share of the faces that look against a direction, projected on it, with nodes at the given places.
  double area_along(std::size_t place, const Vec3& against, const std::function<Vec3(int)>& at) const;
};

SolidSurface surface_of(const SolidMesh&, int part, const SolidMaterial&);

/// Outward normal of a facet at the given places of its corners, of the length of twice its area.
Vec3 facet_normal(const std::array<Vec3, 4>& corners, int count);

}  // namespace powbench::sim
