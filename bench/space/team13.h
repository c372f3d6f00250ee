#pragma once

#include "bench/space/edge_field.h"
#include "sim/magnetics/space/coenergy.h"

/// TEAM workshop problem 13: thin saturated plates with gaps of 0.5 mm round a coil.

namespace powbench::bench {

/// A quarter of the whole: z >= 0 (H x n = 0 at z = 0) and x >= 0, whose face x = 0 is tied to itself, turned by 180
/// degrees about z. One winding of one turn. `size` scales all cells; `gap`, m, between centre plate and sheets, 0.5 mm
/// as published.
sim::space::Problem team13(double size, double gap = 0.5e-3);

/// The same on the edges of the grid, elements of order 1 or 2: the bound from the other side.
EdgeProblem team13_edges(double size, int order, double gap = 0.5e-3);

struct Team13Plate {
  double z_mm, b;  ///< T, average |B_z| over the centre plate's section, 1000 A
};
inline constexpr Team13Plate team13_plate[] = {{1, 1.330},  {10, 1.329}, {20, 1.286}, {30, 1.225},
                                               {40, 1.129}, {50, 0.985}, {60, 0.655}};

struct Team13Air {
  double x_mm, b;  ///< T, |B| at y = 20 mm, z = 55 mm, 3000 A
};
inline constexpr Team13Air team13_air[] = {{10, 0.05930}, {20, 0.04000},  {30, 0.03360}, {40, 0.03040},
                                           {50, 0.02830}, {60, 0.02600},  {70, 0.02310}, {80, 0.01820},
                                           {90, 0.01160}, {100, 0.00610}, {110, 0.00406}};

/// Average |B_z| over the centre plate's section at height z, m.
double team13_plate_average(const sim::space::Coenergy&, const sim::space::State&, double z);
double team13_plate_average(const EdgeField&, const EdgeSolution&, double z);

}  // namespace powbench::bench
