#pragma once

#include <cstddef>
#include <vector>

#include "sim/magnetics/plane/ordering.h"
#include "sim/magnetics/plane/supernodes.h"

/// The structure of a multifrontal Cholesky factorisation: relaxed supernodes, each with its front.

namespace powbench::sim {

struct Front {
  int first = 0, columns = 0, rows = 0;  ///< own columns first .. first + columns; rows of the front
  int parent = -1;
  std::size_t structure = 0;  ///< offset in Fronts::rows: the rows of the front, own columns first
  std::size_t relative = 0;   ///< offset in Fronts::relative: where the rows below lie in the parent's front
  std::vector<int> children{};
};

struct Fronts {
  std::vector<Front> fronts;  ///< children before their parents
  std::vector<int> rows;
  std::vector<int> relative;
  std::vector<int> local;  ///< for each entry of the pattern, its row within the front of its column
};

/// The pattern must be in a postordered order of elimination already (`fill_reducing_order`).
Fronts fronts_of(const Pattern&, Joining);

}  // namespace powbench::sim
