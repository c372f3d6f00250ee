#pragma once

#include <vector>

#include "sim/magnetics/plane/magnet_field.h"

/// The usual way to keep a field: two tables of flux linkage and pull over (current, gap), each linear in both
/// variables. The nodes are those that suit it: current by the power 1.5, gap by its logarithm as in the potential's
/// tables.

namespace powbench::bench {

class BilinearTables final : public sim::MagneticPotential {
 public:
  /// From `field` itself, n x n states up to `largest_current`, A, and `largest_gap`, m.
  BilinearTables(sim::MagnetField& field, int n, double largest_current, double largest_gap);

  double flux(double current, double gap) const { return value(flux_, current, gap); }
  double pull(double current, double gap) const { return value(pull_, current, gap); }

  bool has_ring() const override { return false; }

  /// The current is found from psi; beyond the last one the last cell goes on. There is no energy behind two tables:
  /// it stays 0, and the derivatives by the gap too.
  sim::MagneticResponse at(const sim::MagneticState&) const override;

 private:
  double value(const std::vector<double>& table, double current, double gap) const;
  double at_node(const std::vector<double>& table, std::size_t i, double gap) const;

  std::vector<double> current_, gap_, flux_, pull_;  ///< tables by gap, current fastest
};

/// Work that a potential gives away on a closed path through (psi, gap), over the work done on the way: a rectangle
/// between two fluxes and two gaps, in `steps` pieces a side. Zero where current and pull come from one energy.
double loop_gain(const sim::MagneticPotential&, double psi_low, double psi_high, double gap_low,
                 double gap_high, int steps);

}  // namespace powbench::bench
