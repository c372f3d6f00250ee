// How a drawn magnet moves: what rises with the armature, how the air between stretches, how far that goes.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "sim/magnetics/plane/drawn_magnet.h"

namespace powbench::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

/// Vertices joined by triangles that do not stretch.
class Joined {
 public:
  explicit Joined(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int v) {
    while (parent_[at(v)] != v) v = parent_[at(v)] = parent_[at(parent_[at(v)])];
    return v;
  }
  void join(int a, int b) { parent_[at(root(a))] = root(b); }

 private:
  std::vector<int> parent_;
};

using Edge = std::pair<int, int>;

struct Segment {
  double x0, y0, x1, y1;
};

double distance(const Segment& s, double x, double y) {
  const double dx = s.x1 - s.x0, dy = s.y1 - s.y0, square = dx * dx + dy * dy;
  const double t = square > 0 ? std::clamp(((x - s.x0) * dx + (y - s.y0) * dy) / square, 0.0, 1.0) : 0;
  return std::hypot(s.x0 + t * dx - x, s.y0 + t * dy - y);
}

double nearest(const std::vector<Segment>& list, double x, double y) {
  double least = infinity;
  for (const auto& s : list) least = std::min(least, distance(s, x, y));
  return least;
}

struct Motion {
  const DrawnMagnet& d;
  const Mesh& m = d.mesh;

  DrawnRole role(std::size_t t) const { return d.parts[at(m.region[t])].role; }
  bool stretches(std::size_t t) const { return role(t) == DrawnRole::stretch; }
  Segment segment(const Edge& e) const {
    return {m.x[at(e.first)], m.y[at(e.first)], m.x[at(e.second)], m.y[at(e.second)]};
  }

  /// Vertices of the armature and all that is joined to it: 1; joined to something else: 0; only within air that
  /// stretches: -1.
  std::vector<int> bodies() const {
    Joined joined(m.x.size());
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      if (!stretches(t))
        for (std::size_t k = 0; k < 2; ++k) joined.join(m.triangle[t][k], m.triangle[t][k + 1]);
    std::set<int> moving;
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      if (role(t) == DrawnRole::armature) moving.insert(joined.root(m.triangle[t][0]));
    if (moving.empty()) throw std::invalid_argument("no part is the armature");
    refuse_joined(joined, moving);
    std::vector<int> body(m.x.size(), -1);
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      if (!stretches(t))
        for (const int v : m.triangle[t]) body[at(v)] = moving.count(joined.root(v)) > 0 ? 1 : 0;
    return body;
  }

  void refuse_joined(Joined& joined, const std::set<int>& moving) const {
    std::set<std::string> fixed, between;
    for (std::size_t t = 0; t < m.triangle.size(); ++t) {
      if (stretches(t) || moving.count(joined.root(m.triangle[t][0])) == 0) continue;
      if (role(t) == DrawnRole::fixed) fixed.insert(d.parts[at(m.region[t])].name);
      if (role(t) == DrawnRole::air) between.insert(d.parts[at(m.region[t])].name);
    }
    if (fixed.empty()) return;
    std::string air;
    for (const auto& name : between) air += (air.empty() ? " by '" : ", '") + name + "'";
    throw std::invalid_argument(
        "the armature is joined to the fixed iron '" + *fixed.begin() + "'" + air +
        ", and nothing between them stretches: air with role = \"stretch\" has to part them");
  }

  std::vector<double> run() const {
    auto body = bodies();
    std::map<Edge, std::pair<int, int>> sides;  // triangles that stretch, others
    bool any = false;
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        auto& side = sides[std::minmax(m.triangle[t][k], m.triangle[t][(k + 1) % 3])];
        ++(stretches(t) ? side.first : side.second);
        any = any || stretches(t);
      }
    if (!any) throw std::invalid_argument("no part stretches: the armature cannot move");
    std::vector<Segment> still, moving;
    for (const auto& [edge, side] : sides) {
      if (side.first != 1) continue;
      const Segment s = segment(edge);
      if (side.second == 0) {
        const bool along = std::fabs(s.x1 - s.x0) <= 1e-6 * std::fabs(s.y1 - s.y0);
        if (along) continue;
        for (const int v : {edge.first, edge.second})
          if (body[at(v)] < 0) body[at(v)] = 0;
        still.push_back(s);
      } else {
        (body[at(edge.first)] == 1 ? moving : still).push_back(s);
      }
    }
    if (still.empty() || moving.empty())
      throw std::invalid_argument(moving.empty()
                                      ? "no air that stretches touches the armature"
                                      : "the air that stretches touches nothing that stands still");
    std::vector<double> out(m.x.size(), 0);
    for (std::size_t v = 0; v < out.size(); ++v) {
      if (body[v] >= 0) {
        out[v] = body[v];
        continue;
      }
      const double zero = nearest(still, m.x[v], m.y[v]), one = nearest(moving, m.x[v], m.y[v]);
      out[v] = zero / (zero + one);
    }
    smooth(out, body);
    if (d.copies == 4)
      for (double& value : out) value *= 0.5;
    return out;
  }

  /// Between vertices m is linear, and on crooked triangles may rise faster than it does itself. There the free
  /// vertices are moved, triangle by triangle, until each keeps half of what an even stretch leaves of its area in
  /// the closed magnet, and a tenth at the largest gap; what is left of this is for usable_gaps to find.
  void smooth(std::vector<double>& out, const std::vector<int>& body) const {
    const double share = d.copies == 4 ? 0.5 : 1, closed = d.residual_gap,
                 open = d.residual_gap + 1.5 * d.travel;
    constexpr int sweeps = 400;
    for (int sweep = 0, left = 1; sweep < sweeps && left > 0; ++sweep) {
      left = 0;
      for (std::size_t t = 0; t < m.triangle.size(); ++t) {
        if (!stretches(t)) continue;
        const auto& v = m.triangle[t];
        const double area = twice_area(m, v);
        double growth = 0, square = 0;
        std::array<double, 3> rate{};
        for (std::size_t k = 0; k < 3; ++k) {
          rate[k] = share * (m.x[at(v[(k + 2) % 3])] - m.x[at(v[(k + 1) % 3])]);
          growth += rate[k] * out[at(v[k])];
          if (body[at(v[k])] < 0) square += rate[k] * rate[k];
        }
        double most = infinity, least = -infinity;
        if (closed < d.drawn_gap) most = area * (1 - 0.5 * closed / d.drawn_gap) / (d.drawn_gap - closed);
        if (open > d.drawn_gap) least = -0.9 * area / (open - d.drawn_gap);
        const double wanted = std::clamp(growth, least, most);
        if (wanted == growth || square == 0) continue;
        ++left;
        for (std::size_t k = 0; k < 3; ++k)
          if (double& value = out[at(v[k])]; body[at(v[k])] < 0)
            value = std::clamp(value + 1.01 * (wanted - growth) / square * rate[k], 0.0, 1.0);
      }
    }
  }
};

/// Twice the area of triangle `t` as drawn, and how it grows with each m of gap: exact, for all moves are along y.
std::pair<double, double> areas(const DrawnMagnet& d, std::size_t t) {
  const auto& v = d.mesh.triangle[t];
  const auto &x = d.mesh.x, &m = d.motion;
  const auto a = at(v[0]), b = at(v[1]), c = at(v[2]);
  return {twice_area(d.mesh, v), (x[b] - x[a]) * (m[c] - m[a]) - (x[c] - x[a]) * (m[b] - m[a])};
}

/// y of an edge at x, or NaN where it does not pass there.
double height_at(const Segment& s, double x) {
  const double low = std::min(s.x0, s.x1), high = std::max(s.x0, s.x1);
  if (!(high > low) || x < low || x > high) return std::nan("");
  return s.y0 + (s.y1 - s.y0) * (x - s.x0) / (s.x1 - s.x0);
}

/// Outline of all parts of one role.
std::vector<Segment> outline(const DrawnMagnet& d, DrawnRole role) {
  std::map<Edge, int> count;
  const Motion motion{d};
  for (std::size_t t = 0; t < d.mesh.triangle.size(); ++t)
    if (motion.role(t) == role)
      for (std::size_t k = 0; k < 3; ++k)
        ++count[std::minmax(d.mesh.triangle[t][k], d.mesh.triangle[t][(k + 1) % 3])];
  std::vector<Segment> out;
  for (const auto& [edge, n] : count)
    if (n == 1) out.push_back(motion.segment(edge));
  return out;
}

}  // namespace

std::vector<double> drawn_motion(const DrawnMagnet& d) {
  return Motion{d}.run();
}

double measured_gap(const DrawnMagnet& d) {
  const auto upper = outline(d, DrawnRole::armature);
  auto lower = outline(d, DrawnRole::fixed);
  if (d.copies == 4) {
    const auto [x0, x1] = std::minmax_element(d.mesh.x.begin(), d.mesh.x.end());
    const double floor = *std::min_element(d.mesh.y.begin(), d.mesh.y.end());
    lower = {{*x0, floor, *x1, floor}};
  }
  double least = infinity;
  const auto measure = [&](double above, double below) {
    if (above > below) least = std::min(least, above - below);
  };
  for (const auto& u : upper)
    for (const auto& l : lower) {
      measure(u.y0, height_at(l, u.x0));
      measure(u.y1, height_at(l, u.x1));
      measure(height_at(u, l.x0), l.y0);
      measure(height_at(u, l.x1), l.y1);
    }
  return d.copies == 4 ? 2 * least : least;
}

std::pair<double, double> usable_gaps(const DrawnMagnet& d) {
  double from = 0, to = infinity;
  for (std::size_t t = 0; t < d.mesh.triangle.size(); ++t) {
    const auto [area, growth] = areas(d, t);
    constexpr double least = 1e-4;  // of the area as drawn: what is left of it
    if (growth == 0) continue;
    const double end = d.drawn_gap - area * (1 - (growth < 0 ? least : 0)) / growth;
    if (growth > 0) from = std::max(from, end);
    if (growth < 0) to = std::min(to, end);
  }
  return {from, to};
}

namespace {

/// Smallest angle of a triangle, rad, with the vertices at these heights.
template <class Height>
double smallest_angle(const Mesh& m, std::size_t t, const Height& y) {
  double least = infinity;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = at(m.triangle[t][k]), b = at(m.triangle[t][(k + 1) % 3]),
               c = at(m.triangle[t][(k + 2) % 3]);
    const double ux = m.x[b] - m.x[a], uy = y(b) - y(a), vx = m.x[c] - m.x[a], vy = y(c) - y(a);
    least = std::min(least, std::atan2(ux * vy - uy * vx, ux * vx + uy * vy));
  }
  return least;
}

}  // namespace

double least_angle(const DrawnMagnet& d, double face_gap) {
  const Motion motion{d};
  const auto y = [&](std::size_t v) { return d.mesh.y[v] + (face_gap - d.drawn_gap) * d.motion[v]; };
  double least = infinity;
  for (std::size_t t = 0; t < d.mesh.triangle.size(); ++t)
    if (motion.stretches(t)) least = std::min(least, smallest_angle(d.mesh, t, y));
  return least;
}

SharpTriangle sharpest_triangle(const DrawnMagnet& d) {
  const Motion motion{d};
  const auto& m = d.mesh;
  SharpTriangle out{infinity, 0, 0, 0};
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const double angle =
        motion.stretches(t) ? infinity : smallest_angle(m, t, [&](std::size_t v) { return m.y[v]; });
    if (angle >= out.angle) continue;
    out = {angle, m.region[t], 0, 0};
    for (const int v : m.triangle[t]) {
      out.x += m.x[at(v)] / 3;
      out.y += m.y[at(v)] / 3;
    }
  }
  return out;
}

double air_around(const DrawnMagnet& d) {
  const auto& m = d.mesh;
  double low_x = infinity, high_x = -infinity, low_y = infinity, high_y = -infinity;
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const auto role = d.parts[at(m.region[t])].role;
    if (role == DrawnRole::air || role == DrawnRole::stretch) continue;
    for (const int v : m.triangle[t]) {
      low_x = std::min(low_x, m.x[at(v)]), high_x = std::max(high_x, m.x[at(v)]);
      low_y = std::min(low_y, m.y[at(v)]), high_y = std::max(high_y, m.y[at(v)]);
    }
  }
  const auto [x0, x1] = std::minmax_element(m.x.begin(), m.x.end());
  const auto [y0, y1] = std::minmax_element(m.y.begin(), m.y.end());
  const bool mirrored = d.axisymmetric || d.copies > 1;  // at a line along the motion, on one side
  const double left = low_x - *x0, right = *x1 - high_x;
  double least = std::min(mirrored ? std::max(left, right) : std::min(left, right), *y1 - high_y);
  if (d.copies < 4) least = std::min(least, low_y - *y0);
  const double width = (mirrored ? 2 : 1) * (high_x - low_x),
               height = (d.copies == 4 ? 2 : 1) * (high_y - low_y);
  return least / std::max(width, height);
}

}  // namespace powbench::sim
