#pragma once

#include <array>
#include <memory>

#include "sim/magnetics/plane/gap_field.h"
#include "sim/magnetics/plane/newton_four.h"

namespace powbench::sim {

/// One magnet at four gaps at once: for tables, which want many states of one mesh.
class FieldFour {
 public:
  static constexpr std::size_t gaps = 4;
  using Vectors = NewtonFour::Vectors;

  /// `prototype` at any gap.
  FieldFour(const GapField& prototype, const NewtonOptions&);
  FieldFour(const FieldFour&) = delete;
  FieldFour& operator=(const FieldFour&) = delete;

  int unknowns() const { return each_[0]->problem().size(); }

  /// As GapField::set_gap, one in each lane.
  void set_gaps(const std::array<double, gaps>&);

  /// The states with these fluxes from starts near by; empty ones: no field. With `ring_open` the ring has no current.
  std::array<FieldPoint, gaps> at_flux(double psi, double ring, Vectors starts, bool ring_open);
  Vectors tangent(std::size_t winding) const { return newton_.flux_tangent(winding); }  ///< da/dflux of them

  /// Inverse inductances with air in place of steel, as PotentialTable::air, for such a `ring_ratio`.
  Vectors air(bool ring, double ratio);

 private:
  void set_steels(const std::vector<Steel>&);
  std::array<FieldPoint, gaps> solve(const std::vector<Circuit>&, Vectors starts, const NewtonOptions&);

  std::array<std::unique_ptr<GapField>, gaps> each_;
  NewtonFour newton_;
  NewtonOptions options_;
};

}  // namespace powbench::sim
