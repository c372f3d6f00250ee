#pragma once

#include <functional>
#include <vector>

#include "sim/magnetics/plane/table_build.h"
#include "sim/magnetics/space/magnet_field.h"

/// What the other rungs take from the one in three dimensions.

namespace powbench::sim::space {

/// What the ends of stack, coil and ring add to the plane problem at one gap. Both are solved on the same cells in the
/// plane, so the error of those cells cancels; the ring carries no current, except for its own leakage.
struct EndCorrection {
  double gap = 0;      ///< m
  double leakage = 0;  ///< H: (psi - psi of the plane problem) / current; MagnetDesign::end_leakage
  double pull = 1;     ///< pull over that of the plane problem at the same current
  double ring = 1;     ///< flux through the rings, likewise
  double ring_leakage =
      0;  ///< H, one turn: the same of the ring; MagnetDesign::ring_leakage; 0 without a ring
};

/// At a current, A, for each gap, m. The ring carries a tenth of its ampere-turns, alone, for `ring_leakage`.
std::vector<EndCorrection> end_corrections(const MagnetDesign&, const CoreMeshSizes&, double current,
                                           const std::vector<double>& gaps);

/// Called after each gap of a table with the number of solutions done and of all.
using Progress = std::function<void(int done, int all)>;

/// The table W(psi, gap) or W(psi, ring, gap) of the field in three dimensions, as TableOptions::ring and the shape
/// say, with the nodes of `plan_table`; those of the ring lie closer about zero, at end x (1 + 2 |x|) / 3 for even x in
/// -1 .. 1. Takes about four factorisations a node. On one thread: serial BLAS bears no more. Throws
/// std::runtime_error where Newton does not converge.
PotentialTable build_table(const MagnetDesign&, const CoreMeshSizes&, const TableOptions&,
                           TableReport* report = nullptr, const Progress& progress = {});

/// Newton for the states of a table: the last step squares the error.
inline constexpr NewtonOptions table_newton{.tolerance = 1e-9};

/// Even ring fluxes -end .. end moved closer about zero, where most states of a closing lie: x (1 + 2 |x / end|) / 3.
void close_about_zero(std::vector<double>& ring);

/// The table of such a field at the nodes of a plan, with the inductances of `bare`, the same with air in place of
/// steel; without estimates, hash and description. Throws as build_table.
PotentialTable fill_table(MagnetField& field, MagnetField& bare, const TablePlan&, TableReport&,
                          const Progress&);

/// PotentialTable::air at these gaps, m: coil, and ring if it is a variable, with the steel as air.
std::vector<double> air_of_core(const MagnetDesign&, const CoreMeshSizes&, const std::vector<double>& gaps,
                                bool ring);

}  // namespace powbench::sim::space
