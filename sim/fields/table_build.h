#pragma once

#include "sim/fields/magnet_field.h"
#include "sim/fields/potential_table.h"
#include "sim/team.h"

/// Fills a PotentialTable with finite elements: one solution with given fluxes a node, its derivatives by back-solves.

namespace powbench::sim {

struct TableOptions {
  double accuracy = 0.005;  ///< relative, of current and pull; sets mesh and nodes, 0.0005 .. 0.05
  int psi_nodes = 0;        ///< 0: by `accuracy` (24 at 0.5 %)
  int gap_nodes = 0;
  int ring_nodes = 0;
  double largest_gap = 6e-3;   ///< m
  double largest_field = 2.4;  ///< T in the centre leg, sets the largest psi
  bool ring = true;            ///< false: the ring carries no current, a table of two variables
};

struct TableReport {
  int solutions = 0;
  int iterations = 0;       ///< factorisations in all
  int most_iterations = 0;  ///< of one solution
  int unknowns = 0;
  double stress_error =
      0;  ///< largest |pull by stress - pull by virtual work|, relative, where the pull is above 1 % of the largest
};

/// Gaps are shared out over the team; the result does not depend on the number of workers. Throws
/// std::invalid_argument for a bad design or options, std::runtime_error where Newton does not converge.
PotentialTable build_table(const MagnetDesign&, const TableOptions&, Team&, TableReport* report = nullptr);

/// The nodes and mesh that `build_table` takes.
struct TablePlan {
  std::vector<double> psi, ring, gap;
  FieldOptions field;
};
TablePlan plan_table(const MagnetDesign&, const TableOptions&);

/// Hash of everything the table depends on.
std::uint64_t table_hash(const MagnetDesign&, const TableOptions&);

/// Fills in `current_error` and `pull_error` from the table itself: each inner node is predicted from its neighbours
/// along every axis; a cell has 1/16 (values) and 1/8 (slopes) of what its corners miss, the orders of the interpolation.
void estimate_errors(PotentialTable&);

}  // namespace powbench::sim
