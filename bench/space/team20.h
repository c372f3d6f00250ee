#pragma once

#include "sim/magnetics/space/problem.h"

/// TEAM workshop problem 20: the saturated pull on a pole inside a yoke, measured at Okayama University.

namespace powbench::bench {

struct Team20 {
  sim::space::Problem problem;       ///< a quarter; one winding of one turn
  std::vector<double> virtual_work;  ///< weight of the force, falling over the whole of the gaps
  std::vector<double> thin;          ///< weight of the force, falling in the cells that touch the pole
};

/// `size` scales all cells: 1 is the standard mesh.
Team20 team20(double size, sim::space::Cell cell = sim::space::Cell::hex20);

struct Team20Row {
  double ampere_turns, pull, pole_average, yoke_average;  ///< A, N, T, T
};
inline constexpr Team20Row team20_measured[] = {
    {1000, 8.1, 0.72, 0.13}, {3000, 54.4, 1.75, 0.36}, {4500, 75.0, 2.01, 0.43}, {5000, 80.1, 2.05, 0.46}};

}  // namespace powbench::bench
