#pragma once

#include "sim/solid/contact_geometry.h"
#include "sim/solid/contact_kernel.h"

/// The skin of a part as contact looks at it: which of its nodes, faces and edges are within reach of another part,
/// where these nodes are, and how far all have moved. Nothing here is guessed from speeds: displacements are measured,
/// so the bounds hold however a part is moved. Private to solid_contact.cpp.

namespace powbench::sim {

/// m: no node of one box has moved further against any node of the other.
double largest_between(const MovedBox&, const MovedBox&);

class NearSurface {
 public:
  explicit NearSurface(const SolidSurface&);

  const SolidSurface& skin() const { return *skin_; }
  /// Box of all nodes now.
  Box box(const NodeView&) const;
  /// m: half the size of its largest face, or of its longest sharp edge.
  double largest_margin(const NodeView&, bool edges) const;

  /// From here displacements are counted, and nothing is within reach.
  void forget(const NodeView&);
  /// Takes in what the box touches: nodes in it, faces and sharp edges whose own boxes overlap it.
  void reach_into(const Box&, const NodeView&);
  /// Numbers what was taken in; `places` are those of now.
  void settle(const NodeView&);

  /// Once a step: places of the nodes within reach.
  void follow(const NodeView&);
  /// Of the nodes within reach, from the latest step to this one.
  const MovedBox& step() const { return step_; }
  /// Of all nodes, since forget().
  MovedBox since_reach(const NodeView&) const;
  /// From here since_search() counts.
  void note_search();
  /// Of the nodes within reach, since note_search().
  MovedBox since_search() const;

  /// By number within reach, ascending as on the skin.
  const std::vector<int>& nodes() const { return near_nodes_; }  ///< places in skin().nodes
  const std::vector<int>& faces() const { return near_faces_; }
  const std::vector<int>& edges() const { return near_edges_; }
  const std::vector<int>& corners() const { return corners_; }  ///< 4 a face: 4 times the number of the node
  bool four_sided() const { return four_sided_; }               ///< every face within reach
  const double* places() const { return places_.data(); }       ///< m, 4 numbers a node
  Vec3 place(std::size_t near) const {
    return {places_[4 * near], places_[4 * near + 1], places_[4 * near + 2]};
  }
  std::array<Vec3, 4> corners_now(std::size_t near_face) const;

 private:
  const SolidSurface* skin_;
  const ContactKernel* kernel_;
  std::vector<char> node_taken_, face_taken_, edge_taken_;
  std::vector<int> near_nodes_, near_faces_, near_edges_, mesh_nodes_, corners_;
  std::vector<double> before_, reference_, places_, at_search_;
  MovedBox step_;
  bool four_sided_ = true;
};

}  // namespace powbench::sim
