#pragma once

#include "sim/solid/near_surface.h"

/// Which face of another part a node touches: it takes the nearest of all and only then asks on which side of it it is.
/// Private to solid_contact.cpp.

namespace powbench::sim {

/// A node and the face it touches.
struct Touch {
  int facet = -1;    ///< on the other skin; -1: it touches none
  double away = 0;   ///< m, while it touches none: it must move so far to touch one
  double depth = 0;  ///< m
  Vec3 normal;
  std::array<double, 4> weights{};
};

class NearestFaces {
 public:
  NearestFaces(const NearSurface& from, const NearSurface& onto);

  /// New candidates for the nodes of `from` within half a face's size of it; `every`: all faces within reach, however
  /// far. Returns the smallest of these distances, beyond which nothing touches.
  double search(const NodeView&, bool every);

  /// Nodes with candidates, and each one's place in the nodes of its skin.
  std::size_t count() const { return active_.size(); }
  std::size_t place(std::size_t active) const { return static_cast<std::size_t>(active_[active]); }
  /// Looks for the nearest face of each of the given ones.
  void look(const std::vector<int>& active);
  /// What number `q` of them touches.
  Touch touch(std::size_t q, const NodeView& view) const {
    const Best& best = best_[q];
    if (best.candidate < 0) return nothing(best);
    const SeenFaces& s = seen_[static_cast<std::size_t>(best.seen) / contact_lanes];
    const std::size_t lane = static_cast<std::size_t>(best.seen) % contact_lanes;
    // inside or outside is decided by the nearest face alone: behind a more distant face's plane means nothing
    if (s.gap[lane] >= 0) return nothing(best);
    const int face = candidates_[static_cast<std::size_t>(best.candidate)].face;
    const Touch touch{onto_->faces()[static_cast<std::size_t>(face)],
                      0,
                      -s.gap[lane],
                      {s.normal[0][lane], s.normal[1][lane], s.normal[2][lane]},
                      {s.weights[0][lane], s.weights[1][lane], s.weights[2][lane], s.weights[3][lane]}};
    return s.aside[lane] == 0 ? touch : beside(q, touch, s.aside[lane], view);
  }

 private:
  struct Candidate {
    int face = 0;         ///< within reach
    bool square = false;  ///< squarely opposite, so that the node may stand on its border
    /// m: a node over the middle of the face and not further from it has no nearer face, one half way to the border if
    /// it is not further than half of it; 0: the neighbours are not level with the face.
    double sure = 0;
  };

  struct Best {
    double distance = 0, away = 0;
    int candidate = -1;
    int seen = 0;  ///< where the numbers of that candidate are
  };

  /// A node that has not looked at all its candidates yet.
  struct Asking {
    int number = 0;  ///< among those that look
    int point = 0;
    int candidate = 0, next = 0, end = 0;  ///< the one looked at now, the next in order, one past the last
  };

  bool sure(const Candidate&, const SeenFaces&, std::size_t lane) const;
  double tangent_around(const Facet&, const std::vector<Vec3>& normals) const;
  bool behind_all(const NodeView&, const Facet&, const Projection&) const;
  void see(SeenFaces* out);
  Touch nothing(const Best& best) const {
    constexpr double rounding = 1e-9;
    return {-1, best.away - rounding * depth_limit_, 0, {}, {}};
  }
  Touch beside(std::size_t q, Touch, double aside, const NodeView&) const;

  const NearSurface *from_, *onto_;
  const ContactKernel* kernel_;
  double depth_limit_ = 0;
  double ledge_ = 0;  ///< m, so far beyond the border of the largest face a node still stands on it, and more
  std::vector<int> active_;  ///< by place in the nodes of the skin
  std::vector<int> point_;   ///< of each active one: 4 times its number within reach
  std::vector<int> begin_;   ///< of each active one: its first candidate; and the end of the last
  std::vector<int> first_;  ///< of each active one: the candidate it looks at first, the nearest of last time
  std::vector<Candidate> candidates_;
  // of one look
  std::vector<Best> best_;
  std::vector<Asking> asking_;
  std::vector<int> looking_, seeing_, seen_face_;
  std::vector<SeenFaces> seen_;  ///< of all rounds
};

}  // namespace powbench::sim
