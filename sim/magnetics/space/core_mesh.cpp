#include "sim/magnetics/space/core_mesh.h"

#include <algorithm>
#include <cmath>

#include "sim/magnetics/plane/core_outline.h"
#include "sim/magnetics/space/grid.h"
#include "sim/magnetics/space/winding.h"

namespace powbench::sim::space {
namespace {

/// Edges of the core in the quarter, m.
struct Outline : CoreOutline {
  double y1;  ///< half of the stack
  double coil_y1, coil_y2, ring_y2;

  Outline(const MagnetShape& s, double gap)
      : CoreOutline(s, gap),
        y1(s.stack / 2),
        coil_y1(y1 + coil_left - x1),
        coil_y2(coil_y1 + s.coil_width),
        ring_y2(y1 + s.ring_slot) {}

  int region(const Vec3& p) const {
    const auto [x, y, z] = p;
    if (z > 0 && z < face)
      return closed_leg && x > x2 && x < x3 && y < y1 ? CoreRegion::iron : CoreRegion::strip;
    if (x < 0) return -x < x1 ? region({-x, y, z}) : CoreRegion::air;  // of two legs
    if (x > x3 || y > y1 || z < yoke_bottom || z > yoke_top) return CoreRegion::air;
    if (z > face) return x > x1 && x < x2 && z < window_top ? CoreRegion::air : CoreRegion::iron;
    if (ring && z > ring_bottom && x > slot_left && x < slot_right) return CoreRegion::air;
    if (x > x1 && x < x2 && z > window_bottom) return CoreRegion::air;
    if (x < x1 && z > centre_face) return CoreRegion::air;
    return CoreRegion::iron;
  }

  /// Share of the ring's flux that is inside of its turn at (x, y): 1 in the leg, falling across the conductor.
  double inside_ring(double x, double y) const {
    const double left = (x2 - x) / (x2 - ring_left), right = (x - slot_left) / (slot_right - slot_left);
    const double head = (std::fabs(y) - y1) / (ring_y2 - y1);
    return std::clamp(1 - std::max({left, right, head}), 0.0, 1.0);
  }
};

/// Sorted marks; those closer than a micrometre become one with the smaller size.
std::vector<GridMark> merged(std::vector<GridMark> marks) {
  constexpr double least = 1e-6;
  std::sort(marks.begin(), marks.end(), [](const GridMark& a, const GridMark& b) { return a.at < b.at; });
  std::vector<GridMark> kept;
  for (const auto& m : marks) {
    if (!kept.empty() && m.at - kept.back().at < least)
      kept.back().size = std::min(kept.back().size, m.size);
    else
      kept.push_back(m);
  }
  return kept;
}

/// Lines of the core and, from both ends or only the upper one, cells that grow into the air.
std::vector<double> with_air(const std::vector<GridMark>& core, bool below, double reach,
                             const CoreMeshSizes& z) {
  auto lines = graded_line(core, z.growth, z.largest);
  const double top = lines.back(), bottom = lines.front();
  const auto above = graded_line({{top, core.back().size}, {top + reach, z.far}}, z.growth, z.far);
  lines.insert(lines.end(), above.begin() + 1, above.end());
  if (below) {
    const auto under = graded_line({{bottom - reach, z.far}, {bottom, core.front().size}}, z.growth, z.far);
    lines.insert(lines.begin(), under.begin(), under.end() - 1);
  }
  return lines;
}

std::vector<double> x_lines(const Outline& o, const CoreMeshSizes& s) {
  std::vector<GridMark> marks{
      {o.x1, s.corner}, {o.coil_left, s.other}, {o.coil_right, s.other}, {o.x2, s.corner}, {o.x3, s.corner}};
  if (o.half)
    marks.push_back({0, s.largest});
  else
    marks.insert(marks.end(), {{-o.x1, s.corner}, {-o.coil_left, s.other}, {-o.coil_right, s.other}});
  if (o.ring)
    for (const auto& m :
         {GridMark{o.ring_left, s.other}, GridMark{o.slot_left, s.corner}, GridMark{o.slot_right, s.corner}})
      marks.push_back(m);
  return with_air(merged(marks), !o.half, 4 * o.x3, s);
}

std::vector<double> y_lines(const Outline& o, const CoreMeshSizes& s) {
  if (!s.ends) return {0, o.y1};
  std::vector<GridMark> marks{{0, s.largest}, {o.y1, s.corner}, {o.coil_y1, s.other}, {o.coil_y2, s.other}};
  if (o.ring) marks.push_back({o.ring_y2, s.other});
  return with_air(merged(marks), false, 4 * o.x3, s);
}

std::vector<double> z_lines(const Outline& o, const CoreMeshSizes& s) {
  std::vector<GridMark> below{{o.yoke_bottom, s.other}, {o.window_bottom, s.other}, {o.coil_bottom, s.other},
                              {o.coil_top, s.other},    {o.centre_face, s.corner},  {0, s.corner}};
  if (o.ring) below.push_back({o.ring_bottom, s.other});
  std::vector<GridMark> above{{o.face, s.corner}, {o.window_top, s.other}, {o.yoke_top, s.other}};
  const double reach = 3 * o.x3;
  auto lines = graded_line(merged(below), s.growth, s.largest);
  const double bottom = lines.front();
  const auto under = graded_line({{bottom - reach, s.far}, {bottom, s.other}}, s.growth, s.far);
  lines.insert(lines.begin(), under.begin(), under.end() - 1);
  for (int k = 1; k < s.layers; ++k) lines.push_back(o.face * k / s.layers);
  const auto upper = with_air(merged(above), false, reach, s);
  lines.insert(lines.end(), upper.begin(), upper.end());
  return lines;
}

}  // namespace

CoreMeshSizes CoreMeshSizes::scaled(double factor) const {
  CoreMeshSizes s = *this;
  for (double* size : {&s.corner, &s.other, &s.largest, &s.far}) *size *= factor;
  s.growth = 1 + (growth - 1) * std::min(1.5, factor);
  s.layers =
      std::max(2, static_cast<int>(std::lround(layers / factor)));  // two: one of them is not the whole
  return s;
}

Problem core_problem(const MagnetDesign& design, const CoreMeshSizes& sizes, double gap) {
  check_shape(design.shape);
  const Outline o(design.shape, gap);
  Problem p;
  p.mesh = grid_mesh(x_lines(o, sizes), y_lines(o, sizes), z_lines(o, sizes), Cell::hex20,
                     [&](const Vec3& c) { return o.region(c); });
  p.media = {air(), air(), laminated(design.steel, design.shape.stack_factor, 1)};
  p.windings = {coil_field({0, 0, o.coil_left, o.coil_y1, 0, o.coil_right - o.coil_left, o.coil_bottom,
                            o.coil_top, design.turns})};
  if (o.ring)
    p.windings.push_back([o](const Vec3& at) -> Vec3 {
      if (at[2] < o.ring_bottom || at[2] > 0) return {};
      return {0, 0,
              o.inside_ring(at[0], at[1]) / o.ring_bottom};  // downwards: the outer legs carry the flux back
    });
  p.copies = o.half ? 4 : 2;
  if (!sizes.ends) {
    p.series = {design.end_leakage};
    if (o.ring) p.series.push_back(design.ring_leakage);
  }
  return p;
}

std::vector<double> core_motion(const Mesh& mesh, double gap) {
  std::vector<double> weight;
  for (const auto& n : mesh.nodes) weight.push_back(std::clamp(n[2] / gap, 0.0, 1.0));
  return weight;
}

std::vector<double> core_layer(const Mesh& mesh, const CoreMeshSizes& sizes, double gap) {
  const int below = (sizes.layers - 1) / 2;
  std::vector<double> weight;
  for (const auto& n : mesh.nodes) {
    const double layer = n[2] / gap * sizes.layers - below;
    weight.push_back(layer < 1e-6 ? 0 : layer > 1 - 1e-6 ? 1 : layer);
  }
  return weight;
}

}  // namespace powbench::sim::space
