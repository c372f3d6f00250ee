#pragma once

#include <memory>

#include "sim/magnetics/potential.h"

/// Two rungs as one potential: one for small gaps, one for large ones, without a step in energy, current or pull:
///
///   W = s(g) W_large + (1 - s(g)) W_small,   s from 0 to 1 over [from, to], quintic (C2)
///   F = s F_large + (1 - s) F_small + s' (W_large - W_small)
///
/// The last term is what switching between two tables leaves out, and why that creates energy. Published models take
/// finite elements above 1.5 mm and a magnetic circuit with shading ring below.

namespace powbench::bench {

class BlendedPotential final : public sim::MagneticPotential {
 public:
  /// Both rungs must agree on whether there is a ring; 0 <= from < to, m. Throws std::invalid_argument otherwise.
  BlendedPotential(std::shared_ptr<const sim::MagneticPotential> small_gaps,
                   std::shared_ptr<const sim::MagneticPotential> large_gaps, double from, double to);

  bool has_ring() const override { return small_->has_ring(); }
  sim::MagneticResponse at(const sim::MagneticState&) const override;

 private:
  std::shared_ptr<const sim::MagneticPotential> small_, large_;
  double from_, to_;
};

}  // namespace powbench::bench
