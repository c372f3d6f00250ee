// How a magnet drawn in space moves: what rises with the armature, how what lies between stretches, how far that goes.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "sim/magnetics/space/face_tree.h"
#include "sim/magnetics/space/space_magnet.h"

namespace powbench::sim {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

using FaceKey = std::array<int, 3>;

/// Corners of a tetrahedron without one of them.
constexpr std::array<std::array<std::size_t, 3>, 4> tet_faces{{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};

/// Twice the area of a triangle seen along z; 0 where it lies along z.
double plan_area(const Face3& f) {
  const Vec3 normal = cross(f[1] - f[0], f[2] - f[0]);
  return std::fabs(normal.z) <= 1e-6 * std::sqrt(dot(normal, normal)) ? 0 : normal.z;
}

struct SpaceMotion {
  const SpaceMagnet& d;
  const space::Mesh& m = d.mesh;

  const int* cell(int c) const { return m.cells.data() + static_cast<std::ptrdiff_t>(c) * 10; }
  const SpacePart& part(int c) const { return d.parts[at(m.region[at(c)])]; }
  bool stretches(int c) const { return part(c).role == DrawnRole::stretch; }
  FaceKey key(int c, std::size_t face) const {
    FaceKey k{};
    for (std::size_t i = 0; i < 3; ++i) k[i] = cell(c)[tet_faces[face][i]];
    std::sort(k.begin(), k.end());
    return k;
  }
  Face3 place(const FaceKey& k) const { return {m.nodes[at(k[0])], m.nodes[at(k[1])], m.nodes[at(k[2])]}; }

  /// Corners of the armature and of all that is joined to it: 1; joined to something else: 0; only within what
  /// stretches, or in the middle of an edge: -1.
  std::vector<int> bodies() const {
    std::vector<int> parent(m.nodes.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int v) {
      while (parent[at(v)] != v) v = parent[at(v)] = parent[at(parent[at(v)])];
      return v;
    };
    for (int c = 0; c < m.count(); ++c)
      if (!stretches(c))
        for (std::size_t k = 0; k < 3; ++k) parent[at(root(cell(c)[k]))] = root(cell(c)[k + 1]);
    std::set<int> moving;
    for (int c = 0; c < m.count(); ++c)
      if (part(c).role == DrawnRole::armature) moving.insert(root(cell(c)[0]));
    if (moving.empty()) throw std::invalid_argument("no part is the armature");
    std::set<std::string> fixed, between;
    std::vector<int> body(m.nodes.size(), -1);
    for (int c = 0; c < m.count(); ++c) {
      if (stretches(c)) continue;
      const bool moves = moving.count(root(cell(c)[0])) > 0;
      for (std::size_t k = 0; k < 4; ++k) body[at(cell(c)[k])] = moves ? 1 : 0;
      if (moves && part(c).role == DrawnRole::fixed) fixed.insert(part(c).name);
      if (moves && part(c).role == DrawnRole::air) between.insert(part(c).name);
    }
    if (fixed.empty()) return body;
    std::string air;
    for (const auto& name : between) air += (air.empty() ? " by '" : ", '") + name + "'";
    throw std::invalid_argument(
        "the armature is joined to the fixed iron '" + *fixed.begin() + "'" + air +
        ", and nothing between them stretches: a volume with role = \"stretch\" has to "
        "part them");
  }

  std::vector<double> run() const {
    auto body = bodies();
    std::map<FaceKey, std::pair<int, int>> sides;  // cells that stretch, others
    for (int c = 0; c < m.count(); ++c)
      for (std::size_t f = 0; f < 4; ++f) {
        auto& side = sides[key(c, f)];
        ++(stretches(c) ? side.first : side.second);
      }
    std::vector<Face3> still, moving;
    for (const auto& [k, side] : sides) {
      if (side.first != 1) continue;
      const Face3 face = place(k);
      if (side.second == 0) {
        if (plan_area(face) == 0) continue;  // slides
        for (const int v : k)
          if (body[at(v)] < 0) body[at(v)] = 0;
        still.push_back(face);
      } else {
        (std::all_of(k.begin(), k.end(), [&](int v) { return body[at(v)] == 1; }) ? moving : still)
            .push_back(face);
      }
    }
    if (moving.empty()) throw std::invalid_argument("nothing that stretches touches the armature");
    if (still.empty()) throw std::invalid_argument("what stretches touches nothing that stands still");
    const FaceTree zero(std::move(still)), one(std::move(moving));
    std::vector<double> out(m.nodes.size(), 0);
    std::vector<char> corner(m.nodes.size(), 0);
    for (int c = 0; c < m.count(); ++c)
      for (std::size_t k = 0; k < 4; ++k) corner[at(cell(c)[k])] = 1;
    for (std::size_t v = 0; v < out.size(); ++v) {
      if (corner[v] == 0) continue;
      if (body[v] >= 0) {
        out[v] = body[v];
        continue;
      }
      const double low = zero.nearest(m.nodes[v]), high = one.nearest(m.nodes[v]);
      out[v] = low / (low + high);
    }
    smooth(out, body);
    set_middles(m, out);
    return out;
  }

  /// Six times the volume of a cell as drawn, and how that grows with the rise of each corner. Exact, for the areas in
  /// plan stay.
  std::pair<double, std::array<double, 4>> rates(int c) const {
    std::array<Vec3, 4> x;
    for (std::size_t k = 0; k < 4; ++k) x[k] = m.nodes[at(cell(c)[k])];
    const double volume = space::six_volumes(x[0], x[1], x[2], x[3]);
    std::array<double, 4> rate{};
    for (std::size_t k = 0; k < 4; ++k) {
      auto raised = x;
      raised[k].z += 1;
      rate[k] = space::six_volumes(raised[0], raised[1], raised[2], raised[3]) - volume;
    }
    return {volume, rate};
  }

  /// As in the plane (drawn_motion): free corners are moved, cell by cell, until each keeps half of what an even
  /// stretch leaves of its volume in the closed magnet, and a tenth at the largest gap.
  void smooth(std::vector<double>& out, const std::vector<int>& body) const {
    const double closed = d.residual_gap, open = d.residual_gap + 1.5 * d.travel;
    constexpr int sweeps = 400;
    for (int sweep = 0, left = 1; sweep < sweeps && left > 0; ++sweep) {
      left = 0;
      for (int c = 0; c < m.count(); ++c) {
        if (!stretches(c)) continue;
        const auto [volume, rate] = rates(c);
        double growth = 0, square = 0;
        for (std::size_t k = 0; k < 4; ++k) {
          growth += rate[k] * out[at(cell(c)[k])];
          if (body[at(cell(c)[k])] < 0) square += rate[k] * rate[k];
        }
        double most = endless, least = -endless;
        if (closed < d.drawn_gap) most = volume * (1 - 0.5 * closed / d.drawn_gap) / (d.drawn_gap - closed);
        if (open > d.drawn_gap) least = -0.9 * volume / (open - d.drawn_gap);
        const double wanted = std::clamp(growth, least, most);
        if (wanted == growth || square == 0) continue;
        ++left;
        for (std::size_t k = 0; k < 4; ++k)
          if (const auto v = at(cell(c)[k]); body[v] < 0)
            out[v] = std::clamp(out[v] + 1.01 * (wanted - growth) / square * rate[k], 0.0, 1.0);
      }
    }
  }

  /// Outer faces of all parts of a role across z; iron that stretches counts with them.
  std::vector<Face3> outline(DrawnRole role) const {
    std::map<FaceKey, std::pair<int, int>> count;  // of the role, of stretching iron
    for (int c = 0; c < m.count(); ++c) {
      const bool mine = part(c).role == role, leg = stretches(c) && part(c).steel >= 0;
      if (!mine && !leg) continue;
      for (std::size_t f = 0; f < 4; ++f) {
        auto& n = count[key(c, f)];
        ++(mine ? n.first : n.second);
      }
    }
    std::vector<Face3> out;
    for (const auto& [k, n] : count)
      if (n.first == 1 && n.second == 0 && plan_area(place(k)) != 0) out.push_back(place(k));
    return out;
  }
};

/// z of a triangle at a place in plan; NaN where it does not pass there.
double height_at(const Face3& f, const Vec3& p) {
  const auto area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  };
  const double all = area(f[0], f[1], f[2]);
  if (std::fabs(all) < 1e-18) return std::nan("");
  double z = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double share = area(p, f[(k + 1) % 3], f[(k + 2) % 3]) / all;
    if (share < -1e-9) return std::nan("");
    z += share * f[k].z;
  }
  return z;
}

}  // namespace

std::vector<double> space_motion(const SpaceMagnet& d) {
  return SpaceMotion{d}.run();
}

double measured_gap(const SpaceMagnet& d) {
  const SpaceMotion motion{d};
  const auto upper = motion.outline(DrawnRole::armature), lower = motion.outline(DrawnRole::fixed);
  double least = endless;
  const auto measure = [&](double above, double below) {
    constexpr double touching = 1e-9;  // m
    if (above > below + touching) least = std::min(least, above - below);
  };
  for (const auto& u : upper)
    for (const auto& l : lower)
      for (std::size_t k = 0; k < 3; ++k) {
        measure(u[k].z, height_at(l, u[k]));
        measure(height_at(u, l[k]), l[k].z);
      }
  return least;
}

std::pair<double, double> usable_gaps(const SpaceMagnet& d) {
  const SpaceMotion motion{d};
  double from = 0, to = endless;
  for (int c = 0; c < d.mesh.count(); ++c) {
    if (!motion.stretches(c)) continue;
    const auto [volume, rate] = motion.rates(c);
    double growth = 0;
    for (std::size_t k = 0; k < 4; ++k) growth += rate[k] * d.motion[at(motion.cell(c)[k])];
    constexpr double least = 1e-4;  // of the volume as drawn: what is left of it
    if (std::fabs(growth) * d.travel < 1e-9 * volume) continue;
    const double end = d.drawn_gap - volume * (1 - (growth < 0 ? least : 0)) / growth;
    if (growth > 0) from = std::max(from, end);
    if (growth < 0) to = std::min(to, end);
  }
  return {from, to};
}

}  // namespace powbench::sim
