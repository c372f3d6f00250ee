#include "bench/space/team13.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/space/probe.h"
#include "sim/magnetics/space/grid.h"
#include "sim/magnetics/space/winding.h"

namespace powbench::bench {
namespace {

constexpr double mm = 1e-3;

/// Planes of the grid.
struct Lines {
  std::vector<double> x, y, z;

  Lines(double size, double gap) {
    const auto line = [&](std::vector<sim::space::GridMark> marks) {
      for (auto& m : marks) m = {m.at * mm, m.size * mm * size};
      return sim::space::graded_line(marks, 1 + 2 * std::min(size, 1.2), 400 * size * mm);
    };
    x = line({{0, 0.8},
              {1.6, 0.3},
              {1.6 + gap / mm, 0.25},
              {75, 20},
              {100, 20},
              {122.1, 2},
              {125.3, 2},
              {1500, 400}});
    y = line({{0, 12}, {15, 0.3}, {25, 0.3}, {65, 1.5}, {75, 20}, {100, 20}, {1500, 400}});
    const auto half = y;
    for (std::size_t k = 1; k < half.size(); ++k) y.insert(y.begin(), -half[k]);
    z = line({{0, 12}, {50, 8}, {60, 0.2}, {63.2, 0.2}, {1500, 400}});
  }
};

bool in_steel(const sim::Vec3& centre, double gap) {
  const double x = centre[0] / mm, y = centre[1] / mm, z = centre[2] / mm;
  const bool plate = x < 1.6 && std::fabs(y) < 25 && z < 63.2;
  const bool across = y > 15 && y < 65;
  const bool sheet = across && x > 1.6 + gap / mm && x < 125.3 && z > 60 && z < 63.2;
  const bool arm = across && x > 122.1 && x < 125.3 && z < 63.2;
  return plate || sheet || arm;
}

std::function<sim::Vec3(const sim::Vec3&)> coil() {
  return sim::space::coil_field({0, 0, 75 * mm, 75 * mm, 25 * mm, 25 * mm, -50 * mm, 50 * mm, 1});
}

}  // namespace

sim::space::Problem team13(double size, double gap) {
  const Lines lines(size, gap);
  enum { air, iron };
  sim::space::Problem p;
  p.mesh = sim::space::grid_mesh(lines.x, lines.y, lines.z, sim::space::Cell::hex20,
                                 [gap](const sim::Vec3& c) -> int { return in_steel(c, gap) ? iron : air; });
  p.media = {sim::space::air(), sim::space::solid(sim::builtin_steel("team13"))};
  p.windings = {coil()};
  p.copies = 4;
  std::map<std::pair<double, double>, int> on_plane;  // nodes at x = 0 by y, z
  for (std::size_t n = 0; n < p.mesh.nodes.size(); ++n) {
    const auto& at = p.mesh.nodes[n];
    p.tied.push_back(static_cast<int>(n));
    if (at[2] == 0) p.fixed.emplace_back(static_cast<int>(n), 0.0);
    if (at[0] == 0) on_plane[{at[1], at[2]}] = static_cast<int>(n);
  }
  for (const auto& [where, n] : on_plane)
    if (where.first < 0) p.tied[static_cast<std::size_t>(n)] = on_plane.at({-where.first, where.second});
  return p;
}

double team13_plate_average(const sim::space::Coenergy& function, const sim::space::State& state, double z) {
  const bench::Probe probe(function, state);
  constexpr int nx = 8, ny = 100;
  double sum = 0;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      sum += probe.at({1.6 * mm * (i + 0.5) / nx, 50 * mm * ((j + 0.5) / ny - 0.5), z}).b[2];
  return std::fabs(sum) / (nx * ny);
}

EdgeProblem team13_edges(double size, int order, double gap) {
  const Lines lines(size, gap);
  return {lines.x,
          lines.y,
          lines.z,
          [gap](const sim::Vec3& c) { return in_steel(c, gap); },
          sim::builtin_steel("team13"),
          coil(),
          4,
          order};
}

double team13_plate_average(const EdgeField& field, const EdgeSolution& s, double z) {
  return std::fabs(field.average(s, 0, 1.6 * mm, -25 * mm, 25 * mm, z));
}

}  // namespace powbench::bench
