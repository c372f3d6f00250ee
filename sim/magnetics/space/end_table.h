#pragma once

#include "sim/magnetics/space/ladder.h"
#include "sim/team.h"

/// The table of the plane rung with what three dimensions add: fine nodes from the one, ends from the other.
///
///   W(psi, ring, gap) = W_plane(psi, ring, gap) + [W_whole(psi, ring, gap) - W_flat(psi, ring, gap)]
///
/// W_plane: the plane rung with the leakages of the heads of coil and ring in series, each with its own winding.
/// W_whole: the core in three dimensions with its ends. W_flat: the plane problem on the cells of W_whole, the same
/// leakages in series, so that their error cancels in the bracket. The leakages take most of the ends, so the bracket
/// is small and smooth, and few nodes hold it. A sum of potentials is a potential: currents and pull stay its
/// derivatives. Without a ring flux (TableOptions::ring false, or a shape without ring) ring is no variable, and the
/// ring carries no current.

namespace powbench::sim {

struct EndTableOptions {
  space::CoreMeshSizes sizes = space::CoreMeshSizes{}.scaled(2.8);
  int psi_nodes = 14, ring_nodes = 9, gap_nodes = 7;  ///< of the bracket, 4 .. 200
  double leakage_gap = 2e-3;                          ///< m, where the leakages are taken
  space::Progress progress = {};                      ///< of all solutions in three dimensions
};

/// MagnetDesign::end_leakage and ring_leakage are not read, they are found. Throws std::invalid_argument as build_table
/// does, std::runtime_error where Newton does not converge.
PotentialTable build_table_with_ends(const MagnetDesign&, const TableOptions&, const EndTableOptions&, Team&,
                                     TableReport* report = nullptr);

/// Hash of everything that table depends on.
std::uint64_t end_table_hash(const MagnetDesign&, const TableOptions&, const EndTableOptions&);

}  // namespace powbench::sim
