#include "sim/solid/contact_pass.h"

#include <algorithm>

namespace powbench::sim {
namespace {

/// A force on the node, against the face it touches.
inline void spread(const Facet& facet, const PressedNodes& p, std::size_t lane, int node, const Vec3& force,
                   NodeForces& forces) {
  forces.add(node, force);
  for (std::size_t c = 0; c < 3; ++c) forces.add(facet.nodes[c], -p.weights[c][lane] * force);
  if (facet.nodes[3] >= 0) forces.add(facet.nodes[3], -p.weights[3][lane] * force);
}

Vec3 at(const double (&a)[3][contact_lanes], std::size_t lane) {
  return {a[0][lane], a[1][lane], a[2][lane]};
}

void put(double (&a)[3][contact_lanes], std::size_t lane, const Vec3& value) {
  for (std::size_t i = 0; i < 3; ++i) a[i][lane] = value[i];
}

}  // namespace

ContactPass::ContactPass(const ContactPair& pair, const NearSurface& slave, const NearSurface& master,
                         const std::vector<double>& inverse_mass)
    : anchors(slave.skin().nodes.size()),
      pair_(&pair),
      slave_(&slave.skin()),
      master_(&master.skin()),
      inverse_mass_(&inverse_mass),
      kernel_(&best_contact_kernel()),
      faces_(slave, master),
      rubs_(pair.friction_static > 0 || pair.friction_dynamic > 0),
      damps_(pair.damping > 0 || pair.layer_damping > 0 || pair.stick_damping > 0) {
  for (const Facet& f : master_->facets)
    master_stiffness_ += f.stiffness / static_cast<double>(master_->facets.size());
  for (const double s : slave_->stiffness)
    penalty_.push_back(pair.layer > 0 ? 0.5 * pair.layer : pair.factor * series(s, master_stiffness_));
}

double ContactPass::search(const NodeView& view, bool every) {
  const double limit = faces_.search(view, every);
  asleep_.assign(faces_.count(), 0.0);
  lost_.clear();
  std::size_t active = 0;
  for (std::size_t slave = 0; slave < anchors.size(); ++slave) {
    while (active < faces_.count() && faces_.place(active) < slave) ++active;
    const bool known = active < faces_.count() && faces_.place(active) == slave;
    if (anchors[slave].touching && !known) lost_.push_back(slave);
  }
  return limit;
}

double ContactPass::deepest(const NodeView& view) {
  std::vector<int> all(faces_.count());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
  double least = 0;
  faces_.look(all);
  for (std::size_t k = 0; k < all.size(); ++k) least = std::min(least, -faces_.touch(k, view).depth);
  return least;
}

/// Along the normal, N s/m.
double ContactPass::damping(std::size_t slave, double area) const {
  const double layer = 0.5 * pair_->layer_damping * area;
  const double inverse = (*inverse_mass_)[4 * static_cast<std::size_t>(slave_->nodes[slave])];
  return inverse > 0 ? layer + 2 * pair_->damping * std::sqrt(stiffness(slave, area) / inverse) : layer;
}

/// In the face while sticking, N s/m.
double ContactPass::sticking(std::size_t slave, double area) const {
  const double inverse = (*inverse_mass_)[4 * static_cast<std::size_t>(slave_->nodes[slave])];
  return inverse > 0 ? 2 * pair_->stick_damping * std::sqrt(stiffness(slave, area) / inverse) : 0;
}

void ContactPass::release(std::size_t slave, ContactSums& sums) {
  Anchor& anchor = anchors[slave];
  if (!anchor.touching) return;
  sums.friction_lost += 0.5 * dot(anchor.force, anchor.force) / stiffness(slave, anchor.area);
  anchor = {};
}

Anchor ContactPass::fresh_anchor(const NodeView& view, std::size_t slave, const Touch& touch, double dt,
                                 bool start) const {
  const Facet& facet = master_->facets[static_cast<std::size_t>(touch.facet)];
  Vec3 relative = view.velocity(slave_->nodes[slave]);
  for (std::size_t c = 0; c < static_cast<std::size_t>(facet.corners()); ++c)
    relative -= touch.weights[c] * view.velocity(facet.nodes[c]);
  const double area = slave_->area_along(slave, touch.normal, [&](int n) { return view.place(n); });
  const double came = start ? touch.depth : 1.5 * dt * std::max(0.0, -dot(relative, touch.normal));
  return {{}, std::max(area, 1e-3 * slave_->areas[slave]), std::max(0.0, touch.depth - came), true};
}

/// A node that touches, into the next lane.
void ContactPass::take_in(const NodeView& view, std::size_t slave, const Touch& touch, double dt,
                          bool start) {
  Anchor& anchor = anchors[slave];
  if (!anchor.touching) anchor = fresh_anchor(view, slave, touch, dt, start);
  anchor.zero = std::min(anchor.zero, touch.depth);
  const std::size_t lane = filled_++;
  block_[lane] = {slave, touch.facet, touch.depth - anchor.zero, false};
  PressedNodes& p = lanes_;
  const Facet& facet = master_->facets[static_cast<std::size_t>(touch.facet)];
  p.node[lane] = 4 * slave_->nodes[slave];
  for (std::size_t c = 0; c < 4; ++c) {
    p.corner[c][lane] = 4 * std::max(facet.nodes[c], 0);  // the fourth of a triangle has no weight
    p.weights[c][lane] = touch.weights[c];
  }
  put(p.normal, lane, touch.normal);
  put(p.before, lane, anchor.force);
  p.stiff[lane] = stiffness(slave, anchor.area);
}

/// Normal force, and whether the node slides under it.
void ContactPass::weigh(std::size_t lane) {
  Entry& node = block_[lane];
  PressedNodes& p = lanes_;
  const double area = anchors[node.slave].area;
  double normal_force = p.stiff[lane] * node.depth;
  if (damps_) normal_force = std::max(0.0, normal_force - damping(node.slave, area) * p.approach[lane]);
  p.normal_force[lane] = normal_force;
  if (!rubs_) {
    put(p.trial, lane, {});
    return;
  }
  // below the limit of the lowest coefficient it sticks at any speed; most nodes are, and need neither root nor exp
  const double most = pair_->shear_limit * area, square = p.square[lane];
  const double least = std::min(pair_->friction_dynamic * normal_force, most);
  constexpr double rounding = 1e-12;
  if (square <= (1 - rounding) * least * least) return;
  const double size = std::sqrt(square);
  const double limit = std::min(friction_coefficient(*pair_, norm(at(p.speed, lane))) * normal_force, most);
  node.slides = size > limit;
  if (node.slides) put(p.trial, lane, limit / size * at(p.trial, lane));
}

/// Forces and sums of a node that touches.
void ContactPass::press(std::size_t lane, double sign, NodeForces& forces, NodeForces& damped,
                        ContactSums& sums, ContactReport& report) {
  const Entry& node = block_[lane];
  const PressedNodes& p = lanes_;
  const Facet& facet = master_->facets[static_cast<std::size_t>(node.facet)];
  Anchor& anchor = anchors[node.slave];
  const double spring = p.stiff[lane] * node.depth;
  sums.stored += 0.5 * spring * node.depth;
  sums.friction_lost += p.lost[lane];
  sums.stored += p.stored[lane];
  anchor.force = at(p.trial, lane);
  Vec3 force = at(p.force, lane);
  if (damps_) {  // may take from the pressure all there is, not more
    const double by = -damping(node.slave, anchor.area) * p.approach[lane];
    Vec3 lossy = std::max(by, -spring) * at(p.normal, lane);
    if (rubs_ && !node.slides && pair_->stick_damping > 0) {
      const Vec3 sticks = -sticking(node.slave, anchor.area) * at(p.speed, lane);
      force += sticks;
      lossy += sticks;
    }
    spread(facet, p, lane, slave_->nodes[node.slave], lossy, damped);
  }
  spread(facet, p, lane, slave_->nodes[node.slave], force, forces);
  report.force += sign * force;
  report.force_sum += p.normal_force[lane];
  if (sign > 0) report.area += anchor.area;
  ++report.touching;
  if (keeps_pressed)
    pressed_.push_back({node.slave,
                        node.facet,
                        {p.weights[0][lane], p.weights[1][lane], p.weights[2][lane], p.weights[3][lane]},
                        p.normal_force[lane]});
}

/// Forces of the nodes in the block, in their order.
void ContactPass::flush(const NodeView& view, double dt, double sign, NodeForces& forces, NodeForces& damped,
                        ContactSums& sums, ContactReport& report) {
  if (filled_ == 0) return;
  const PressTask task{view.v, dt, 1, &lanes_};
  kernel_->slip(task);
  for (std::size_t lane = 0; lane < filled_; ++lane) weigh(lane);
  kernel_->rub(task);
  for (std::size_t lane = 0; lane < filled_; ++lane) press(lane, sign, forces, damped, sums, report);
  filled_ = 0;
}

void ContactPass::apply(const NodeView& view, double dt, double sign, bool start, double travel,
                        NodeForces& forces, NodeForces& damped, ContactSums& sums, ContactReport& report) {
  pressed_.clear();
  const auto let_go = [&](std::size_t slave) {
    flush(view, dt, sign, forces, damped, sums, report);  // sums in the order of the nodes
    release(slave, sums);
  };
  auto lost = lost_.begin();
  std::size_t k = 0;
  while (k < asleep_.size()) {
    constexpr std::size_t together = 16 * contact_lanes;  // their numbers stay in the first cache
    for (awake_.clear(); k < asleep_.size() && awake_.size() < together; ++k)
      if (travel >= asleep_[k]) awake_.push_back(static_cast<int>(k));
    faces_.look(awake_);
    for (std::size_t q = 0; q < awake_.size(); ++q) {
      const auto active = static_cast<std::size_t>(awake_[q]);
      const std::size_t slave = faces_.place(active);
      const Touch touch = faces_.touch(q, view);
      for (; lost != lost_.end() && *lost < slave; ++lost) let_go(*lost);
      if (touch.facet >= 0) {
        take_in(view, slave, touch, dt, start);
        if (filled_ == contact_lanes) flush(view, dt, sign, forces, damped, sums, report);
      } else {
        asleep_[active] = travel + touch.away;
        if (anchors[slave].touching) let_go(slave);
      }
    }
  }
  for (; lost != lost_.end(); ++lost) let_go(*lost);
  lost_.clear();
  flush(view, dt, sign, forces, damped, sums, report);
}

void ContactPass::add_pressure(std::vector<double>& all) const {
  for (const Pressed& p : pressed_) {
    all[static_cast<std::size_t>(slave_->nodes[p.slave])] += p.force / anchors[p.slave].area;
    const Facet& facet = master_->facets[static_cast<std::size_t>(p.facet)];
    for (std::size_t c = 0; c < static_cast<std::size_t>(facet.corners()); ++c) {
      const auto place = static_cast<std::size_t>(master_->place_of(facet.nodes[c]));
      all[static_cast<std::size_t>(facet.nodes[c])] += p.weights[c] * p.force / master_->areas[place];
    }
  }
}

/// A spring k between a node and a point of a face, k (u - sum w u_f)^2 / 2, is at most k (u^2 + sum w u_f^2): twice
/// its stiffness at the node, and twice at the corners together.
void ContactPass::add_stiffness(std::vector<double>& all) const {
  for (std::size_t n = 0; n < slave_->nodes.size(); ++n)
    all[static_cast<std::size_t>(slave_->nodes[n])] += 2 * stiffness(n, slave_->areas[n]);
  for (std::size_t n = 0; n < master_->nodes.size(); ++n)  // as much comes from the nodes that stand on it
    all[static_cast<std::size_t>(master_->nodes[n])] +=
        pair_->layer > 0
            ? pair_->layer * master_->areas[n]
            : 2 * pair_->factor * series(master_->stiffness[n], master_stiffness_) * master_->areas[n];
}

void ContactPass::add_damping(std::vector<double>& all) const {
  if (!damps_) return;
  for (std::size_t n = 0; n < slave_->nodes.size(); ++n) {
    const double c = std::max(damping(n, slave_->areas[n]), sticking(n, slave_->areas[n]));
    all[static_cast<std::size_t>(slave_->nodes[n])] +=
        4 * c;  // twice, and as much from the nodes that stand on it
  }
}

}  // namespace powbench::sim
