#include "sim/solid/edge_pass.h"

#include <algorithm>

namespace powbench::sim {

EdgePass::EdgePass(const ContactPair& pair, const NearSurface& near_one, const NearSurface& near_two)
    : near_one_(&near_one), near_two_(&near_two), one_(&near_one.skin()), two_(&near_two.skin()) {
  const SolidSurface &one = *one_, &two = *two_;
  double other = 0;
  for (const Facet& f : two.facets) other += f.stiffness / static_cast<double>(two.facets.size());
  for (const SharpEdge& e : one.edges) {
    const auto a = static_cast<std::size_t>(one.place_of(e.from)),
               b = static_cast<std::size_t>(one.place_of(e.to));
    const double area = 0.5 * (one.areas[a] + one.areas[b]),
                 stiff = 0.5 * (one.stiffness[a] + one.stiffness[b]);
    stiffness_.push_back(pair.factor * series(stiff, other) * area);
  }
}

double EdgePass::search(const NodeView& view, bool every) {
  double shortest = 1e300;
  const auto boxes = [&](const NearSurface& near, double share) {
    std::vector<Box> all;
    for (const int k : near.edges()) {
      const SharpEdge& e = near.skin().edges[static_cast<std::size_t>(k)];
      const double half = 0.5 * norm(view.place(e.to) - view.place(e.from));
      shortest = std::min(shortest, half);
      Box box;
      box.include(view.place(e.from));
      box.include(view.place(e.to));
      box.grow(every ? 1e300 : share * half);
      all.push_back(box);
    }
    return all;
  };
  const auto found = overlapping(boxes(*near_one_, 0), boxes(*near_two_, 1));
  near_.clear();
  for (std::size_t k = 0; k < found.size(); ++k)
    for (const int other : found[k])
      near_.emplace_back(near_one_->edges()[k], near_two_->edges()[static_cast<std::size_t>(other)]);
  return shortest;
}

void EdgePass::apply(const NodeView& view, NodeForces& forces, ContactSums& sums,
                     ContactReport& report) const {
  constexpr double inward = -0.02;  // so far from lying in a face: flush faces are the nodes' business
  for (const auto& [k1, k2] : near_) {
    const SharpEdge& e1 = one_->edges[static_cast<std::size_t>(k1)];
    const SharpEdge& e2 = two_->edges[static_cast<std::size_t>(k2)];
    const Vec3 a1 = view.place(e1.from), b1 = view.place(e1.to), a2 = view.place(e2.from),
               b2 = view.place(e2.to);
    double s = 0, t = 0;
    if (!nearest_on_edges(a1, b1, a2, b2, s, t)) continue;
    const Vec3 d = a2 + t * (b2 - a2) - a1 - s * (b1 - a1);
    const double depth = norm(d);
    if (depth <= 0 || depth > 0.5 * std::min(norm(b1 - a1), norm(b2 - a2))) continue;
    const auto inside = [&](const SolidSurface& surface, int facet, const Vec3& direction) {
      const Facet& f = surface.facets[static_cast<std::size_t>(facet)];
      return dot(direction, unit(facet_normal(corners_now(view, f), f.corners()))) < inward * depth;
    };
    if (!inside(*one_, e1.left, d) || !inside(*one_, e1.right, d) || !inside(*two_, e2.left, -d) ||
        !inside(*two_, e2.right, -d))
      continue;
    const double stiff = stiffness_[static_cast<std::size_t>(k1)];
    const Vec3 on_one = stiff * d;
    forces.add(e1.from, (1 - s) * on_one);
    forces.add(e1.to, s * on_one);
    forces.add(e2.from, -(1 - t) * on_one);
    forces.add(e2.to, -t * on_one);
    sums.stored += 0.5 * stiff * depth * depth;
    report.force += on_one;
    report.force_sum += stiff * depth;
    ++report.touching;
  }
}

}  // namespace powbench::sim
