#include "sim/magnetics/plane/core_mesh.h"

#include <algorithm>
#include <cmath>

#include "sim/magnetics/plane/core_outline.h"
#include "sim/magnetics/plane/grid.h"

namespace powbench::sim {
namespace {

struct Outline : CoreOutline {
  explicit Outline(const MagnetShape& s) : CoreOutline(s, strip_height) {}

  int region(double x, double y) const {
    if (x < 0) return left_region(-x, y);
    if (y > 0 && y < face) return closed_leg && x > x2 && x < x3 ? CoreRegion::strip_iron : CoreRegion::strip;
    if (x < x3 && y > face && y < yoke_top) {
      const bool window = x > x1 && x < x2 && y < window_top;
      return window ? CoreRegion::air : CoreRegion::moving_iron;
    }
    if (x > x3 || y > 0 || y < yoke_bottom) return CoreRegion::air;
    if (ring && y > ring_bottom && x > ring_left && x < x2) return CoreRegion::ring_inner;
    if (ring && y > ring_bottom && x > slot_left && x < slot_right) return CoreRegion::ring_outer;
    if (x > coil_left && x < coil_right && y > coil_bottom && y < coil_top) return CoreRegion::coil;
    if (x > x1 && x < x2 && y > window_bottom) return CoreRegion::air;
    if (x < x1 && y > centre_face) return CoreRegion::air;
    return CoreRegion::fixed_iron;
  }

  /// Of two legs: the other half of the centre leg, and the coil around it. x > 0 to the left.
  int left_region(double x, double y) const {
    if (x < x1) return region(x, y);
    if (x > coil_left && x < coil_right && y > coil_bottom && y < coil_top) return CoreRegion::coil_back;
    return y > 0 && y < face ? CoreRegion::strip : CoreRegion::air;
  }
};

/// Sorted stops; those closer than a micrometre become one with the smaller size.
std::vector<GridStop> merged(std::vector<GridStop> stops) {
  constexpr double least = 1e-6;
  std::sort(stops.begin(), stops.end(), [](const GridStop& a, const GridStop& b) { return a.at < b.at; });
  std::vector<GridStop> kept;
  for (const auto& s : stops) {
    if (!kept.empty() && s.at - kept.back().at < least) {
      auto& size = kept.back().size;
      if (s.size > 0) size = size > 0 ? std::min(size, s.size) : s.size;
      continue;
    }
    kept.push_back(s);
  }
  return kept;
}

/// Continues the lines of the core into the air, from cells of `size` at its outline.
void append_far(std::vector<double>& lines, double from, double to, double size, const CoreMeshSizes& z) {
  const bool up = to > from;
  const GridStop core{from, size}, end{to, 0};
  const auto far = graded_lines({up ? core : end, up ? end : core}, z.growth, z.far);
  if (up)
    lines.insert(lines.end(), far.begin() + 1, far.end());
  else
    lines.insert(lines.begin(), far.begin(), far.end() - 1);
}

std::vector<double> x_lines(const Outline& o, const CoreMeshSizes& z) {
  std::vector<GridStop> stops{
      {o.coil_left, z.other}, {o.coil_right, z.other}, {o.x1, z.corner}, {o.x2, z.corner}, {o.x3, z.corner}};
  if (o.half)
    stops.push_back({0, 0});
  else
    stops.insert(stops.end(), {{-o.x1, z.corner}, {-o.coil_left, z.other}, {-o.coil_right, z.other}});
  if (o.ring) {
    stops.push_back({o.ring_left, z.other});
    stops.push_back({o.slot_left, z.corner});
    stops.push_back({o.slot_right, z.corner});
  }
  auto lines = graded_lines(merged(stops), z.growth, z.iron);
  append_far(lines, o.x3, 5.5 * o.x3, z.corner, z);
  if (!o.half) append_far(lines, -o.coil_right, -5.5 * o.x3, z.other, z);
  return lines;
}

std::vector<double> y_lines(const Outline& o, const CoreMeshSizes& z, double largest_gap) {
  std::vector<GridStop> below{{o.yoke_bottom, z.other}, {o.window_bottom, z.other}, {o.coil_bottom, z.other},
                              {o.coil_top, z.other},    {o.centre_face, z.corner},  {0, z.corner}};
  if (o.ring) below.push_back({o.ring_bottom, z.other});
  auto lines = graded_lines(merged(below), z.growth, z.iron);
  lines.pop_back();
  for (const double share : strip_layers(z, largest_gap)) lines.push_back(share * strip_height);
  const auto above = graded_lines(
      merged({{o.face, z.corner}, {o.window_top, z.other}, {o.yoke_top, z.other}}), z.growth, z.iron);
  lines.insert(lines.end(), above.begin() + 1, above.end());
  const double reach = 3.9 * o.x3;
  append_far(lines, o.yoke_bottom, o.yoke_bottom - reach, z.other, z);
  append_far(lines, o.yoke_top, o.yoke_top + reach, z.other, z);
  return lines;
}

}  // namespace

CoreMeshSizes CoreMeshSizes::scaled(double factor) const {
  return {corner * factor, other * factor, iron * factor, far * factor,
          1 + (growth - 1) * std::min(1.0, factor)};
}

std::vector<double> strip_layers(const CoreMeshSizes& z, double largest_gap) {
  auto lines =
      graded_lines({{0, z.corner}, {std::max(largest_gap, 4 * z.corner), z.corner}}, z.growth, z.iron);
  const double height = lines.back();
  for (double& line : lines) line /= height;
  return lines;
}

Mesh core_mesh(const MagnetShape& shape, const CoreMeshSizes& sizes, double largest_gap) {
  check_shape(shape);
  const Outline o(shape);
  return tensor_mesh(x_lines(o, sizes), y_lines(o, sizes, largest_gap),
                     [&](double x, double y) { return o.region(x, y); }, {});
}

}  // namespace powbench::sim
