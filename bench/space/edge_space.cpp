#include "bench/space/edge_space.h"

#include <algorithm>
#include <utility>

namespace powbench::bench {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

/// Each gradient of a function with a third L holds exactly one function that has the second P in the first of the
/// directions where it has one; without those the gradients are gone and curl A spans the same.
bool only_for_gradients(const EdgeSpace::Function& f) {
  if (f.factor[at(f.component)] == 0) return false;
  for (int r = 0; r < f.component; ++r)
    if (f.factor[at(r)] == 2) return false;
  return true;
}

std::vector<EdgeSpace::Function> functions_of(int order) {
  std::vector<EdgeSpace::Function> out;
  for (int d = 0; d < 3; ++d)
    for (int k = 0; k < order * (order + 1) * (order + 1); ++k) {
      EdgeSpace::Function f{d, {}};
      int rest = k;
      for (int r = 0; r < 3; ++r) {
        const int choices = r == d ? order : order + 1;
        f.factor[at(r)] = rest % choices;
        rest /= choices;
      }
      if (!only_for_gradients(f)) out.push_back(f);
    }
  return out;
}

/// Values and slopes of the factors along one direction.
struct Factors {
  double l[3], dl[3], p[2];

  Factors(double h, double t)
      : l{1 - t, t, 4 * t * (1 - t)}, dl{-1 / h, 1 / h, 4 * (1 - 2 * t) / h}, p{1 / h, 4 * (1 - 2 * t) / h} {}
};

}  // namespace

bool EdgeSpace::Function::lowest() const {
  for (int r = 0; r < 3; ++r)
    if (factor[at(r)] >= (r == component ? 1 : 2)) return false;
  return true;
}

EdgeSpace::EdgeSpace(int order, const std::vector<double>& x, const std::vector<double>& y,
                     const std::vector<double>& z)
    : functions_(functions_of(order)) {
  const std::vector<double>* line[3] = {&x, &y, &z};
  int last[3];  // places of the lattice of half bricks: 0 .. last
  for (int r = 0; r < 3; ++r) last[r] = 2 * static_cast<int>(line[r]->size()) - 2;
  const auto lattice = at((last[0] + 1) * (last[1] + 1) * (last[2] + 1));
  std::vector<int> unknown(6 * lattice, -1);  // by component, first or second P, and place
  for (int k = 0; 2 * k < last[2]; ++k)
    for (int j = 0; 2 * j < last[1]; ++j)
      for (int i = 0; 2 * i < last[0]; ++i) {
        Brick b;
        b.low = {x[at(i)], y[at(j)], z[at(k)]};
        b.size = {x[at(i + 1)] - x[at(i)], y[at(j + 1)] - y[at(j)], z[at(k + 1)] - z[at(k)]};
        for (const auto& f : functions_) {
          const int d = f.component;
          int place[3] = {2 * i, 2 * j, 2 * k};
          for (int r = 0; r < 3; ++r) place[r] += r == d || f.factor[at(r)] == 2 ? 1 : 2 * f.factor[at(r)];
          const bool wall = (d != 0 && place[0] == last[0]) || (d != 2 && place[2] == last[2]) ||
                            (d != 1 && (place[1] == 0 || place[1] == last[1]));
          const bool tied = d != 0 && place[0] == 0 && 2 * place[1] < last[1];
          if (tied) place[1] = last[1] - place[1];
          auto& number = unknown[at(d + 3 * f.factor[at(d)]) * lattice +
                                 at((place[2] * (last[1] + 1) + place[1]) * (last[0] + 1) + place[0])];
          if (!wall && number < 0) number = count_++;
          b.unknown.push_back(wall ? -1 : number);
          b.sign.push_back(tied && d == 1 ? -1 : 1);
        }
        bricks_.push_back(std::move(b));
      }
}

void EdgeSpace::curls(const sim::Vec3& size, const sim::Vec3& t, std::vector<sim::Vec3>& out) const {
  const Factors along[3] = {{size[0], t[0]}, {size[1], t[1]}, {size[2], t[2]}};
  out.assign(functions_.size(), {});
  for (std::size_t n = 0; n < functions_.size(); ++n) {
    const auto& f = functions_[n];
    const int d = f.component, e = (d + 1) % 3, g = (d + 2) % 3;
    const double p = along[d].p[f.factor[at(d)]];
    out[n][at(e)] = p * along[e].l[f.factor[at(e)]] * along[g].dl[f.factor[at(g)]];
    out[n][at(g)] = -p * along[e].dl[f.factor[at(e)]] * along[g].l[f.factor[at(g)]];
  }
}

sim::Vec3 EdgeSpace::field(const Brick& b, const std::vector<sim::Vec3>& curls,
                           const std::vector<double>& a) const {
  sim::Vec3 out{};
  for (std::size_t n = 0; n < curls.size(); ++n)
    if (b.unknown[n] >= 0)
      for (std::size_t r = 0; r < 3; ++r) out[r] += b.sign[n] * a[at(b.unknown[n])] * curls[n][r];
  return out;
}

sim::space::SymmetricMatrix EdgeSpace::pattern(std::vector<int>& slot) const {
  std::vector<std::vector<int>> columns(at(count_));
  const auto tidy = [](std::vector<int>& c) {
    std::sort(c.begin(), c.end());
    c.erase(std::unique(c.begin(), c.end()), c.end());
  };
  for (const auto& b : bricks_)
    for (const int column : b.unknown) {
      if (column < 0) continue;
      auto& c = columns[at(column)];
      if (c.size() + b.unknown.size() > c.capacity()) tidy(c);
      for (const int row : b.unknown)
        if (row >= column) c.push_back(row);
    }
  sim::space::SymmetricMatrix m;
  m.start.push_back(0);
  for (auto& c : columns) {
    tidy(c);
    m.row.insert(m.row.end(), c.begin(), c.end());
    m.start.push_back(static_cast<int>(m.row.size()));
  }
  m.value.assign(m.row.size(), 0);
  slot.clear();
  for (const auto& b : bricks_)
    for (const int row : b.unknown)
      for (const int column : b.unknown) {
        if (column < 0 || row < column) {
          slot.push_back(-1);
          continue;
        }
        const auto first = m.row.begin() + m.start[at(column)],
                   last = m.row.begin() + m.start[at(column) + 1];
        slot.push_back(static_cast<int>(std::lower_bound(first, last, row) - m.row.begin()));
      }
  return m;
}

}  // namespace powbench::bench
