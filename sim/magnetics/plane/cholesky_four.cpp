#include "sim/magnetics/plane/cholesky_four.h"

#include <algorithm>
#include <cassert>

namespace powbench::sim {
namespace {

std::size_t as_size(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

CholeskyFour::CholeskyFour(const Pattern& pattern)
    : pattern_(pattern), structure_(fronts_of(pattern, Joining::sparing)), places_(structure_.fronts.size()) {
  const auto& fronts = structure_.fronts;
  for (std::size_t s = fronts.size(); s-- > 0;)
    if (const int above = fronts[s].parent; above >= 0) places_[s].depth = 1 - places_[as_size(above)].depth;
  std::size_t panels = 0;
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    places_[s].panel = panels;
    panels += as_size(fronts[s].rows) * as_size(fronts[s].columns);
  }
  panels_.resize(panels);
  set_changing(std::vector<char>(as_size(pattern.size), 1));
}

void CholeskyFour::set_changing(const std::vector<char>& columns) {
  const auto& fronts = structure_.fronts;
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    const auto first = columns.begin() + fronts[s].first;
    Place& p = places_[s];
    p.constant = std::none_of(first, first + fronts[s].columns, [](char c) { return c != 0; }) &&
                 std::all_of(fronts[s].children.begin(), fronts[s].children.end(),
                             [&](int c) { return places_[as_size(c)].constant; });
    p.handed_over = false;
    if (!p.constant)
      for (const int c : fronts[s].children) places_[as_size(c)].handed_over = places_[as_size(c)].constant;
  }
  std::size_t top[2] = {}, deepest[2] = {}, kept = 0;
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    Place& p = places_[s];
    const auto own = as_size(p.depth), others = 1 - own;
    // the lowest of the children on their stack is where the next one goes
    for (const int c : fronts[s].children)
      if (const Place& child = places_[as_size(c)]; !child.handed_over)
        top[others] = std::min(top[others], child.update);
    const auto below = as_size(fronts[s].rows - fronts[s].columns);
    std::size_t& end = p.handed_over ? kept : top[own];
    p.update = end;
    end += below * (below + 1) / 2;
    deepest[own] = std::max(deepest[own], top[own]);
  }
  for (int k : {0, 1}) stacks_[k].resize(deepest[k]);
  kept_.resize(kept);
  kept_valid_ = false;
}

Four* CholeskyFour::update_of(std::size_t front) {
  const Place& p = places_[front];
  return (p.handed_over ? kept_.data() : stacks_[p.depth].data()) + p.update;
}

/// Adds the children's update matrices to the panel, or to the update matrix where one is given.
void CholeskyFour::add_children(const Front& f, Four* panel, Four* update) {
  const FourKernel& kernel = best_four_kernel();
  const auto rows = as_size(f.rows), columns = as_size(f.columns);
  for (const int c : f.children) {
    const Front& child = structure_.fronts[as_size(c)];
    const auto below = as_size(child.rows - child.columns);
    const Four* const from = update_of(as_size(c));
    const int* const to = structure_.relative.data() + child.relative;
    const auto inside = as_size(static_cast<int>(std::lower_bound(to, to + below, f.columns) - to));
    for (std::size_t j = update ? inside : 0; j < (update ? below : inside); ++j) {
      const auto column = as_size(to[j]);
      Four* const target =
          update ? update + packed_column(rows - columns, column - columns) - column : panel + rows * column;
      kernel.add(target, to + j, from + packed_column(below, j), static_cast<int>(below - j));
    }
  }
}

/// Second half of a solve.
void CholeskyFour::backward(const std::vector<Four*>& b) {
  const FourKernel& kernel = best_four_kernel();
  for (std::size_t s = structure_.fronts.size(); s-- > 0;) {
    const Front& f = structure_.fronts[s];
    kernel.backward(panels_.data() + places_[s].panel, f.rows, f.columns, b.data(), f.first, rows_below(f),
                    static_cast<int>(b.size()));
  }
}

void CholeskyFour::solve_again(Four* b) {
  const FourKernel& kernel = best_four_kernel();
  for (std::size_t s = 0; s < structure_.fronts.size(); ++s) {
    const Front& f = structure_.fronts[s];
    kernel.forward(panels_.data() + places_[s].panel, f.rows, f.columns, &b, f.first, rows_below(f), 1);
  }
  backward({b});
}

bool CholeskyFour::solve(const Four* values, const std::vector<Four*>& b, bool others_kept) {
  const FourKernel& kernel = best_four_kernel();
  const int vectors = static_cast<int>(b.size());
  assert(vectors >= 1 && vectors <= 3);
  const bool skip = others_kept && kept_valid_;
  kept_valid_ = false;
  for (std::size_t s = 0; s < structure_.fronts.size(); ++s) {
    const Front& f = structure_.fronts[s];
    Four* const panel = panels_.data() + places_[s].panel;
    const bool known = skip && places_[s].constant;
    if (!known) {
      const auto rows = as_size(f.rows);
      std::fill(panel, panel + rows * as_size(f.columns), Four{});
      for (int j = 0; j < f.columns; ++j)
        for (int at = pattern_.start[as_size(f.first + j)]; at < pattern_.start[as_size(f.first + j + 1)];
             ++at)
          panel[rows * as_size(j) + as_size(structure_.local[as_size(at)])] = values[at];
      add_children(f, panel, nullptr);
      if (kernel.factor_panel(panel, f.rows, f.columns) >= 0) return false;
    }
    kernel.forward(panel, f.rows, f.columns, b.data(), f.first, rows_below(f), vectors);
    const int below = f.rows - f.columns;
    if (known || below == 0) continue;
    kernel.square(update_of(s), panel + f.columns, f.rows, below, f.columns);
    add_children(f, panel, update_of(s));
  }
  kept_valid_ = true;
  backward(b);
  return true;
}

}  // namespace powbench::sim
