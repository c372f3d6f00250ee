#include "sim/magnetics/space/force.h"

#include <array>

namespace powbench::sim::space {
namespace {

std::size_t nth(int a) {
  return static_cast<std::size_t>(a);
}

/// Integration points of the cells in which a weight varies.
template <class Visit>
void for_varying_points(const Coenergy& function, const std::vector<double>& weight, const Visit& visit) {
  const auto& problem = function.problem();
  const auto& mesh = problem.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes;
  std::array<Vec3, 27> gradient;
  for (int c = 0; c < mesh.count(); ++c) {
    const int* cell = mesh.cells.data() + static_cast<std::ptrdiff_t>(c) * per;
    const double first = weight[nth(cell[0])];
    bool varies = false;
    for (int a = 1; a < per; ++a) varies = varies || weight[nth(cell[a])] != first;
    if (!varies) continue;
    for (int q = 0; q < rule.points; ++q) {
      const double volume = problem.copies * rule.weight[nth(q)] *
                            cell_gradients(mesh, c, &rule.slope[nth(q * per)], gradient.data());
      Vec3 w{};
      for (int a = 0; a < per; ++a)
        for (int r = 0; r < 3; ++r) w[r] += weight[nth(cell[a])] * gradient[nth(a)][r];
      visit(c, q, volume, w);
    }
  }
}

}  // namespace

Vec3 stress_force(const Coenergy& function, const State& state, const std::vector<double>& weight) {
  const auto potential = function.nodal(state);
  Vec3 force{};
  for_varying_points(function, weight, [&](int c, int q, double volume, const Vec3& w) {
    const Vec3 h = function.field(c, q, potential, state);
    const MediumPoint p = function.law(c).at(h);
    const double bw = dot(p.b, w);
    for (int r = 0; r < 3; ++r) force[r] -= volume * (h[r] * bw - p.coenergy * w[r]);
  });
  return force;
}

Vec3 stress_force_slope(const Coenergy& function, const State& state, const State& direction,
                        const std::vector<double>& weight) {
  const auto potential = function.nodal(state);
  auto change = function.nodal(direction);
  const auto given = function.nodal({std::vector<double>(direction.u.size(), 0), {}});
  for (std::size_t n = 0; n < change.size(); ++n) change[n] -= given[n];
  Vec3 slope{};
  for_varying_points(function, weight, [&](int c, int q, double volume, const Vec3& w) {
    const Vec3 h = function.field(c, q, potential, state), dh = function.field(c, q, change, direction);
    const MediumPoint p = function.law(c).at(h);
    const double bw = dot(p.b, w), dbw = dot(times(p.slope, dh), w), energy = dot(p.b, dh);
    for (int r = 0; r < 3; ++r) slope[r] -= volume * (dh[r] * bw + h[r] * dbw - energy * w[r]);
  });
  return slope;
}

}  // namespace powbench::sim::space
