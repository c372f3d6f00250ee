#include "sim/solid/contact_geometry.h"

#include <algorithm>
#include <cstdint>

namespace powbench::sim {
namespace {

constexpr double border = -1e-9;  ///< barycentric: on a shared border both neighbours see the node above them

/// Nearest point of the triangle a b c with the border b c outside (the others lead to neighbours in the fan).
void on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& point, bool all_outside,
                 Projection& out, std::array<double, 3>& w) {
  const Vec3 n = cross(b - a, c - a);
  const double square = dot(n, n);
  out.normal = 1 / std::sqrt(square) * n;
  const Vec3 r = point - a;
  w[1] = dot(cross(r, c - a), n) / square;
  w[2] = dot(cross(b - a, r), n) / square;
  w[0] = 1 - w[1] - w[2];
  out.gap = dot(r, out.normal);
  out.offset = out.gap * out.normal;
  out.distance = std::fabs(out.gap);
  out.aside = 0;
  out.edge = -1;
  const bool inside = w[0] >= border && (!all_outside || (w[1] >= border && w[2] >= border));
  if (inside) return;
  const std::array<Vec3, 3> p{a, b, c};
  double best = 1e300;
  std::array<double, 3> best_w{};
  for (std::size_t k = all_outside ? 0 : 1; k < (all_outside ? 3u : 2u); ++k) {
    const Vec3 &from = p[k], &to = p[(k + 1) % 3];
    const double t = std::clamp(dot(point - from, to - from) / dot(to - from, to - from), 0.0, 1.0);
    const Vec3 d = point - from - t * (to - from);
    if (dot(d, d) >= best) continue;
    best = dot(d, d);
    out.offset = d;
    out.edge = static_cast<int>(k);
    best_w = {};
    best_w[k] = 1 - t;
    best_w[(k + 1) % 3] = t;
  }
  w = best_w;
  out.distance = std::sqrt(best);
  out.aside = std::sqrt(std::max(0.0, best - out.gap * out.gap));
}

struct Bin {
  std::uint64_t key;
  int box;
  bool operator<(const Bin& o) const { return key != o.key ? key < o.key : box < o.box; }
};

std::uint64_t key_of(std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto part = [](std::int64_t v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffffu; };
  return part(i) << 42 | part(j) << 21 | part(k);
}

}  // namespace

Projection project(const std::array<Vec3, 4>& p, int count, const Vec3& point) {
  Projection out;
  std::array<double, 3> w{};
  if (count == 3) {
    on_triangle(p[0], p[1], p[2], point, true, out, w);
    out.weights = {w[0], w[1], w[2], 0};
    return out;
  }
  const Vec3 middle = 0.25 * (p[0] + p[1] + p[2] + p[3]);
  const Vec3 side = cross(point - middle, cross(p[2] - p[0], p[3] - p[1]));
  std::array<double, 4> turn{};
  for (std::size_t k = 0; k < 4; ++k) turn[k] = dot(p[k] - middle, side);
  std::size_t k = 0;  // the sector of the fan that the node is in
  for (std::size_t s = 0; s < 4; ++s)
    if (turn[s] >= 0 && turn[(s + 1) % 4] < 0) {
      k = s;
      break;
    }
  on_triangle(middle, p[k], p[(k + 1) % 4], point, false, out, w);
  out.weights.fill(0.25 * w[0]);
  out.weights[k] += w[1];
  out.weights[(k + 1) % 4] += w[2];
  if (out.edge >= 0) out.edge = static_cast<int>(k);
  return out;
}

std::array<Vec3, 4> corners_now(const NodeView& view, const Facet& f) {
  std::array<Vec3, 4> p{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(f.corners()); ++k) p[k] = view.place(f.nodes[k]);
  return p;
}

bool nearest_on_edges(const Vec3& from1, const Vec3& to1, const Vec3& from2, const Vec3& to2, double& on1,
                      double& on2) {
  const Vec3 d1 = to1 - from1, d2 = to2 - from2, r = from1 - from2;
  const double a = dot(d1, d1), b = dot(d1, d2), c = dot(d2, d2);
  const double square = a * c - b * b;
  if (square < 4e-4 * a * c) return false;
  on1 = (b * dot(d2, r) - c * dot(d1, r)) / square;
  on2 = (a * dot(d2, r) - b * dot(d1, r)) / square;
  return on1 >= 0 && on1 < 1 && on2 >= 0 && on2 < 1;  // half open: a chain of edges is hit once
}

void Box::include(const Vec3& p) {
  for (int i = 0; i < 3; ++i) {
    lo[i] = std::min(lo[i], p[i]);
    hi[i] = std::max(hi[i], p[i]);
  }
}

void Box::grow(double by) {
  lo -= Vec3{by, by, by};
  hi += Vec3{by, by, by};
}

std::vector<std::vector<int>> overlapping(const std::vector<Box>& probes, const std::vector<Box>& targets) {
  std::vector<std::vector<int>> found(probes.size());
  if (targets.empty()) return found;
  double size = 0;
  for (const Box& b : targets)
    for (int i = 0; i < 3; ++i) size = std::max(size, b.extent()[i]);
  size = std::max(size, 1e-9);
  Box all;
  for (const Box& b : targets) {
    all.include(b.lo);
    all.include(b.hi);
  }
  const auto each_cell = [&](const Box& b, const auto& visit) {
    std::int64_t lo[3], hi[3];
    for (int i = 0; i < 3; ++i) {
      lo[i] = static_cast<std::int64_t>(std::floor((std::max(b.lo[i], all.lo[i]) - all.lo[i]) / size));
      hi[i] = static_cast<std::int64_t>(std::floor((std::min(b.hi[i], all.hi[i]) - all.lo[i]) / size));
    }
    for (auto k = lo[2]; k <= hi[2]; ++k)
      for (auto j = lo[1]; j <= hi[1]; ++j)
        for (auto i = lo[0]; i <= hi[0]; ++i) visit(key_of(i, j, k));
  };
  std::vector<Bin> bins;
  for (std::size_t t = 0; t < targets.size(); ++t)
    each_cell(targets[t], [&](std::uint64_t key) { bins.push_back({key, static_cast<int>(t)}); });
  std::sort(bins.begin(), bins.end());
  for (std::size_t p = 0; p < probes.size(); ++p) {
    auto& mine = found[p];
    each_cell(probes[p], [&](std::uint64_t key) {
      for (auto it = std::lower_bound(bins.begin(), bins.end(), Bin{key, -1});
           it != bins.end() && it->key == key; ++it) {
        const Box& t = targets[static_cast<std::size_t>(it->box)];
        bool overlap = true;
        for (int i = 0; i < 3; ++i)
          overlap = overlap && t.lo[i] <= probes[p].hi[i] && t.hi[i] >= probes[p].lo[i];
        if (overlap) mine.push_back(it->box);
      }
    });
    std::sort(mine.begin(), mine.end());
    mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
  }
  return found;
}

}  // namespace powbench::sim
