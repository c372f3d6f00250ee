#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/magnetics/potential.h"

/// The stored energy W(psi, gap) or W(psi, ring, gap) on a grid, with what a cubic Hermite interpolation needs. One
/// potential instead of tables of psi and F: current and pull are its derivatives, so no closed path gains energy.

namespace powbench::sim {

/// Data of one table, SI. Nodes ascend; psi and gap start at 0, the nodes of the ring flux are symmetric about 0.
/// Negative psi follows from W(-psi, -ring, gap) = W(psi, ring, gap).
struct PotentialTable {
  std::vector<double> psi;   ///< Wb, nodes; with a ring of psi - ring_ratio ring
  std::vector<double> ring;  ///< Wb, nodes; empty: no ring
  /// 0, or turns of the coil by turn of the ring: then the first axis is the linkage of what the ring leaves out of the
  /// pole, and saturation of either part stands along an axis. W(psi, ring) = V(psi - ring_ratio ring, ring).
  double ring_ratio = 0;
  std::vector<double> gap;  ///< m, nodes

  /// By node, psi fastest, then ring, then gap. Two variables: W, W_psi, W_gap, W_psi,gap. Three: V, V_psi, V_ring,
  /// V_psi,ring, and the derivatives of these four by the gap.
  std::vector<double> nodes;

  /// Inverse inductances far beyond saturation (steel as air) by gap node, A/Wb: coil, or coil and ring; each with its
  /// derivative by the gap behind it. Two or four a node.
  std::vector<double> air;

  /// Relative error expected of current and of pull in each cell (of the interpolation; the mesh adds `mesh_error`).
  /// Cells in the order of the nodes.
  std::vector<double> current_error, pull_error;
  double mesh_error = 0;

  /// Largest flux density in the steel by node, T; empty: not known. `data_end`: where the rows of its curve end, T;
  /// 0: no end.
  std::vector<double> steel_field;
  double data_end = 0;

  std::uint64_t design_hash = 0;  ///< of shape, steel, turns and mesh
  std::string description;        ///< one line for people

  /// Largest expected error between the nodes, of current, of pull, and of both; 0 where none is known.
  double worst_current_error() const;
  double worst_pull_error() const;
  double worst_error() const { return std::max(worst_current_error(), worst_pull_error()); }

  std::size_t values() const { return ring.empty() ? 4 : 8; }  ///< by node

  /// Wb: linkage of the coil at the last nodes of both axes.
  double largest_psi() const { return psi.back() + (ring.empty() ? 0 : ring_ratio * ring.back()); }
};

/// How much of a table rests on extrapolated steel.
struct ExtrapolatedShare {
  double share = 0;          ///< of the nodes with steel somewhere above PotentialTable::data_end, 0 .. 1
  double from_psi = 0;       ///< Wb: the smallest flux linkage among them; without meaning where share is 0
  double largest_field = 0;  ///< T, of all nodes
};
ExtrapolatedShare extrapolated_share(const PotentialTable&);

/// Throws std::invalid_argument where sizes do not fit, nodes do not ascend, or a number is not finite.
void check_table(const PotentialTable&);

/// Fills in `current_error` and `pull_error` from the table itself: each inner node is predicted from its neighbours
/// along every axis, over a double cell; in a cell values err by 1/16 of what that misses, slopes by 0.2 of it over
/// the width.
void estimate_errors(PotentialTable&);

/// The rung `table`.
class TablePotential final : public MagneticPotential {
 public:
  /// Checks the table. Throws std::invalid_argument also where dW2/dpsi2 <= 0 inside a cell, and names the cell.
  explicit TablePotential(PotentialTable);

  bool has_ring() const override { return !table_.ring.empty(); }

  /// Beyond the last node of psi, of the ring flux or of the gap W goes on twice continuously differentiable, with
  /// o = |psi| - |psi_e|, x = gap - gap_e, and the answer is flagged `beyond`:
  ///
  ///   d2W/dpsi2 = g + (S_e - g) / (1 + o / p)^2 the saturation law: from the edge's S_e to the inverse inductance of
  ///   air, g F = F_e (3 u^2 - 2 u^3) + F_e' d (u^2 - u^3), u = 1 / (1 + x / d); F_e u^2 where F_e' = -2 F_e / d
  ///
  /// with the lengths p and d of the whole table, so that W stays one potential. Below gap 0 (faces pressed together)
  /// W goes on linearly. W(-psi, -ring, gap) = W(psi, ring, gap) to the last bit. NaN in, NaN out.
  MagneticResponse at(const MagneticState&) const override;

  const PotentialTable& table() const { return table_; }

  /// Least d2W/dpsi2 over all cells, A/Wb: exact for two variables, over a grid of 4 x 4 x 4 points a cell for three.
  double least_stiffness() const { return least_stiffness_; }

 private:
  /// Finds cells: the node below x.
  struct Axis {
    std::vector<double> node;
    std::vector<int> bin;
    double bins_per_unit = 0;
    explicit Axis(std::vector<double> nodes);
    Axis() = default;
    int cell(double x) const;
  };
  void fit_cells();
  void check_stiffness();
  MagneticResponse inside2(double psi, double gap) const;
  MagneticResponse inside3(double psi, double ring, double gap) const;

  /// Derivatives of W by psi, ring and gap, each of order 0 .. 2.
  struct Jet {
    double w[3][3][3] = {};
  };
  Jet jet(double psi, double ring, double gap) const;
  MagneticResponse outside(double psi, double ring, double gap) const;
  void fit_reaches();
  void fit_flux_reach();
  void fit_gap_reach();
  void air_at(double gap, std::size_t winding, double (&gamma)[3]) const;

  PotentialTable table_;
  Axis psi_, ring_, gap_;
  std::vector<double> cell_;  ///< coefficients: 16 (gap power slow, psi power fast) or 64 a cell
  double least_stiffness_ = 0;
  double flux_reach_ = 0, ring_reach_ = 0, gap_reach_ = 0;  ///< p, the same for the ring, d
};

}  // namespace powbench::sim
