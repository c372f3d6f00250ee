#pragma once

#include <vector>

#include "sim/field3d/magnet_field3.h"
#include "sim/fields/table_build.h"

/// What the other rungs take from the one in three dimensions.

namespace powbench::sim {

/// What the ends of stack, coil and ring add to the plane problem at one gap. Both are solved on the same cells in the
/// plane, so the error of those cells cancels; the ring carries no current.
struct EndCorrection {
  double gap = 0;      ///< m
  double leakage = 0;  ///< H: (psi - psi of the plane problem) / current; MagnetDesign::end_leakage
  double pull = 1;     ///< pull over that of the plane problem at the same current
  double ring = 1;     ///< flux through the rings, likewise
};

/// At a current, A, for each gap, m.
std::vector<EndCorrection> end_corrections(const MagnetDesign&, const CoreMeshSizes3&, double current,
                                           const std::vector<double>& gaps);

/// The table W(psi, gap) of the field in three dimensions, the ring without current, with the nodes of `plan_table`.
/// Takes about four factorisations a node. Throws std::runtime_error where Newton does not converge.
PotentialTable build_table3(const MagnetDesign&, const CoreMeshSizes3&, const TableOptions&,
                            TableReport* report = nullptr);

/// PotentialTable::air at these gaps, m: the coil with its steel as air.
std::vector<double> air_of_core3(const MagnetDesign&, const CoreMeshSizes3&, const std::vector<double>& gaps);

}  // namespace powbench::sim
