#include "sim/solid/nearest_faces.h"

#include <algorithm>

namespace powbench::sim {
namespace {

constexpr double facing = -0.2;    ///< cosine between a node's and a face's normal; above it they do not meet
constexpr double opposite = -0.5;  ///< below it a node may stand on a face's border
constexpr double shallow = 0.25;   ///< of the depth limit: so near a face, only its neighbours can be nearer
constexpr double folded = 1.1;    ///< tangent of half the angle between neighbours; beyond it nothing is said
constexpr double tilting = 0.01;  ///< by which that tangent may grow until the next search
constexpr double overhang = 1e-3;  ///< of a face's size: so far beyond its border a node still stands on it

Vec3 node_normal(const SolidSurface& s, std::size_t place, const NodeView& view) {
  Vec3 sum;
  for (const int f : s.facets_at[place]) {
    const Facet& facet = s.facets[static_cast<std::size_t>(f)];
    sum += unit(facet_normal(corners_now(view, facet), facet.corners()));
  }
  return unit(sum);
}

/// m, of the triangles from a face's middle to its borders: the smallest height.
double smallest_height(const std::array<Vec3, 4>& p, std::size_t corners) {
  Vec3 middle;
  for (std::size_t k = 0; k < corners; ++k) middle += 1.0 / static_cast<double>(corners) * p[k];
  double smallest = 1e300;
  for (std::size_t k = 0; k < corners; ++k) {
    const Vec3 side = p[(k + 1) % corners] - p[k];
    smallest = std::min(smallest, norm(cross(side, middle - p[k])) / norm(side));
  }
  return smallest;
}

}  // namespace

NearestFaces::NearestFaces(const NearSurface& from, const NearSurface& onto)
    : from_(&from), onto_(&onto), kernel_(&best_contact_kernel()) {}

double NearestFaces::search(const NodeView& view, bool every) {
  const SolidSurface &slave = from_->skin(), &master = onto_->skin();
  std::vector<Vec3> normals(master.facets.size());
  double smallest = 1e300;
  ledge_ = 0;
  for (std::size_t f = 0; f < normals.size(); ++f) {
    const Vec3 area = facet_normal(corners_now(view, master.facets[f]), master.facets[f].corners());
    normals[f] = unit(area);
    smallest = std::min(smallest, face_margin(area));
    ledge_ = std::max(ledge_, 2.1 * overhang * face_margin(area));
  }
  if (depth_limit_ == 0) depth_limit_ = smallest;
  const std::vector<int>& faces = onto_->faces();
  std::vector<Box> probes(from_->nodes().size()), targets(faces.size());
  std::vector<double> sure(faces.size());
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const Facet& facet = master.facets[static_cast<std::size_t>(faces[k])];
    const auto p = onto_->corners_now(k);
    for (std::size_t c = 0; c < static_cast<std::size_t>(facet.corners()); ++c) targets[k].include(p[c]);
    targets[k].grow(every ? 1e300 : std::max(depth_limit_, face_margin(facet_normal(p, facet.corners()))));
    const double tangent = tangent_around(facet, normals);
    if (tangent < folded)
      sure[k] = smallest_height(p, static_cast<std::size_t>(facet.corners())) / (tangent + tilting);
  }
  for (std::size_t n = 0; n < probes.size(); ++n) probes[n].include(from_->place(n));
  const auto found = every ? std::vector<std::vector<int>>{} : overlapping(probes, targets);
  std::vector<int> all;
  for (std::size_t k = 0; every && k < faces.size(); ++k) all.push_back(static_cast<int>(k));
  active_.clear();
  point_.clear();
  begin_.assign(1, 0);
  candidates_.clear();
  for (std::size_t n = 0; n < probes.size(); ++n) {
    const auto& list = every ? all : found[n];
    if (list.empty()) continue;
    const auto place = static_cast<std::size_t>(from_->nodes()[n]);
    const Vec3 normal = node_normal(slave, place, view);
    for (const int k : list) {
      const double cosine =
          dot(normal, normals[static_cast<std::size_t>(faces[static_cast<std::size_t>(k)])]);
      if (cosine > facing) continue;
      candidates_.push_back({k, cosine < opposite, sure[static_cast<std::size_t>(k)]});
    }
    if (static_cast<int>(candidates_.size()) == begin_.back()) continue;
    active_.push_back(static_cast<int>(place));
    point_.push_back(4 * static_cast<int>(n));
    begin_.push_back(static_cast<int>(candidates_.size()));
  }
  first_.assign(begin_.begin(), begin_.end() - 1);
  return smallest;
}

/// Largest tangent of half the angle between a face and its neighbours. At a distance d of the face and e from its
/// border a neighbour is nearer only where e < d tan(angle / 2), on either side of the face.
double NearestFaces::tangent_around(const Facet& facet, const std::vector<Vec3>& normals) const {
  const SolidSurface& master = onto_->skin();
  const Vec3& mine = normals[static_cast<std::size_t>(&facet - master.facets.data())];
  double largest = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k)
    for (const int f : master.facets_at[static_cast<std::size_t>(master.place_of(facet.nodes[k]))]) {
      const Vec3& other = normals[static_cast<std::size_t>(f)];
      const double cosine = dot(mine, other);
      largest = std::max(largest, cosine > -0.5 ? norm(cross(mine, other)) / (1 + cosine) : 1e300);
    }
  return largest;
}

bool NearestFaces::behind_all(const NodeView& view, const Facet& facet, const Projection& at) const {
  const SolidSurface& master = onto_->skin();
  const auto count = static_cast<std::size_t>(facet.corners());
  for (std::size_t k = 0; k < count; ++k) {
    if (at.weights[k] <= 1e-12) continue;
    for (const int f : master.facets_at[static_cast<std::size_t>(master.place_of(facet.nodes[k]))]) {
      const Facet& around = master.facets[static_cast<std::size_t>(f)];
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

/// The pairs of seeing_ and seen_face_, eight a block. A node that does not touch a face must move at least a way
/// against it to touch it: to get from the front to behind it and above it, or from too deep to the limit. Behind its
/// plane, beside it, nothing is known, for a way in may lead through faces that are no candidates.
void NearestFaces::see(SeenFaces* out) {
  if (onto_->four_sided()) {
    kernel_->see({from_->places(), seeing_.data(), onto_->places(), onto_->corners().data(),
                  seen_face_.data(), static_cast<int>(seeing_.size()) / contact_lanes, depth_limit_, ledge_,
                  out});
    return;
  }
  for (std::size_t a = 0; a < seeing_.size(); ++a) {
    const auto face = static_cast<std::size_t>(seen_face_[a]);
    const int corners = onto_->skin().facets[static_cast<std::size_t>(onto_->faces()[face])].corners();
    const Projection at =
        project(onto_->corners_now(face), corners, from_->place(static_cast<std::size_t>(seeing_[a] / 4)));
    SeenFaces& s = out[a / contact_lanes];
    const std::size_t lane = a % contact_lanes;
    const double deep = at.distance - depth_limit_;
    s.distance[lane] = at.distance;
    s.inner[lane] = corners * *std::min_element(at.weights.begin(), at.weights.begin() + corners);
    s.gap[lane] = at.gap;
    s.aside[lane] = at.aside;
    s.way[lane] = std::max(at.gap >= 0 ? std::max({deep, at.gap, at.aside - ledge_}) : deep, 0.0);
    for (std::size_t i = 0; i < 3; ++i) s.normal[i][lane] = at.normal[i];
    for (std::size_t c = 0; c < 4; ++c) s.weights[c][lane] = at.weights[c];
  }
}

/// No other candidate is nearer: the node stands near a face, and further from its border than a neighbour could rise
/// above it.
inline bool NearestFaces::sure(const Candidate& candidate, const SeenFaces& s, std::size_t lane) const {
  return s.distance[lane] < shallow * depth_limit_ && s.aside[lane] == 0 &&
         s.inner[lane] * candidate.sure > s.distance[lane];
}

/// In rounds, so that a block of nodes looks at a time: in each, every node that asks looks at one more candidate,
/// first at the nearest of last time. Of candidates equally near the first counts, whatever the order was.
void NearestFaces::look(const std::vector<int>& active) {
  looking_.resize(active.size());
  best_.assign(active.size(), {depth_limit_, depth_limit_, -1, 0});
  asking_.resize(active.size());
  for (std::size_t q = 0; q < active.size(); ++q) {
    const auto k = static_cast<std::size_t>(active[q]);
    looking_[q] = point_[k];
    asking_[q] = {static_cast<int>(q), point_[k], first_[k], begin_[k], begin_[k + 1]};
  }
  const Candidate* const candidates = candidates_.data();
  Best* const bests = best_.data();
  Asking* const asking = asking_.data();
  std::size_t seen = 0;  // blocks of the rounds before
  for (std::size_t count = active.size(); count > 0;) {
    const std::size_t blocks = (count + contact_lanes - 1) / contact_lanes;
    seeing_.resize(blocks * contact_lanes);
    seen_face_.resize(blocks * contact_lanes);
    if (seen_.size() < seen + blocks) seen_.resize(seen + blocks);
    int* const points = seeing_.data();
    int* const faces = seen_face_.data();
    for (std::size_t a = 0; a < count; ++a) {
      points[a] = asking[a].point;
      faces[a] = candidates[asking[a].candidate].face;
    }
    for (std::size_t a = count; a < seeing_.size(); ++a) {
      points[a] = points[count - 1];
      faces[a] = faces[count - 1];
    }
    const SeenFaces* const blocks_seen = seen_.data() + seen;
    see(seen_.data() + seen);
    std::size_t kept = 0;
    for (std::size_t a = 0; a < count; ++a) {
      Asking node = asking[a];
      const SeenFaces& s = blocks_seen[a / contact_lanes];
      const std::size_t lane = a % contact_lanes;
      Best& best = bests[node.number];
      best.away = std::min(best.away, s.way[lane]);
      const double distance = s.distance[lane];
      if (distance < best.distance || (distance == best.distance && node.candidate < best.candidate)) {
        best.distance = distance;
        best.candidate = node.candidate;
        best.seen = static_cast<int>(contact_lanes * seen + a);
        if (sure(candidates[node.candidate], s, lane)) {
          best.away = 0;  // what it has not looked at may be nearer than that
          continue;
        }
      }
      const int tried_first = first_[static_cast<std::size_t>(active[static_cast<std::size_t>(node.number)])];
      if (node.next == tried_first) ++node.next;
      node.candidate = node.next++;
      if (node.candidate < node.end) asking[kept++] = node;
    }
    count = kept;
    seen += blocks;
  }
  for (std::size_t q = 0; q < active.size(); ++q)
    if (bests[q].candidate >= 0) first_[static_cast<std::size_t>(active[q])] = bests[q].candidate;
}

/// A node behind the plane of its nearest face, but not above it.
Touch NearestFaces::beside(std::size_t q, Touch touch, double aside, const NodeView& view) const {
  const Best& best = best_[q];
  const Candidate& nearest = candidates_[static_cast<std::size_t>(best.candidate)];
  const Facet& facet = onto_->skin().facets[static_cast<std::size_t>(touch.facet)];
  const auto corners = onto_->corners_now(static_cast<std::size_t>(nearest.face));
  const double size = 2 * face_margin(facet_normal(corners, facet.corners()));
  if (nearest.square && aside <= overhang * size) return touch;
  const Projection at =
      project(corners, facet.corners(), from_->place(static_cast<std::size_t>(looking_[q] / 4)));
  if (!behind_all(view, facet, at)) return nothing(best);
  touch.depth = best.distance;
  touch.normal = -1 / best.distance * at.offset;
  return touch;
}

}  // namespace powbench::sim
