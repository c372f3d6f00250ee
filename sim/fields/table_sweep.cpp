#include "sim/fields/table_sweep.h"

namespace powbench::sim::table_sweep {

std::vector<std::vector<std::size_t>> filling_passes(std::size_t gaps, bool from_neighbours) {
  std::vector<std::vector<std::size_t>> passes(from_neighbours ? 3 : 1);
  for (std::size_t g = 0; g < gaps; ++g) {
    const bool first = !from_neighbours || g % 4 == 0 || g + 1 == gaps;
    passes[first ? 0 : g % 2 == 0 ? 1 : 2].push_back(g);
  }
  return passes;
}

Neighbours known_neighbours(const std::vector<Misses>& misses, std::size_t gap) {
  std::size_t below = gap, above = gap;
  while (below > 0 && misses[below].empty()) --below;
  while (above + 1 < misses.size() && misses[above].empty()) ++above;
  if (misses[below].empty() || misses[above].empty()) return {};
  return {&misses[below], &misses[above],
          static_cast<double>(gap - below) / static_cast<double>(above - below)};
}

}  // namespace powbench::sim::table_sweep
