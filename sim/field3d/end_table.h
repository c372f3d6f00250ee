#pragma once

#include "sim/field3d/ladder3.h"
#include "sim/team.h"

/// The table of the plane rung with what three dimensions add: fine nodes from the one, ends from the other.
///
///   W(psi, gap) = W_plane(psi, gap) + [W_whole(psi, gap) - W_flat(psi, gap)]
///
/// W_plane: the plane rung with the leakage L of the coil's heads in series. W_whole: the core in three dimensions
/// with its ends. W_flat: the plane problem on the cells of W_whole, L in series too, so that their error cancels in
/// the bracket. L takes most of the ends, so the bracket is small and smooth, and few nodes hold it. A sum of
/// potentials is a potential: current and pull stay its derivatives.

namespace powbench::sim {

struct EndTableOptions {
  CoreMeshSizes3 sizes = CoreMeshSizes3{}.scaled(2.8);
  int psi_nodes = 14, gap_nodes = 7;  ///< of the bracket, 4 .. 200
  double leakage_gap = 2e-3;          ///< m, where L is taken
};

/// W(psi, gap), the ring without current: `TableOptions::ring` is not read; MagnetDesign::end_leakage neither, it is
/// found. Throws std::invalid_argument as build_table does, std::runtime_error where Newton does not converge.
PotentialTable build_table_with_ends(const MagnetDesign&, const TableOptions&, const EndTableOptions&, Team&,
                                     TableReport* report = nullptr);

/// Hash of everything that table depends on.
std::uint64_t end_table_hash(const MagnetDesign&, const TableOptions&, const EndTableOptions&);

}  // namespace powbench::sim
