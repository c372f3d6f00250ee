#include "host/export/space_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "host/export/field_frame.h"

namespace powbench::host {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

struct Corner {
  double x, y;
};

struct Extent {
  double low = infinite, high = -infinite;
  void take(double v) { low = std::min(low, v), high = std::max(high, v); }
};

/// One section: a plane where coordinate `normal` is `place`.
class Section {
 public:
  Section(const sim::SpaceMagnet& magnet, const sim::space::Mesh& mesh, std::size_t normal)
      : magnet_(magnet), mesh_(mesh), normal_(normal) {
    Extent all, winding;
    for (int c = 0; c < mesh.count(); ++c)
      for (std::size_t k = 0; k < 4; ++k) {
        const double v = corner(c, k)[normal];
        all.take(v);
        if (part(c).role == sim::DrawnRole::coil) winding.take(v);
      }
    // not through the nodes: a plane of symmetry is made of faces
    const double aside = 1e-5 * (all.high - all.low);
    place_ = 0.5 * (winding.low + winding.high);
    if (winding.low <= all.low + aside) place_ = all.low;
    if (winding.high >= all.high - aside) place_ = all.high;
    place_ += place_ == all.high ? -aside : aside;
    for (int c = 0; c < mesh.count(); ++c) cut(c);
  }

  double iron() const { return iron_; }  ///< m2

  FieldDrawing drawing(const std::vector<double>& b) const {
    FieldDrawing d;
    Extent across, up;
    for (const Polygon& p : polygons_)
      if (shown(p.cell))
        for (const Corner& q : p.corners) across.take(q.x), up.take(q.y);
    d.left = across.low, d.right = across.high, d.bottom = up.low, d.top = up.high;
    for (const Polygon& p : polygons_) {
      auto& path = d.fills[field_shade(b[static_cast<std::size_t>(p.cell)])];
      for (std::size_t k = 0; k < p.corners.size(); ++k)
        path += fmt::format("{}{}", k == 0 ? 'M' : 'L', text(p.corners[k]));
      path += 'Z';
    }
    for (const auto& [face, side] : sides_) {
      const bool edge = side.cells.size() == 1 ? shown(side.cells[0]) : outlined(side.cells);
      if (edge) d.outlines += fmt::format("M{}L{}", text(side.from), text(side.to));
    }
    return d;
  }

 private:
  struct Polygon {
    int cell;
    std::vector<Corner> corners;
  };
  /// The cut through one face of a tetrahedron.
  struct Side {
    Corner from, to;
    std::vector<int> cells;
  };

  const sim::SpacePart& part(int cell) const {
    return magnet_.parts[static_cast<std::size_t>(mesh_.region[static_cast<std::size_t>(cell)])];
  }
  bool shown(int cell) const {
    const auto& p = part(cell);
    return p.steel >= 0 || p.role == sim::DrawnRole::coil || p.role == sim::DrawnRole::ring;
  }
  bool outlined(const std::vector<int>& cells) const {
    return (shown(cells[0]) || shown(cells[1])) && &part(cells[0]) != &part(cells[1]);
  }
  int node(int cell, std::size_t k) const {
    return mesh_.cells[static_cast<std::size_t>(cell * mesh_.per_cell()) + k];
  }
  const sim::Vec3& corner(int cell, std::size_t k) const {
    return mesh_.nodes[static_cast<std::size_t>(node(cell, k))];
  }
  static std::string text(const Corner& p) {
    return fmt::format("{:.1f} {:.1f}", p.x * field_pixels, -p.y * field_pixels);
  }

  Corner between(int cell, std::size_t i, std::size_t j) const {
    const sim::Vec3 &a = corner(cell, i), &b = corner(cell, j);
    const double s = (place_ - a[normal_]) / (b[normal_] - a[normal_]);
    const std::size_t along = 1 - normal_;
    return {a[along] + s * (b[along] - a[along]), a[2] + s * (b[2] - a[2])};
  }

  void cut(int cell) {
    std::vector<std::size_t> low, high;
    for (std::size_t k = 0; k < 4; ++k) (corner(cell, k)[normal_] < place_ ? low : high).push_back(k);
    if (low.empty() || high.empty()) return;
    using Edge = std::array<std::size_t, 2>;
    std::vector<Edge> edges;  // in turn around the polygon
    if (low.size() == 2) {
      edges = {{low[0], high[0]}, {low[0], high[1]}, {low[1], high[1]}, {low[1], high[0]}};
    } else {
      const bool one = low.size() == 1;
      const std::size_t tip = one ? low[0] : high[0];
      for (const std::size_t k : one ? high : low) edges.push_back({tip, k});
    }
    Polygon p{cell, {}};
    for (const Edge& e : edges) p.corners.push_back(between(cell, e[0], e[1]));
    double twice = 0;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const std::size_t next = (k + 1) % edges.size();
      twice += p.corners[k].x * p.corners[next].y - p.corners[next].x * p.corners[k].y;
      add_side(cell, {edges[k][0], edges[k][1], edges[next][0], edges[next][1]}, p.corners[k],
               p.corners[next]);
    }
    if (part(cell).steel >= 0) iron_ += 0.5 * std::fabs(twice);
    polygons_.push_back(std::move(p));
  }

  /// Two edges of a tetrahedron that share a corner lie in one of its faces.
  void add_side(int cell, std::array<std::size_t, 4> corners, Corner from, Corner to) {
    std::array<int, 4> nodes{};
    for (std::size_t k = 0; k < 4; ++k) nodes[k] = node(cell, corners[k]);
    std::sort(nodes.begin(), nodes.end());
    std::array<int, 3> face{};
    std::unique_copy(nodes.begin(), nodes.end(), face.begin());
    auto& side = sides_[face];
    side.from = from, side.to = to;
    side.cells.push_back(cell);
  }

  const sim::SpaceMagnet& magnet_;
  const sim::space::Mesh& mesh_;
  std::size_t normal_;
  double place_ = 0, iron_ = 0;
  std::vector<Polygon> polygons_;
  std::map<std::array<int, 3>, Side> sides_;
};

}  // namespace

std::string space_svg(const sim::SpaceMagnet& magnet, const sim::space::Mesh& mesh,
                      const std::vector<double>& b, const std::string& title) {
  const Section across_x(magnet, mesh, 0), across_y(magnet, mesh, 1);
  const Section& best = across_x.iron() > across_y.iron() ? across_x : across_y;
  return framed_field(best.drawing(b), title);
}

}  // namespace powbench::host
