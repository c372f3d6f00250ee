// Where the mesh of a drawing in space has a hole.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "sim/magnetics/space/space_magnet.h"

namespace powbench::sim {
namespace {

struct OuterFace {
  std::array<int, 3> corner;  ///< ascending
  int cell, opposite;
};

/// Faces of one tetrahedron only.
std::vector<OuterFace> outer_faces(const space::Mesh& m) {
  std::vector<OuterFace> all, out;
  all.reserve(4 * static_cast<std::size_t>(m.count()));
  for (int c = 0; c < m.count(); ++c) {
    const int* v = m.cells.data() + static_cast<std::ptrdiff_t>(c) * 10;
    for (int k = 0; k < 4; ++k) {
      std::array<int, 3> corner{v[(k + 1) % 4], v[(k + 2) % 4], v[(k + 3) % 4]};
      std::sort(corner.begin(), corner.end());
      all.push_back({corner, c, v[k]});
    }
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.corner < b.corner; });
  for (std::size_t k = 0; k < all.size();) {
    std::size_t end = k + 1;
    while (end < all.size() && all[end].corner == all[k].corner) ++end;
    if (end == k + 1) out.push_back(all[k]);
    k = end;
  }
  return out;
}

struct Box {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const Vec3& p) {
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
  Vec3 centre() const { return 0.5 * (low + high); }
  double size() const { return std::sqrt(dot(high - low, high - low)); }
};

class Outside {
 public:
  explicit Outside(const SpaceMagnet& d) : d_(d), faces_(outer_faces(d.mesh)) {
    for (const auto& f : faces_)
      for (const int v : f.corner) box_.add(node(v));
    // the furthest points in directions that cover a sphere
    constexpr int directions = 200;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int k = 0; k < directions; ++k) {
      const double z = 1 - (2.0 * k + 1) / directions, r = std::sqrt(1 - z * z);
      const Vec3 to{r * std::cos(golden * k), r * std::sin(golden * k), z};
      double most = -1e300;
      Vec3 best{};
      for (const auto& f : faces_)
        for (const int v : f.corner)
          if (const double reach = dot(to, node(v)); reach > most) most = reach, best = node(v);
      far_.push_back(best);
    }
  }

  std::optional<SpaceHole> hole() const {
    std::optional<SpaceHole> out;
    for (const auto& f : faces_) {
      if (!part_of_mesh_beyond(f)) continue;
      const Vec3 at = centre(f);
      for (const auto& p : d_.parts)
        if (in_opening(p, at)) return SpaceHole{"in the opening of '" + p.name + "' at", at};
      const auto& part = d_.parts[static_cast<std::size_t>(d_.mesh.region[static_cast<std::size_t>(f.cell)])];
      const bool air = part.steel < 0 && part.role != DrawnRole::coil && part.role != DrawnRole::ring;
      if (!air && !out) out = SpaceHole{"beside '" + part.name + "' at", at};
    }
    return out ? out : closed();
  }

 private:
  const Vec3& node(int v) const { return d_.mesh.nodes[static_cast<std::size_t>(v)]; }
  Vec3 centre(const OuterFace& f) const {
    return (1.0 / 3) * (node(f.corner[0]) + node(f.corner[1]) + node(f.corner[2]));
  }

  /// A face of the hull has nothing of the mesh beyond its plane. Round outsides are not quite convex.
  bool part_of_mesh_beyond(const OuterFace& f) const {
    const Vec3 a = node(f.corner[0]);
    Vec3 normal = cross(node(f.corner[1]) - a, node(f.corner[2]) - a);
    normal = (1 / std::sqrt(dot(normal, normal))) * normal;
    if (dot(normal, node(f.opposite) - a) > 0) normal = -1.0 * normal;
    return std::any_of(far_.begin(), far_.end(),
                       [&](const Vec3& p) { return dot(normal, p - a) > 1e-3 * box_.size(); });
  }

  static bool in_opening(const SpacePart& p, const Vec3& at) {
    if (p.role != DrawnRole::coil && p.role != DrawnRole::ring) return false;
    const auto along = static_cast<std::size_t>(p.coil.axis);
    const double little = 1e-4 * (p.coil.high - p.coil.low);
    return p.coil.from_opening(at) <= 0.01 * p.coil.width && at[along] > p.coil.low + little &&
           at[along] < p.coil.high - little;
  }

  /// The faces fall apart into surfaces: the largest one is the outside.
  std::optional<SpaceHole> closed() const {
    std::vector<std::size_t> parent(faces_.size());
    std::iota(parent.begin(), parent.end(), std::size_t{0});
    const auto root = [&](std::size_t f) {
      while (parent[f] != f) f = parent[f] = parent[parent[f]];
      return f;
    };
    std::map<std::pair<int, int>, std::size_t> first;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto edge = std::minmax(faces_[f].corner[k], faces_[f].corner[(k + 1) % 3]);
        parent[root(f)] = root(first.try_emplace(edge, f).first->second);
      }
    std::map<std::size_t, Box> boxes;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (const int v : faces_[f].corner) boxes[root(f)].add(node(v));
    if (boxes.size() < 2) return std::nullopt;
    const auto smallest = std::min_element(boxes.begin(), boxes.end(), [](const auto& a, const auto& b) {
      return a.second.size() < b.second.size();
    });
    return SpaceHole{"around", smallest->second.centre()};
  }

  const SpaceMagnet& d_;
  std::vector<OuterFace> faces_;
  Box box_;
  std::vector<Vec3> far_;
};

}  // namespace

std::optional<SpaceHole> unmeshed_place(const SpaceMagnet& d) {
  return Outside(d).hole();
}

}  // namespace powbench::sim
