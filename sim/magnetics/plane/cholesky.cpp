#include "sim/magnetics/plane/cholesky.h"

#include <algorithm>
#include <utility>

#include "sim/magnetics/plane/dense_kernel.h"
#include "sim/magnetics/plane/fronts.h"

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Leading dimension: whole vectors.
int padded(int rows) {
  return (rows + 7) / 8 * 8;
}

std::size_t area(int ld, int columns) {
  return index(ld) * index(columns);
}

}  // namespace

Cholesky::Cholesky(const Pattern& pattern) : pattern_(pattern) {
  take_structure(pattern);
  std::size_t panel = 0, top = 0, deepest = 0;
  std::vector<std::size_t> sizes(nodes_.size());
  int widest = 0;
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    auto& n = nodes_[s];
    n.panel = panel;
    panel += area(n.ld, n.columns);
    const int below = n.rows - n.columns;
    widest = std::max(widest, n.rows);
    sizes[s] = area(padded(below), below);
    deepest = std::max(deepest, top + sizes[s]);  // own update matrix is built above those of the children
    for (const int c : n.children) top -= sizes[index(c)];
    top += sizes[s];
  }
  panels_.assign(panel + dense_slack, 0);
  stack_.assign(deepest + dense_slack, 0);
  work_rows_ = padded(widest) + dense_slack;
  work_.assign(2 * index(work_rows_), 0);
}

void Cholesky::take_structure(const Pattern& p) {
  auto f = fronts_of(p, Joining::eager);
  rows_ = std::move(f.rows);
  relative_ = std::move(f.relative);
  local_ = std::move(f.local);
  for (auto& front : f.fronts) {
    auto& n = nodes_.emplace_back(Node{std::move(front)});
    n.ld = padded(n.rows);
    for (int j = 0; j < n.columns; ++j)
      for (int at = p.start[index(n.first + j)]; at < p.start[index(n.first + j + 1)]; ++at)
        local_[index(at)] += j * n.ld;
  }
}

void Cholesky::add_child(const Node& parent, const Node& child, const double* from, double* update, int ldu) {
  const int below = child.rows - child.columns;
  const int ldc = padded(below);
  const int* const to = relative_.data() + child.relative;
  double* const panel = panels_.data() + parent.panel;
  for (int j = 0; j < below; ++j) {
    const double* const column = from + area(ldc, j);
    double* const target = to[j] < parent.columns
                               ? panel + area(parent.ld, to[j])
                               : update + area(ldu, to[j] - parent.columns) - parent.columns;
    if (to[below - 1] - to[j] == below - 1 - j) {  // one run of rows
      double* const run = target + to[j];
      for (int i = j; i < below; ++i) run[i - j] += column[i];
    } else {
      for (int i = j; i < below; ++i) target[to[i]] += column[i];
    }
  }
}

void Cholesky::set_changing(const std::vector<char>& columns) {
  std::size_t kept = 0;
  for (auto& n : nodes_) {
    const auto first = columns.begin() + n.first;
    n.constant =
        std::none_of(first, first + n.columns, [](char c) { return c != 0; }) &&
        std::all_of(n.children.begin(), n.children.end(), [&](int c) { return nodes_[index(c)].constant; });
    n.handed_over = false;
    if (n.constant) continue;
    for (const int c : n.children) {
      Node& child = nodes_[index(c)];
      if (!child.constant) continue;
      child.handed_over = true;
      child.kept = kept;
      kept += area(padded(child.rows - child.columns), child.rows - child.columns);
    }
  }
  kept_.assign(kept, 0);
  kept_valid_ = false;
}

bool Cholesky::factor(const double* values, bool others_kept) {
  const DenseKernel& kernel = best_dense_kernel();
  const bool skip = others_kept && kept_valid_;
  kept_valid_ = false;
  double* top = stack_.data();  // behind the last update matrix
  for (const auto& n : nodes_) {
    if (skip && n.constant) continue;
    double* const panel = panels_.data() + n.panel;
    const int below = n.rows - n.columns;
    const int ldu = padded(below);
    double* update = top;
    std::fill(panel, panel + area(n.ld, n.columns), 0.0);
    std::fill(update, update + area(ldu, below), 0.0);
    for (int at = pattern_.start[index(n.first)]; at < pattern_.start[index(n.first + n.columns)]; ++at)
      panel[local_[index(at)]] = values[at];
    double* lowest = top;
    for (auto c = n.children.rbegin(); c != n.children.rend(); ++c) {
      const Node& child = nodes_[index(*c)];
      if (!child.handed_over) lowest -= area(padded(child.rows - child.columns), child.rows - child.columns);
      add_child(n, child, child.handed_over ? kept_.data() + child.kept : lowest, update, ldu);
    }
    if (kernel.factor_panel(panel, n.ld, n.rows, n.columns) >= 0) return false;
    if (below > 0) kernel.subtract_square(update, ldu, panel + n.columns, n.ld, below, below, n.columns);
    double* const target = n.handed_over ? kept_.data() + n.kept : lowest;
    if (target != update) std::copy(update, update + area(ldu, below), target);
    top = n.handed_over ? lowest : lowest + area(ldu, below);
  }
  kept_valid_ = true;
  return true;
}

void Cholesky::solve(const std::vector<double*>& b) const {
  for (std::size_t k = 0; k < b.size(); k += 2) solve_some(b.data() + k, k + 1 < b.size() ? 2 : 1);
}

void Cholesky::solve_some(double* const* b, int vectors) const {
  const DenseKernel& kernel = best_dense_kernel();
  double* const work = work_.data();
  for (const auto& n : nodes_) {
    const int* const rows = rows_.data() + n.structure;
    for (int v = 0; v < vectors; ++v) {
      double* const x = work + area(work_rows_, v);
      std::copy_n(b[v] + n.first, n.columns, x);
      std::fill(x + n.columns, x + n.rows, 0.0);
    }
    kernel.forward(panels_.data() + n.panel, n.ld, n.rows, n.columns, work, work_rows_, vectors);
    for (int v = 0; v < vectors; ++v) {
      const double* const x = work + area(work_rows_, v);
      std::copy_n(x, n.columns, b[v] + n.first);
      for (int i = n.columns; i < n.rows; ++i) b[v][rows[i]] += x[i];
    }
  }
  for (auto n = nodes_.rbegin(); n != nodes_.rend(); ++n) {
    const int* const rows = rows_.data() + n->structure;
    for (int v = 0; v < vectors; ++v)
      for (int i = 0; i < n->rows; ++i) work[area(work_rows_, v) + index(i)] = b[v][rows[i]];
    kernel.backward(panels_.data() + n->panel, n->ld, n->rows, n->columns, work, work_rows_, vectors);
    for (int v = 0; v < vectors; ++v) std::copy_n(work + area(work_rows_, v), n->columns, b[v] + n->first);
  }
}

}  // namespace powbench::sim
