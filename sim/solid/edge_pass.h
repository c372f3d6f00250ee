#pragma once

#include "sim/solid/contact_pass.h"

/// One pair: the sharp edges of one part against those of the other. Private to solid_contact.cpp.

namespace powbench::sim {

/// Sharp edges of `one` against those of `two`.
class EdgePass {
 public:
  EdgePass(const ContactPair&, const NearSurface& one, const NearSurface& two);

  /// New candidates among the edges within reach. Returns half the length of the shortest of them, m.
  double search(const NodeView&, bool every);
  void apply(const NodeView&, NodeForces&, ContactSums&, ContactReport&) const;

 private:
  const NearSurface *near_one_, *near_two_;
  const SolidSurface *one_, *two_;
  std::vector<double> stiffness_;  ///< N/m, of each edge of `one`
  std::vector<std::pair<int, int>> near_;
};

}  // namespace powbench::sim
