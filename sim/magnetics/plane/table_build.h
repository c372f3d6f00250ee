#pragma once

#include <functional>
#include <optional>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/table/potential_table.h"
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

/// di/dpsi of the closed magnet, of that with air in place of steel, where a drawing's table ends by itself: the narrow
/// sections are saturated, and what follows is the saturation law in leakage. At 0.8 a pot's steel has 3.4 T, since
/// its wide parts saturate last; at 0.5 it has 2.1 T.
inline constexpr double saturated_stiffness = 0.5;

/// Where the table of a drawing ends, Wb: as its designer states, 0: at `saturated()`, which throws
/// std::invalid_argument for a magnet that does not saturate. Throws the same for a stated one below 0.02 or above 2.5
/// times that.
double table_end(double stated, const std::function<double()>& saturated);

struct TableReport {
  int solutions = 0;
  int iterations = 0;       ///< factorisations in all
  int most_iterations = 0;  ///< of one solution
  int unknowns = 0;
  int beyond_data = 0;  ///< solutions with steel somewhere above the last row of its curve
  double stress_error =
      0;  ///< largest |pull by stress - pull by virtual work|, relative, where the pull is above 1 % of the largest
};

/// What four neighbouring gaps contribute, fewer at the end: a pure function of the design, the options and the gaps.
struct TableSlice {
  std::vector<double> nodes;        ///< as PotentialTable::nodes
  std::vector<double> steel_field;  ///< T, by node
  std::vector<double> air;          ///< as PotentialTable::air
  TableReport report;
  double largest_pull = 0;     ///< N
  double stress_distance = 0;  ///< N: largest |pull by stress - pull by virtual work|
};

/// Takes the place of the solutions of slice `number`, from 0: calls `solve`, or knows what it would return. Nothing:
/// this slice is not wanted. Called by several threads.
using SliceSource =
    std::function<std::optional<TableSlice>(std::size_t number, const std::function<TableSlice()>& solve)>;

/// Slices are shared out over the team; the result does not depend on the number of workers. Without a slice that
/// `source` does not want the table is empty. Throws std::invalid_argument for a bad design or options,
/// std::runtime_error where Newton does not converge.
PotentialTable build_table(const MagnetDesign&, const TableOptions&, Team&, TableReport* report = nullptr,
                           const SliceSource& source = {});

/// Whether the table is one of three variables.
bool with_ring(const MagnetDesign&, const TableOptions&);

/// The nodes and mesh that `build_table` takes.
struct TablePlan {
  std::vector<double> psi, ring, gap;
  double ring_ratio = 0;  ///< as PotentialTable's
  FieldOptions field;
  double mesh_error = 0;  ///< relative, that the sizes are meant for
};
TablePlan plan_table(const MagnetDesign&, const TableOptions&);

/// Where the iterations of a table's states end: energies, currents and pulls then err by far less than the tolerance,
/// the mixed derivatives, which are those before the last step, by up to the root of ten times it; that of three
/// variables is made of their differences.
NewtonOptions newton_of_table(double accuracy, bool ring);

/// The same for any coil without ring, up to this flux linkage, Wb.
TablePlan plan_table(const TableOptions&, double largest_psi);

/// Hash of everything the table depends on.
std::uint64_t table_hash(const MagnetDesign&, const TableOptions&);

/// Hash of numbers and of a curve, for tables of other shapes.
std::uint64_t hash_values(const std::vector<double>& values, const Steel&);

/// A hash with one more number in it, or with what of the options counts where the mesh is drawn.
std::uint64_t mixed_hash(std::uint64_t hash, double value);
std::uint64_t mixed_hash(std::uint64_t hash, const TableOptions&);

/// Sets d3W/dpsi dring dgap at the nodes of a table with a ring: slopes of the parabolas through three gaps.
void fill_triple(PotentialTable&);

}  // namespace powbench::sim
