#pragma once

#include <array>

#include "sim/mechanics/rigid_parts.h"

/// Sums over bridges and base modes round differently in another order. The rigid rung therefore computes in an order
/// that depends on the parts alone, whatever their numbers: then no bit of a result depends on the numbering.

namespace powbench::sim {

/// Parts in canonical order: bridges by position, then by their other numbers; modes by frequency, then by theirs.
struct CanonicalParts {
  RigidParts parts;
  /// Number, as given, of the bridge in each lane; lanes without a bridge keep their own.
  std::array<int, most_bridges> number{};
};

/// `parts` must be valid. Bridges that agree in every number, mode shapes included, are exchangeable. Modes that
/// agree in frequency, mass and damping are ordered by their shapes over the bridges as ordered without shapes; only
/// parts with ties in both are left in the order given.
CanonicalParts in_canonical_order(const RigidParts& parts);

}  // namespace powbench::sim
