#include "sim/magnetics/space/coenergy.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

namespace powbench::sim::space {
namespace {

std::size_t at(int a) {
  return static_cast<std::size_t>(a);
}

/// Position of the pair (a, b), a >= b, in a triangle stored by rows.
int pair_index(int a, int b) {
  return a * (a + 1) / 2 + b;
}

}  // namespace

Coenergy::Coenergy(const Problem& problem) : problem_(problem) {
  for (const auto& m : problem.media) laws_.emplace_back(m);
  for (const int r : problem.mesh.region)
    if (r < 0 || r >= static_cast<int>(laws_.size()))
      throw std::invalid_argument("field in space: region " + std::to_string(r) +
                                  " of the mesh, allowed 0 .. " + std::to_string(laws_.size() - 1));
  number();
  build_pattern();
  assemble_linear();
  prepare_iron();
}

void Coenergy::nodes_moved() {
  std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  assemble_linear();
  prepare_iron();
}

void Coenergy::number() {
  const auto& mesh = problem_.mesh;
  const std::size_t nodes = mesh.nodes.size();
  constexpr int unused = -2, fixed = -1;
  unknown_of_.assign(nodes, unused);
  fixed_value_.assign(nodes, 0);
  const auto root = [&](int n) { return problem_.tied.empty() ? n : problem_.tied[at(n)]; };
  std::vector<char> used(nodes, 0);
  for (const int n : mesh.cells) used[at(root(n))] = 1;
  for (const auto& [n, value] : problem_.fixed) {
    unknown_of_[at(root(n))] = fixed;
    fixed_value_[at(root(n))] = value;
  }
  if (problem_.fixed.empty() && !mesh.cells.empty()) unknown_of_[at(root(mesh.cells.front()))] = fixed;
  int count = 0;
  for (std::size_t n = 0; n < nodes; ++n)
    if (used[n] && unknown_of_[n] == unused) unknown_of_[n] = count++;
  for (std::size_t n = 0; n < nodes; ++n) {
    const auto r = at(root(static_cast<int>(n)));
    unknown_of_[n] = unknown_of_[r] == unused ? fixed : unknown_of_[r];
    fixed_value_[n] = fixed_value_[r];
  }
  matrix_.start.assign(at(count) + 1, 0);
}

void Coenergy::build_pattern() {
  const auto& mesh = problem_.mesh;
  const int per = mesh.per_cell(), n = matrix_.size();
  std::vector<std::vector<int>> rows(at(n));
  const auto for_pairs = [&](const auto& visit) {
    for (int c = 0; c < mesh.count(); ++c)
      for (int a = 0; a < per; ++a)
        for (int b = 0; b <= a; ++b) {
          const int i = unknown_of_[at(mesh.cells[at(c * per + a)])];
          const int j = unknown_of_[at(mesh.cells[at(c * per + b)])];
          visit(c * per * (per + 1) / 2 + pair_index(a, b), std::max(i, j), std::min(i, j));
        }
  };
  const auto tidy = [](std::vector<int>& column) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  };
  for_pairs([&](int, int i, int j) {
    if (j < 0) return;
    auto& column = rows[at(j)];
    if (column.size() == column.capacity()) tidy(column);
    column.push_back(i);
  });
  for (int c = 0; c < n; ++c) {
    tidy(rows[at(c)]);
    matrix_.row.insert(matrix_.row.end(), rows[at(c)].begin(), rows[at(c)].end());
    matrix_.start[at(c) + 1] = static_cast<int>(matrix_.row.size());
  }
  matrix_.value.assign(matrix_.row.size(), 0);
  slot_.assign(at(mesh.count()) * at(per * (per + 1) / 2), -1);
  for_pairs([&](int place, int i, int j) {
    if (j < 0) return;
    const auto first = matrix_.row.begin() + matrix_.start[at(j)];
    const auto last = matrix_.row.begin() + matrix_.start[at(j) + 1];
    slot_[at(place)] = static_cast<int>(std::lower_bound(first, last, i) - matrix_.row.begin());
  });
}

void Coenergy::assemble_linear() {
  const auto& mesh = problem_.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes, sources = windings() + 1;
  linear_ui_.assign(at(sources), std::vector<double>(at(unknowns()), 0));
  linear_ii_.assign(at(sources * sources), 0);
  for (std::size_t k = 0; k < problem_.series.size(); ++k)
    linear_ii_[k * at(sources + 1)] = problem_.series[k];
  std::vector<Vec3> gradient(at(per)), t(at(sources));
  for (int c = 0; c < mesh.count(); ++c) {
    const auto& law = laws_[at(mesh.region[at(c)])];
    if (!law.linear()) continue;
    const double mu = problem_.media[at(mesh.region[at(c)])].permeability;
    const int* cell = mesh.cells.data() + c * per;
    for (int q = 0; q < rule.points; ++q) {
      const double w = mu * problem_.copies * rule.weight[at(q)] *
                       cell_gradients(mesh, c, &rule.slope[at(q * per)], gradient.data());
      Vec3 x{};
      t.back() = {};
      for (int a = 0; a < per; ++a)
        for (int r = 0; r < 3; ++r) {
          x[r] += rule.value[at(q * per + a)] * mesh.nodes[at(cell[a])][r];
          t.back()[r] -=
              gradient[at(a)][r] * (unknown_of_[at(cell[a])] < 0 ? fixed_value_[at(cell[a])] : 0.0);
        }
      for (int k = 0; k < windings(); ++k) t[at(k)] = source(x, k);
      for (int k = 0; k < sources; ++k)
        for (int l = 0; l < sources; ++l) linear_ii_[at(k * sources + l)] += w * dot(t[at(k)], t[at(l)]);
      for (int a = 0; a < per; ++a) {
        const int i = unknown_of_[at(cell[a])];
        if (i < 0) continue;
        for (int k = 0; k < sources; ++k) linear_ui_[at(k)][at(i)] -= w * dot(gradient[at(a)], t[at(k)]);
        const int* slot = slot_.data() + c * per * (per + 1) / 2;
        for (int b = 0; b <= a; ++b) {
          const int s = slot[pair_index(a, b)];
          if (s < 0) continue;
          // two nodes of one cell tied to each other count twice on the diagonal
          const bool twice = a != b && i == unknown_of_[at(cell[b])];
          matrix_.value[at(s)] += (twice ? 2 : 1) * w * dot(gradient[at(a)], gradient[at(b)]);
        }
      }
    }
  }
}

void Coenergy::prepare_iron() {
  const auto& mesh = problem_.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes;
  iron_.clear();
  for (int c = 0; c < mesh.count(); ++c)
    if (!laws_[at(mesh.region[at(c)])].linear()) iron_.push_back(c);
  iron_gradient_.resize(iron_.size() * at(rule.points * per));
  iron_weight_.resize(iron_.size() * at(rule.points));
  iron_source_.resize(iron_.size() * at(rule.points * windings()));
  for (std::size_t e = 0; e < iron_.size(); ++e)
    for (int q = 0; q < rule.points; ++q) {
      const std::size_t point = e * at(rule.points) + at(q);
      const double det =
          cell_gradients(mesh, iron_[e], &rule.slope[at(q * per)], &iron_gradient_[point * at(per)]);
      iron_weight_[point] = problem_.copies * rule.weight[at(q)] * det;
      Vec3 x{};
      for (int a = 0; a < per; ++a)
        for (int r = 0; r < 3; ++r)
          x[r] += rule.value[at(q * per + a)] * mesh.nodes[at(mesh.cells[at(iron_[e] * per + a)])][r];
      for (int k = 0; k < windings(); ++k) iron_source_[point * at(windings()) + at(k)] = source(x, k);
    }
}

std::vector<double> Coenergy::nodal(const State& s) const {
  std::vector<double> all(unknown_of_.size());
  for (std::size_t n = 0; n < all.size(); ++n)
    all[n] = unknown_of_[n] < 0 ? fixed_value_[n] : s.u[at(unknown_of_[n])];
  return all;
}

double Coenergy::largest_steel_field(const State& s) const {
  const auto potential = nodal(s);
  const int middle = cell_rule(problem_.mesh.cell).points / 2;
  double largest = 0;
  for (const int c : iron_) {
    const Vec3 b = law(c).at(field(c, middle, potential, s)).b;
    largest = std::max(largest, std::sqrt(dot(b, b)));
  }
  return largest;
}

template <class Visit>
void Coenergy::for_iron_points(const State& s, const Visit& visit) const {
  const auto& mesh = problem_.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes;
  const auto potential = nodal(s);
  for (std::size_t e = 0; e < iron_.size(); ++e) {
    const int c = iron_[e];
    const int* cell = mesh.cells.data() + c * per;
    for (int q = 0; q < rule.points; ++q) {
      const std::size_t point = e * at(rule.points) + at(q);
      const Vec3* gradient = &iron_gradient_[point * at(per)];
      const Vec3* t = iron_source_.data() + point * at(windings());
      Vec3 h{};
      for (int k = 0; k < windings(); ++k)
        for (int r = 0; r < 3; ++r) h[r] += s.current[at(k)] * t[k][r];
      for (int a = 0; a < per; ++a)
        for (int r = 0; r < 3; ++r) h[r] -= potential[at(cell[a])] * gradient[a][r];
      visit(c, cell, gradient, t, iron_weight_[point], laws_[at(mesh.region[at(c)])].at(h));
    }
  }
}

double Coenergy::value(const State& s, std::vector<double>* gradient, std::vector<double>* flux) const {
  const int sources = windings() + 1, per = problem_.mesh.per_cell();
  std::vector<double> amount(s.current);
  amount.push_back(1);
  std::vector<double> g;
  matrix_.multiply(s.u, g);
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i) sum += 0.5 * g[i] * s.u[i];
  std::vector<double> f(at(sources), 0);
  for (int k = 0; k < sources; ++k) {
    const auto& column = linear_ui_[at(k)];
    for (std::size_t i = 0; i < g.size(); ++i) {
      g[i] += amount[at(k)] * column[i];
      f[at(k)] += column[i] * s.u[i];
    }
    sum += amount[at(k)] * f[at(k)];
    double inner = 0;
    for (int l = 0; l < sources; ++l) inner += linear_ii_[at(k * sources + l)] * amount[at(l)];
    f[at(k)] += inner;
    sum += 0.5 * inner * amount[at(k)];
  }
  for_iron_points(
      s, [&](int, const int* cell, const Vec3* slope, const Vec3* t, double w, const MediumPoint& p) {
        sum += w * p.coenergy;
        for (int k = 0; k < windings(); ++k) f[at(k)] += w * dot(t[k], p.b);
        for (int a = 0; a < per; ++a) {
          const int i = unknown_of_[at(cell[a])];
          if (i >= 0) g[at(i)] -= w * dot(slope[a], p.b);
        }
      });
  if (gradient) *gradient = std::move(g);
  f.pop_back();
  if (flux) *flux = std::move(f);
  return sum;
}

Coenergy::Hessian Coenergy::hessian() const {
  return {matrix_, std::vector<std::vector<double>>(at(windings()), std::vector<double>(at(unknowns()), 0)),
          std::vector<double>(at(windings() * windings()), 0)};
}

void Coenergy::hessian(const State& s, Hessian& out) const {
  const int m = windings(), per = problem_.mesh.per_cell();
  out.uu.value = matrix_.value;
  for (int k = 0; k < m; ++k) {
    out.ui[at(k)] = linear_ui_[at(k)];
    for (int l = 0; l < m; ++l) out.ii[at(k * m + l)] = linear_ii_[at(k * (m + 1) + l)];
  }
  std::vector<Vec3> d(at(per));
  std::vector<double> block(at(per * (per + 1) / 2), 0);
  int open = -1;
  const auto close = [&] {
    if (open < 0) return;
    const int* slot = slot_.data() + static_cast<std::ptrdiff_t>(open) * per * (per + 1) / 2;
    const int* cell = problem_.mesh.cells.data() + static_cast<std::ptrdiff_t>(open) * per;
    for (int a = 0; a < per; ++a)
      for (int b = 0; b <= a; ++b) {
        const int sl = slot[pair_index(a, b)];
        if (sl < 0) continue;
        const bool twice = a != b && unknown_of_[at(cell[a])] == unknown_of_[at(cell[b])];
        out.uu.value[at(sl)] += (twice ? 2 : 1) * block[at(pair_index(a, b))];
      }
    std::fill(block.begin(), block.end(), 0);
  };
  for_iron_points(
      s, [&](int c, const int* cell, const Vec3* slope, const Vec3* t, double w, const MediumPoint& p) {
        if (c != open) {
          close();
          open = c;
        }
        for (int a = 0; a < per; ++a) d[at(a)] = times(p.slope, slope[a]);
        for (int a = 0, place = 0; a < per; ++a) {
          const Vec3 wd{w * d[at(a)][0], w * d[at(a)][1], w * d[at(a)][2]};
          for (int b = 0; b <= a; ++b) block[at(place++)] += dot(wd, slope[b]);
        }
        for (int k = 0; k < m; ++k) {
          const Vec3 dt = times(p.slope, t[k]);
          for (int a = 0; a < per; ++a) {
            const int i = unknown_of_[at(cell[a])];
            if (i >= 0) out.ui[at(k)][at(i)] -= w * dot(dt, slope[a]);
          }
          for (int l = 0; l < m; ++l) out.ii[at(k * m + l)] += w * dot(dt, t[l]);
        }
      });
  close();
}

Vec3 Coenergy::field(int c, int q, const std::vector<double>& potential, const State& s) const {
  const auto& mesh = problem_.mesh;
  const auto& rule = cell_rule(mesh.cell);
  const int per = rule.nodes;
  std::array<Vec3, 27> gradient;
  cell_gradients(mesh, c, &rule.slope[at(q * per)], gradient.data());
  Vec3 x{}, h{};
  const int* cell = mesh.cells.data() + static_cast<std::ptrdiff_t>(c) * per;
  for (int a = 0; a < per; ++a)
    for (int r = 0; r < 3; ++r) {
      x[r] += rule.value[at(q * per + a)] * mesh.nodes[at(cell[a])][r];
      h[r] -= potential[at(cell[a])] * gradient[at(a)][r];
    }
  for (int k = 0; k < windings(); ++k) {
    const Vec3 t = source(x, k);
    for (int r = 0; r < 3; ++r) h[r] += s.current[at(k)] * t[r];
  }
  return h;
}

}  // namespace powbench::sim::space
