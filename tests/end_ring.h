#pragma once

#include <catch2/catch.hpp>

#include "sim/magnetics/table/potential_table.h"

/// What a table with the ends of three dimensions and with the ring's current must obey, whatever its numbers.

namespace powbench::test {

/// The flux of the ring at which it carries no current.
inline double open_ring(const sim::TablePotential& t, double psi, double gap) {
  double low = 0, high = t.table().ring.back();
  CHECK(t.at({psi, low, gap}).ring_current < 0);  // Lenz: it holds the flux out
  CHECK(t.at({psi, high, gap}).ring_current > 0);
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (t.at({psi, middle, gap}).ring_current < 0 ? low : high) = middle;
  }
  return low;
}

/// `plane`: the same core in the plane, with its ring.
inline void check_ends_with_ring(const sim::TablePotential& ends, const sim::TablePotential& plane) {
  REQUIRE(ends.has_ring());
  REQUIRE(plane.has_ring());
  const double psi_end = std::min(ends.table().psi.back(), plane.table().psi.back());
  const double gap_end = std::min(ends.table().gap.back(), plane.table().gap.back());
  for (const double share : {0.2, 0.4})
    for (const double opening : {0.2, 0.8}) {
      const double psi = share * psi_end, gap = opening * gap_end;
      CAPTURE(psi, gap);
      const double ring = open_ring(ends, psi, gap);
      const auto open = ends.at({psi, ring, gap}), held = ends.at({psi, 0, gap});
      const auto flat = plane.at({psi, open_ring(plane, psi, gap), gap});
      CAPTURE(open.current, held.current, flat.current, open.energy, held.energy);
      // a ring that holds its flux at 0 leaves less iron to the coil: more current, more energy
      CHECK(held.current > open.current);
      CHECK(held.energy > open.energy);
      // the energy is convex in both fluxes
      CHECK(open.current_psi > 0);
      CHECK(open.ring_ring > 0);
      CHECK(open.current_psi * open.ring_ring > open.current_ring * open.current_ring);
      // flux beside the stack and around the heads of the coil comes on top: less current for the same flux
      CHECK(open.current < flat.current);
      CHECK(open.current > flat.current / 2);
    }
}

}  // namespace powbench::test
