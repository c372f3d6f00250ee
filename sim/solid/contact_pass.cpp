#include "sim/solid/contact_pass.h"

#include <algorithm>

namespace powbench::sim {
namespace {

constexpr double facing = -0.2;    ///< cosine between a node's and a face's normal; above it they do not meet
constexpr double opposite = -0.5;  ///< below it a node may stand on a face's border
constexpr double level = 0.996;    ///< cosine between neighbours that count as one plane
constexpr double shallow = 0.05;   ///< of the depth limit: so near a flat face, no other can be nearer
constexpr double overhang = 1e-3;  ///< of a face's size: so far beyond its border a node still stands on it

double size_of(const std::array<Vec3, 4>& p, int count) {
  return std::sqrt(0.5 * norm(facet_normal(p, count)));
}

Vec3 node_normal(const SolidSurface& s, std::size_t place, const NodeView& view) {
  Vec3 sum;
  for (const int f : s.facets_at[place]) {
    const Facet& facet = s.facets[static_cast<std::size_t>(f)];
    sum += unit(facet_normal(corners_now(view, facet), facet.corners()));
  }
  return unit(sum);
}

}  // namespace

ContactPass::ContactPass(const ContactPair& pair, const SolidSurface& slave, const SolidSurface& master,
                         const std::vector<double>& inverse_mass)
    : anchors(slave.nodes.size()),
      pair_(&pair),
      slave_(&slave),
      master_(&master),
      inverse_mass_(&inverse_mass) {
  for (const Facet& f : master.facets)
    master_stiffness_ += f.stiffness / static_cast<double>(master.facets.size());
}

double ContactPass::search(const NodeView& view) {
  std::vector<Box> probes(slave_->nodes.size()), targets(master_->facets.size());
  std::vector<Vec3> normals(master_->facets.size());
  depth_limit_ = 1e300;
  for (std::size_t f = 0; f < targets.size(); ++f) {
    const auto p = corners_now(view, master_->facets[f]);
    const int count = master_->facets[f].corners();
    for (int k = 0; k < count; ++k) targets[f].include(p[static_cast<std::size_t>(k)]);
    const double margin = 0.5 * size_of(p, count);
    targets[f].grow(margin);
    normals[f] = unit(facet_normal(p, count));
    depth_limit_ = std::min(depth_limit_, margin);
  }
  for (std::size_t n = 0; n < probes.size(); ++n) probes[n].include(view.place(slave_->nodes[n]));
  flat_.assign(targets.size(), 0);
  for (std::size_t f = 0; f < targets.size(); ++f) flat_[f] = flat_around(master_->facets[f], normals);
  auto found = overlapping(probes, targets);
  active_.clear();
  near_.clear();
  for (std::size_t n = 0; n < probes.size(); ++n) {
    auto& list = found[n];
    if (list.empty()) continue;
    const Vec3 normal = node_normal(*slave_, n, view);
    list.erase(
        std::remove_if(list.begin(), list.end(),
                       [&](int f) { return dot(normal, normals[static_cast<std::size_t>(f)]) > facing; }),
        list.end());
    if (list.empty()) continue;
    active_.push_back(static_cast<int>(n));
    near_.emplace_back();
    for (const int f : list)
      near_.back().push_back({f, dot(normal, normals[static_cast<std::size_t>(f)]) < opposite});
  }
  asleep_.assign(active_.size(), 0.0);
  return depth_limit_;
}

bool ContactPass::flat_around(const Facet& facet, const std::vector<Vec3>& normals) const {
  const Vec3& mine = normals[static_cast<std::size_t>(&facet - master_->facets.data())];
  for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k)
    for (const int f : master_->facets_at[static_cast<std::size_t>(master_->place_of(facet.nodes[k]))])
      if (dot(mine, normals[static_cast<std::size_t>(f)]) < level) return false;
  return true;
}

bool ContactPass::behind_all(const NodeView& view, const Facet& facet, const Projection& at) const {
  const auto count = static_cast<std::size_t>(facet.corners());
  for (std::size_t k = 0; k < count; ++k) {
    if (at.weights[k] <= 1e-12) continue;
    for (const int f : master_->facets_at[static_cast<std::size_t>(master_->place_of(facet.nodes[k]))]) {
      const Facet& around = master_->facets[static_cast<std::size_t>(f)];
      int shared = 0;
      for (std::size_t c = 0; c < count; ++c)
        if (at.weights[c] > 1e-12)
          shared += std::find(around.nodes.begin(), around.nodes.end(), facet.nodes[c]) != around.nodes.end();
      int needed = 0;
      for (std::size_t c = 0; c < count; ++c) needed += at.weights[c] > 1e-12;
      if (shared < needed) continue;
      if (dot(at.offset, facet_normal(corners_now(view, around), around.corners())) >= 0) return false;
    }
  }
  return true;
}

ContactPass::Touch ContactPass::nearest(std::size_t active, const NodeView& view) const {
  const Vec3 x = view.place(slave_->nodes[static_cast<std::size_t>(active_[active])]);
  Projection best;
  best.distance = depth_limit_;
  int nearest = -1;
  bool stands = false;  // squarely opposite, so that it may stand on the border
  for (const auto& [f, square] : near_[active]) {
    const Facet& facet = master_->facets[static_cast<std::size_t>(f)];
    const Projection at = project(corners_now(view, facet), facet.corners(), x);
    if (at.distance >= best.distance) continue;
    best = at;
    nearest = f;
    stands = square;
    if (at.aside == 0 && at.distance < shallow * depth_limit_ && flat_[static_cast<std::size_t>(f)]) break;
  }
  // inside or outside is decided by the nearest face alone: behind a more distant face's plane means nothing
  const Touch none{-1, best.distance, 0, {}, {}};
  if (nearest < 0 || best.gap >= 0) return none;
  const Facet& facet = master_->facets[static_cast<std::size_t>(nearest)];
  if (best.aside <= (stands ? overhang * size_of(corners_now(view, facet), facet.corners()) : 0))
    return {nearest, 0, -best.gap, best.normal, best.weights};
  if (!behind_all(view, facet, best)) return none;
  return {nearest, 0, best.distance, -1 / best.distance * best.offset, best.weights};
}

double ContactPass::deepest(const NodeView& view) const {
  double least = 0;
  for (std::size_t k = 0; k < active_.size(); ++k) least = std::min(least, -nearest(k, view).depth);
  return least;
}

double ContactPass::stiffness(std::size_t slave, double area) const {
  if (pair_->layer > 0) return 0.5 * pair_->layer * area;
  return pair_->factor * series(slave_->stiffness[slave], master_stiffness_) * area;
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

/// A force on the node, against the face it touches.
void ContactPass::spread(const Touch& touch, int node, const Vec3& force, NodeForces& forces) const {
  const Facet& facet = master_->facets[static_cast<std::size_t>(touch.facet)];
  forces.add(node, force);
  for (std::size_t c = 0; c < static_cast<std::size_t>(facet.corners()); ++c)
    forces.add(facet.nodes[c], -touch.weights[c] * force);
}

Vec3 ContactPass::friction(std::size_t slave, const Touch& touch, const Vec3& relative, double dt,
                           double normal_force, ContactSums& sums, Vec3& damped) {
  Anchor& anchor = anchors[slave];
  const double k = stiffness(slave, anchor.area);
  const Vec3 before = anchor.force;
  const Vec3 speed = relative - dot(relative, touch.normal) * touch.normal;
  Vec3 trial = before - dot(before, touch.normal) * touch.normal - k * dt * speed;
  const double coefficient = friction_coefficient(*pair_, norm(speed));
  const double limit = std::min(coefficient * normal_force, pair_->shear_limit * anchor.area);
  const double size = norm(trial);
  const bool slides = size > limit;
  if (slides) trial = limit / size * trial;
  // what the bodies lost in this step less what the anchor gained
  const double work = -0.5 * dt * dot(before + trial, speed);
  const double gained = 0.5 * (dot(trial, trial) - dot(before, before)) / k;
  sums.friction_lost += work - gained;
  sums.stored += 0.5 * dot(trial, trial) / k;
  anchor.force = trial;
  if (!slides && pair_->stick_damping > 0) damped -= sticking(slave, anchor.area) * speed;
  return trial;
}

void ContactPass::apply(const NodeView& view, double dt, double sign, bool start, NodeForces& forces,
                        NodeForces& damped, ContactSums& sums, ContactReport& report) {
  pressed_.clear();
  const bool rubs = pair_->friction_static > 0 || pair_->friction_dynamic > 0;
  const bool damps = pair_->damping > 0 || pair_->layer_damping > 0 || pair_->stick_damping > 0;
  const auto release = [&](std::size_t slave) {
    if (!anchors[slave].touching) return;
    sums.friction_lost +=
        0.5 * dot(anchors[slave].force, anchors[slave].force) / stiffness(slave, anchors[slave].area);
    anchors[slave] = {};
  };
  for (std::size_t k = 0; k < active_.size(); ++k) {
    const auto slave = static_cast<std::size_t>(active_[k]);
    if (travel_ < asleep_[k]) continue;
    const Touch touch = nearest(k, view);
    if (touch.facet < 0) {
      release(slave);
      asleep_[k] = travel_ + touch.away;
      continue;
    }
    const int node = slave_->nodes[slave];
    const Facet& facet = master_->facets[static_cast<std::size_t>(touch.facet)];
    Vec3 relative = view.velocity(node);
    for (std::size_t c = 0; c < static_cast<std::size_t>(facet.corners()); ++c)
      relative -= touch.weights[c] * view.velocity(facet.nodes[c]);
    Anchor& anchor = anchors[slave];
    if (!anchor.touching) {
      const double area = slave_->area_along(slave, touch.normal, [&](int n) { return view.place(n); });
      const double came = start ? touch.depth : 1.5 * dt * std::max(0.0, -dot(relative, touch.normal));
      anchor = {{}, std::max(area, 1e-3 * slave_->areas[slave]), std::max(0.0, touch.depth - came), true};
    }
    anchor.zero = std::min(anchor.zero, touch.depth);
    const double depth = touch.depth - anchor.zero;
    const double stiff = stiffness(slave, anchor.area);
    double normal_force = stiff * depth;
    sums.stored += 0.5 * normal_force * depth;
    Vec3 lossy;
    if (damps) {  // may take from the pressure all there is, not more
      const double by = -damping(slave, anchor.area) * dot(relative, touch.normal);
      lossy = std::max(by, -normal_force) * touch.normal;
      normal_force = std::max(0.0, normal_force + by);
    }
    Vec3 force = normal_force * touch.normal;
    if (rubs) {
      Vec3 sticks;
      force += friction(slave, touch, relative, dt, normal_force, sums, sticks);
      force += sticks;
      lossy += sticks;
    }
    spread(touch, node, force, forces);
    if (damps) spread(touch, node, lossy, damped);
    report.force += sign * force;
    report.force_sum += normal_force;
    if (sign > 0) report.area += anchor.area;
    ++report.touching;
    pressed_.push_back({slave, touch.facet, touch.weights, normal_force});
  }
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
  if (!(pair_->damping > 0 || pair_->layer_damping > 0 || pair_->stick_damping > 0)) return;
  for (std::size_t n = 0; n < slave_->nodes.size(); ++n) {
    const double c = std::max(damping(n, slave_->areas[n]), sticking(n, slave_->areas[n]));
    all[static_cast<std::size_t>(slave_->nodes[n])] +=
        4 * c;  // twice, and as much from the nodes that stand on it
  }
}

}  // namespace powbench::sim
