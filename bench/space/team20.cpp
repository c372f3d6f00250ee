#include "bench/space/team20.h"

#include <algorithm>
#include <cmath>

#include "sim/magnetics/space/grid.h"
#include "sim/magnetics/space/winding.h"

namespace powbench::bench {
namespace {

constexpr double mm = 1e-3;

/// 1 inside the box |x| <= half, low <= z <= high, falling to 0 over the distances of the air around it.
double box_weight(const sim::Vec3& p, const sim::Vec3& half, double low, double high, const sim::Vec3& fall,
                  double below, double above) {
  const auto ramp = [](double excess, double over) {
    return std::clamp(1 - excess / over * (1 + 1e-9), 0.0, 1.0);
  };
  const double z = p[2] < low ? ramp(low - p[2], below) : ramp(p[2] - high, above);
  return ramp(std::fabs(p[0]) - half[0], fall[0]) * ramp(std::fabs(p[1]) - half[1], fall[1]) * z;
}

}  // namespace

Team20 team20(double size, sim::space::Cell cell) {
  const auto line = [&](std::vector<sim::space::GridMark> marks, double largest) {
    for (auto& m : marks) m = {m.at * mm, m.size * mm * size};
    return sim::space::graded_line(marks, 1 + 0.9 * std::min(size, 1.5), largest * size * mm);
  };
  const auto x =
      line({{0, 4}, {12.5, 0.5}, {13.5, 0.5}, {19.5, 3}, {37.5, 3}, {38.5, 1}, {63.5, 4}, {250, 60}}, 60);
  const auto y = line({{0, 2}, {5, 0.6}, {12.5, 1.5}, {19.5, 3}, {37.5, 6}, {250, 60}}, 60);
  const auto z = line(
      {{-150, 60}, {0, 5}, {25, 0.5}, {26.5, 0.4}, {26.7, 0.4}, {123.3, 1}, {125, 0.5}, {150, 4}, {300, 60}},
      60);
  enum { air, iron };
  Team20 out;
  auto& p = out.problem;
  p.mesh = sim::space::grid_mesh(x, y, z, cell, [](const sim::Vec3& c) -> int {
    const double cx = c[0] / mm, cy = c[1] / mm, cz = c[2] / mm;
    const bool pole = cx < 12.5 && cy < 5 && cz > 26.5 && cz < 125;
    const bool yoke = cx < 63.5 && cy < 12.5 && cz > 0 && cz < 150 && !(cx < 38.5 && cz > 25 && cz < 125) &&
                      !(cx < 13.5 && cz > 125);
    return pole || yoke ? iron : air;
  });
  p.media = {sim::space::air(), sim::space::solid(sim::builtin_steel("team20"))};
  p.windings = {
      sim::space::coil_field({0, 0, 19.5 * mm, 19.5 * mm, 5 * mm, 18 * mm, 26.7 * mm, 123.3 * mm, 1})};
  p.copies = 4;
  const auto cell_at = [](const std::vector<double>& l, double at) {
    return *std::upper_bound(l.begin(), l.end(), at * mm + 1e-9) - at * mm;
  };
  const auto cell_below = [](const std::vector<double>& l, double at) {
    return at * mm - *(std::lower_bound(l.begin(), l.end(), at * mm - 1e-9) - 1);
  };
  const sim::Vec3 half{12.5 * mm, 5 * mm, 0};
  for (const auto& n : p.mesh.nodes) {
    out.virtual_work.push_back(
        box_weight(n, half, 26.5 * mm, 125 * mm, {1 * mm, 7.5 * mm, 0}, 1.5 * mm, 25 * mm));
    out.thin.push_back(box_weight(n, half, 26.5 * mm, 125 * mm, {cell_at(x, 12.5), cell_at(y, 5), 0},
                                  cell_below(z, 26.5), cell_at(z, 125)));
  }
  return out;
}

}  // namespace powbench::bench
