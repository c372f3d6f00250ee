#include "bench/space/probe.h"

#include <algorithm>
#include <cmath>

namespace powbench::bench {

using namespace sim;
using namespace sim::space;

Probe::Probe(const space::Coenergy& function, const space::State& state)
    : function_(function), state_(state), potential_(function.nodal(state)) {
  const auto& mesh = function.problem().mesh;
  for (const auto& m : function.problem().media) laws_.emplace_back(m);
  const int per = mesh.per_cell();
  for (int c = 0; c < mesh.count(); ++c) {
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (int a = 0; a < per; ++a)
      for (int r = 0; r < 3; ++r) {
        const double x =
            mesh.nodes[static_cast<std::size_t>(mesh.cells[static_cast<std::size_t>(c * per + a)])][r];
        low[r] = std::min(low[r], x);
        high[r] = std::max(high[r], x);
      }
    low_.push_back(low);
    high_.push_back(high);
  }
}

/// Newton on the map from the reference cell; true if the point lies in the cell.
bool Probe::locate(int c, const Vec3& point, Vec3& xi) const {
  const auto& mesh = function_.problem().mesh;
  const int per = mesh.per_cell();
  const bool hex = mesh.cell == Cell::hex8 || mesh.cell == Cell::hex20 || mesh.cell == Cell::hex27;
  xi = hex ? Vec3{} : Vec3{0.25, 0.25, 0.25};
  std::vector<double> value;
  std::vector<Vec3> slope, gradient(static_cast<std::size_t>(per));
  for (int k = 0; k < 12; ++k) {
    cell_shape(mesh.cell, xi, value, slope);
    Vec3 miss = point;
    for (int a = 0; a < per; ++a)
      for (int r = 0; r < 3; ++r)
        miss[r] -= value[static_cast<std::size_t>(a)] *
                   mesh.nodes[static_cast<std::size_t>(mesh.cells[static_cast<std::size_t>(c * per + a)])][r];
    // the function with the value xi_r at each node has the gradient d xi_r / d x
    cell_gradients(mesh, c, slope.data(), gradient.data());
    Vec3 step{};
    const auto& reference = cell_rule(mesh.cell).node;
    for (int a = 0; a < per; ++a) {
      const double along = gradient[static_cast<std::size_t>(a)][0] * miss[0] +
                           gradient[static_cast<std::size_t>(a)][1] * miss[1] +
                           gradient[static_cast<std::size_t>(a)][2] * miss[2];
      for (int r = 0; r < 3; ++r) step[r] += along * reference[static_cast<std::size_t>(a)][r];
    }
    double size = 0;
    for (int r = 0; r < 3; ++r) {
      xi[r] += step[r];
      size = std::max(size, std::fabs(step[r]));
    }
    if (size < 1e-12) break;
  }
  constexpr double slack = 1e-9;
  if (hex) return std::max({std::fabs(xi[0]), std::fabs(xi[1]), std::fabs(xi[2])}) <= 1 + slack;
  return std::min({xi[0], xi[1], xi[2]}) >= -slack && xi[0] + xi[1] + xi[2] <= 1 + slack;
}

Probe::Sample Probe::at(const Vec3& point) const {
  const auto& problem = function_.problem();
  const auto& mesh = problem.mesh;
  const int per = mesh.per_cell();
  Sample out;
  Vec3 xi;
  for (int c = 0; c < mesh.count() && out.cell < 0; ++c) {
    bool inside = true;
    for (int r = 0; r < 3; ++r) {
      const auto& low = low_[static_cast<std::size_t>(c)];
      const auto& high = high_[static_cast<std::size_t>(c)];
      const double slack = 1e-9 * (high[r] - low[r]);
      inside = inside && point[r] >= low[r] - slack && point[r] <= high[r] + slack;
    }
    if (inside && locate(c, point, xi)) out.cell = c;
  }
  if (out.cell < 0) return out;
  std::vector<double> value;
  std::vector<Vec3> slope, gradient(static_cast<std::size_t>(per));
  cell_shape(mesh.cell, xi, value, slope);
  cell_gradients(mesh, out.cell, slope.data(), gradient.data());
  for (int a = 0; a < per; ++a)
    for (int r = 0; r < 3; ++r)
      out.h[r] -=
          potential_[static_cast<std::size_t>(mesh.cells[static_cast<std::size_t>(out.cell * per + a)])] *
          gradient[static_cast<std::size_t>(a)][r];
  for (std::size_t k = 0; k < problem.windings.size(); ++k) {
    const Vec3 t = problem.windings[k](point);
    for (int r = 0; r < 3; ++r) out.h[r] += state_.current[k] * t[r];
  }
  out.b = laws_[static_cast<std::size_t>(mesh.region[static_cast<std::size_t>(out.cell)])].at(out.h).b;
  return out;
}

}  // namespace powbench::bench
