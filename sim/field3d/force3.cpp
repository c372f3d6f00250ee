#include "sim/field3d/force3.h"

#include <array>
#include <stdexcept>
#include <string>

namespace powbench::sim {

Vec3 stress_force(const Coenergy3& function, const State3& state, const std::vector<double>& weight) {
  const auto& problem = function.problem();
  const auto& mesh = problem.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes;
  const auto potential = function.nodal(state);
  Vec3 force{};
  std::array<Vec3, 27> gradient;
  for (int c = 0; c < mesh.count(); ++c) {
    const int* cell = mesh.cells.data() + static_cast<std::ptrdiff_t>(c) * per;
    const double first = weight[static_cast<std::size_t>(cell[0])];
    bool varies = false;
    for (int a = 1; a < per; ++a) varies = varies || weight[static_cast<std::size_t>(cell[a])] != first;
    if (!varies) continue;
    const auto& medium = problem.media[static_cast<std::size_t>(mesh.region[static_cast<std::size_t>(c)])];
    if (medium.steel)
      throw std::invalid_argument("field3d: the weight of the force varies inside iron, in cell " +
                                  std::to_string(c));
    for (int q = 0; q < rule.points; ++q) {
      const Vec3* slope = &rule.slope[static_cast<std::size_t>(q * per)];
      const double volume = problem.copies * rule.weight[static_cast<std::size_t>(q)] *
                            cell_gradients(mesh, c, slope, gradient.data());
      const Vec3 h = function.field(c, q, potential, state);
      Vec3 w{};
      for (int a = 0; a < per; ++a)
        for (int r = 0; r < 3; ++r)
          w[r] += weight[static_cast<std::size_t>(cell[a])] * gradient[static_cast<std::size_t>(a)][r];
      const double hw = h[0] * w[0] + h[1] * w[1] + h[2] * w[2];
      const double hh = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
      for (int r = 0; r < 3; ++r) force[r] -= medium.permeability * volume * (h[r] * hw - 0.5 * hh * w[r]);
    }
  }
  return force;
}

}  // namespace powbench::sim
