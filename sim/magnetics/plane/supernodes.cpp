#include "sim/magnetics/plane/supernodes.h"

#include <cstddef>

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The strict lower triangle by rows.
Pattern by_rows(const Pattern& p) {
  Pattern t;
  t.size = p.size;
  t.start.assign(index(p.size) + 1, 0);
  for (int j = 0; j < p.size; ++j)
    for (int at = p.start[index(j)] + 1; at < p.start[index(j) + 1]; ++at)
      ++t.start[index(p.row[index(at)]) + 1];
  for (int j = 0; j < p.size; ++j) t.start[index(j) + 1] += t.start[index(j)];
  t.row.resize(index(t.start.back()));
  auto next = t.start;
  for (int j = 0; j < p.size; ++j)
    for (int at = p.start[index(j)] + 1; at < p.start[index(j) + 1]; ++at)
      t.row[index(next[index(p.row[index(at)])]++)] = j;
  return t;
}

/// A run of columns while blocks are joined.
struct Block {
  int first, columns, rows;
  double zeros;
};

/// Joining a child of `columns` with its parent makes one block; worth it where the share of zeros is small.
bool worth_joining(double columns, double zero_share, Joining joining) {
  if (joining == Joining::sparing) return columns <= 2 || zero_share < 0.05;
  if (columns <= 8) return true;
  if (columns <= 24) return zero_share < 0.5;
  if (columns <= 64) return zero_share < 0.15;
  return zero_share < 0.05;
}

}  // namespace

std::vector<int> elimination_tree(const Pattern& p) {
  const Pattern rows = by_rows(p);
  std::vector<int> parent(index(p.size), -1), ancestor(index(p.size), -1);
  for (int i = 0; i < p.size; ++i)
    for (int at = rows.start[index(i)]; at < rows.start[index(i) + 1]; ++at)
      for (int j = rows.row[index(at)]; j != -1 && j < i;) {
        const int above = ancestor[index(j)];
        ancestor[index(j)] = i;
        if (above == -1) parent[index(j)] = i;
        j = above;
      }
  return parent;
}

std::vector<int> column_counts(const Pattern& p, const std::vector<int>& parent) {
  const Pattern rows = by_rows(p);
  std::vector<int> count(index(p.size), 1), mark(index(p.size), -1);
  for (int i = 0; i < p.size; ++i) {
    mark[index(i)] = i;
    for (int at = rows.start[index(i)]; at < rows.start[index(i) + 1]; ++at)
      for (int j = rows.row[index(at)]; mark[index(j)] != i; j = parent[index(j)]) {
        ++count[index(j)];
        mark[index(j)] = i;
      }
  }
  return count;
}

std::vector<int> supernodes(const std::vector<int>& parent, const std::vector<int>& counts, Joining joining) {
  const int size = static_cast<int>(parent.size());
  std::vector<Block> blocks;
  for (int j = 0; j < size; ++j) {
    const bool joins = j > 0 && parent[index(j) - 1] == j && counts[index(j) - 1] == counts[index(j)] + 1;
    if (joins)
      ++blocks.back().columns;
    else
      blocks.push_back({j, 1, counts[index(j)], 0});
  }
  // from the last block to the first: a block may join its parent only when it lies directly before it
  std::vector<int> kept;
  for (int b = static_cast<int>(blocks.size()) - 1; b >= 0; --b) {
    Block& child = blocks[index(b)];
    if (!kept.empty()) {
      const int last = child.first + child.columns - 1;
      Block& next = blocks[index(kept.back())];
      if (parent[index(last)] >= 0 && parent[index(last)] == next.first) {
        const double columns = child.columns + next.columns;
        const double rows = child.columns + next.rows;
        const double total = columns * rows - columns * (columns - 1) / 2;
        const double own = child.columns * (child.rows - 0.5 * (child.columns - 1));
        const double others = next.columns * (next.rows - 0.5 * (next.columns - 1)) - next.zeros;
        const double zeros = total - own - others;
        if (worth_joining(columns, zeros / total, joining)) {
          next.first = child.first;
          next.columns += child.columns;
          next.rows = static_cast<int>(rows);
          next.zeros = zeros;
          continue;
        }
      }
    }
    kept.push_back(b);
  }
  std::vector<int> first;
  for (auto k = kept.rbegin(); k != kept.rend(); ++k) first.push_back(blocks[index(*k)].first);
  first.push_back(size);
  return first;
}

}  // namespace powbench::sim
