#include "sim/magnetics/plane/fronts.h"

#include <algorithm>

namespace powbench::sim {
namespace {

std::size_t slot(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

Fronts fronts_of(const Pattern& p, Joining joining) {
  Fronts f;
  const auto parent = elimination_tree(p);
  const auto first = supernodes(parent, column_counts(p, parent), joining);
  f.fronts.resize(first.size() - 1);
  std::vector<int> front_of(slot(p.size)), mark(slot(p.size), -1), local(slot(p.size));
  for (std::size_t s = 0; s < f.fronts.size(); ++s)
    for (int j = first[s]; j < first[s + 1]; ++j) front_of[slot(j)] = static_cast<int>(s);
  f.local.resize(p.row.size());
  for (std::size_t s = 0; s < f.fronts.size(); ++s) {
    auto& n = f.fronts[s];
    n.first = first[s];
    n.columns = first[s + 1] - first[s];
    n.structure = f.rows.size();
    const int end = n.first + n.columns;
    for (int j = n.first; j < end; ++j) f.rows.push_back(j);
    const auto add = [&](int row) {
      if (row < end || mark[slot(row)] == static_cast<int>(s)) return;
      mark[slot(row)] = static_cast<int>(s);
      f.rows.push_back(row);
    };
    for (int at = p.start[slot(n.first)]; at < p.start[slot(end)]; ++at) add(p.row[slot(at)]);
    for (const int c : n.children)
      for (int k = f.fronts[slot(c)].columns; k < f.fronts[slot(c)].rows; ++k)
        add(f.rows[f.fronts[slot(c)].structure + slot(k)]);
    n.rows = static_cast<int>(f.rows.size() - n.structure);
    std::sort(f.rows.begin() + static_cast<std::ptrdiff_t>(n.structure) + n.columns, f.rows.end());
    for (int k = 0; k < n.rows; ++k) local[slot(f.rows[n.structure + slot(k)])] = k;
    for (int at = p.start[slot(n.first)]; at < p.start[slot(end)]; ++at)
      f.local[slot(at)] = local[slot(p.row[slot(at)])];
    for (const int c : n.children) {
      auto& child = f.fronts[slot(c)];
      child.relative = f.relative.size();
      for (int k = child.columns; k < child.rows; ++k)
        f.relative.push_back(local[slot(f.rows[child.structure + slot(k)])]);
    }
    if (n.rows > n.columns) {
      n.parent = front_of[slot(f.rows[n.structure + slot(n.columns)])];
      f.fronts[slot(n.parent)].children.push_back(static_cast<int>(s));
    }
  }
  return f;
}

}  // namespace powbench::sim
