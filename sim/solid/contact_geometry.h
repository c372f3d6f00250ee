#pragma once

#include <array>
#include <vector>

#include "sim/solid/node_forces.h"
#include "sim/solid/solid_surface.h"

/// Nearest points: of a node on a face, of an edge on an edge; and the search for candidates.

namespace powbench::sim {

/// A node seen from a face.
struct Projection {
  double distance = 1e300;          ///< m, to the nearest point of the face
  double gap = 0;                   ///< m, along the normal; negative inside
  double aside = 0;                 ///< m, beyond the face's border, 0 above the face
  Vec3 normal;                      ///< of the triangle that was hit, of unit length
  Vec3 offset;                      ///< m, node less nearest point
  std::array<double, 4> weights{};  ///< of the corners at the nearest point; add up to 1
  int edge = -1;                    ///< border that is nearest where aside > 0
};

/// A four-sided face is a fan of four triangles around its middle, so that nothing depends on a choice of diagonal.
Projection project(const std::array<Vec3, 4>& corners, int count, const Vec3& point);

std::array<Vec3, 4> corners_now(const NodeView&, const Facet&);

/// m: half the size of a face whose normal has the length of twice its area.
inline double face_margin(const Vec3& normal) {
  return 0.5 * std::sqrt(0.5 * norm(normal));
}

/// Nearest points of two lines from..to, as parameters on [0, 1]; false where they are parallel to 0.02 rad or the
/// nearest point is not inside both.
bool nearest_on_edges(const Vec3& from1, const Vec3& to1, const Vec3& from2, const Vec3& to2, double& on1,
                      double& on2);

/// An axis-aligned box.
struct Box {
  Vec3 lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};

  void include(const Vec3& p);
  void grow(double by);
  Vec3 extent() const { return hi - lo; }
};

/// For each box of `probes` the boxes of `targets` that overlap it, ascending; a grid whose cells are sorted by number,
/// so memory is proportional to the boxes.
std::vector<std::vector<int>> overlapping(const std::vector<Box>& probes, const std::vector<Box>& targets);

}  // namespace powbench::sim
