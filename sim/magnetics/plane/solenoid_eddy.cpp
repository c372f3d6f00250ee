#include <algorithm>
#include <cmath>

#include "sim/dot.h"
#include "sim/magnetics/plane/solenoid_field.h"

/// Eddy currents in the solid parts of a solenoid.

namespace powbench::sim {

/// The grid has one topology, and a column stays a column: vertices and middles of edges at one radius, in turns.
void SolenoidField::find_columns() {
  constexpr double same = 1e-9;  // m
  const auto& space = problem().space();
  std::vector<int> all;
  for (std::size_t t = 0; t < space.mesh.triangle.size(); ++t)
    if (space.mesh.region[t] == SolenoidRegion::plunger)
      for (int n = 0; n < space.nodes; ++n)
        if (space.unknowns(t)[n] < space.size()) all.push_back(space.unknowns(t)[n]);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const auto r = [&](int u) { return space.node_x[static_cast<std::size_t>(u)]; };
  const auto z = [&](int u) { return space.node_y[static_cast<std::size_t>(u)]; };
  std::sort(all.begin(), all.end(), [&](int a, int b) { return r(a) < r(b); });
  for (const int u : all) {
    if (columns_.empty() || r(u) - r(columns_.back().front()) > same) columns_.emplace_back();
    columns_.back().push_back(u);
  }
  for (auto& column : columns_)
    std::sort(column.begin(), column.end(), [&](int a, int b) { return z(a) < z(b); });
}

std::vector<double> SolenoidField::carry(const std::vector<double>& a, double old_gap) const {
  std::vector<double> carried = a;
  const double fallen = old_gap - gap_.gap();
  if (fallen == 0) return carried;
  const auto& mesh = gap_.grid().mesh();
  // places of the unknowns at the old gap: the same interpolation from vertices as at the new one
  FieldSpace old = problem().space();
  old.mesh.x = mesh.x;
  old.mesh.y = gap_.grid().heights(old_gap + design_.residual_gap);
  place_unknowns(old);
  const auto& now = problem().space().node_y;
  for (const auto& column : columns_) {
    const auto z = [&](std::size_t k) { return old.node_y[static_cast<std::size_t>(column[k])]; };
    const auto value = [&](std::size_t k) { return a[static_cast<std::size_t>(column[k])]; };
    if (column.size() < 3) continue;
    std::size_t low = 0;
    for (const int u : column) {
      const double at = now[static_cast<std::size_t>(u)] + fallen;
      while (low + 4 < column.size() && z(low + 2) < at) low += 2;
      const double z0 = z(low), z1 = z(low + 1), z2 = z(low + 2);
      carried[static_cast<std::size_t>(u)] =
          value(low) * (at - z1) * (at - z2) / ((z0 - z1) * (z0 - z2)) +
          value(low + 1) * (at - z0) * (at - z2) / ((z1 - z0) * (z1 - z2)) +
          value(low + 2) * (at - z0) * (at - z1) / ((z2 - z0) * (z2 - z1));
    }
  }
  return carried;
}

FieldPoint SolenoidField::eddy_step(double b, double r, double step, std::vector<double> carried) {
  const double rate = 2 / step;
  const auto& mass = problem().mass();
  load_.assign(carried.size(), 0);
  if (!mass.empty()) multiply(problem().space().pattern, mass, carried.data(), load_.data());
  for (std::size_t k = 0; k < load_.size(); ++k)
    load_[k] = rate * load_[k] + (magnet_.empty() ? 0.0 : magnet_[k]);
  load_.back() = 0;
  matrix_ = problem().linear();
  for (std::size_t k = 0; k < mass.size(); ++k) matrix_[k] += rate * mass[k];
  newton_.set_quadratic(&matrix_, &load_);
  auto p = solve({true, b, r}, std::move(carried));
  newton_.set_quadratic(nullptr, magnet_.empty() ? nullptr : &magnet_);
  return p;
}

double SolenoidField::eddy_power(const std::vector<double>& rate) const {
  if (problem().mass().empty()) return 0;
  std::vector<double> y(rate.size(), 0);
  multiply(problem().space().pattern, problem().mass(), rate.data(), y.data());
  y.back() = 0;
  return dot(rate, y);
}

double SolenoidField::energy(const std::vector<double>& a) const {
  std::vector<double> y(a.size(), 0);
  multiply(problem().space().pattern, problem().linear(), a.data(), y.data());
  y.back() = 0;
  const double linear = 0.5 * dot(a, y);
  return linear + problem().add_steel(a.data(), y.data(), nullptr) -
         (magnet_.empty() ? 0.0 : dot(magnet_, a));
}

}  // namespace powbench::sim
