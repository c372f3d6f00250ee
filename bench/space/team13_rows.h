#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/space/table.h"

/// TEAM 13 beside what was measured, and from both sides.

namespace powbench::bench {

/// One side of TEAM 13 at 1000 A.
struct Team13Bound {
  std::string side;
  double gap = 0.5e-3;
  int order = 2, unknowns = 0, iterations = 0;
  double cpu = 0, psi = 0;
  std::vector<double> plate{};
};

/// The measured rows, at 1000 and 3000 A, by the scalar potential; returns the former.
Team13Bound team13_rows(Table&, double size);

/// TEAM 13 at 1000 A from both sides on the same grids: scalar potential above, edge elements below; and with a wider
/// gap. `finest` comes from the table of the measured rows.
nlohmann::ordered_json team13_bounds(const Team13Bound& finest, bool fine);

}  // namespace powbench::bench
