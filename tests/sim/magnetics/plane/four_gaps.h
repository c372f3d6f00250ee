#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "sim/magnetics/plane/field_four.h"

/// Four gaps side by side against each by itself: random gaps up to the largest one, fluxes from the linear range into
/// saturation, from a start without field.
inline void check_four_gaps(const powbench::sim::GapField& prototype, double largest_gap, double saturation,
                            double turns, unsigned seed) {
  using namespace powbench::sim;
  using Catch::Detail::Approx;
  const NewtonOptions sharp{1e-17};  // slopes err by the root
  const auto one = prototype.copy(), bare = prototype.copy();
  bare->set_steels(prototype.air_steels());
  Newton newton(one->problem()), in_air(bare->problem());
  FieldFour four(prototype, sharp);
  std::mt19937_64 random(seed);
  std::array<double, 4> gap;
  for (double& g : gap) g = std::uniform_real_distribution(0.0, largest_gap)(random);
  four.set_gaps(gap);
  const auto alone_in = [&](const GapField& field, Newton& solver, double psi, double ring, bool open) {
    return state_in(field.with_fluxes(psi, ring, open), field, solver, {}, sharp);
  };
  for (const bool open : {true, false}) {
    if (!open && !prototype.has_ring()) continue;
    for (const double psi : {0.02 * saturation, 0.7 * saturation, 2 * saturation}) {
      const double ring = open ? 0 : 0.4 * psi / turns;
      const auto together = four.at_flux(psi, ring, {}, open);
      const auto tangents = four.tangent(0);
      const double ratio = open ? 0 : 0.7 * turns;
      const auto airs = four.air(!open, ratio);
      for (std::size_t k = 0; k < 4; ++k) {
        CAPTURE(open, psi, gap[k]);
        one->set_gap(gap[k]);
        bare->set_gap(gap[k]);
        const auto alone = alone_in(*one, newton, psi, ring, open);
        const auto &a = together[k].response, &b = alone.response;
        CHECK(together[k].newton.converged);
        CHECK(a.energy == Approx(b.energy).epsilon(1e-11));
        CHECK(a.current == Approx(b.current).epsilon(1e-9));
        CHECK(a.pull == Approx(b.pull).epsilon(1e-8));
        CHECK(a.current_psi == Approx(b.current_psi).epsilon(1e-6));
        CHECK(a.current_gap == Approx(b.current_gap).epsilon(1e-6));
        CHECK(a.ring_current == Approx(b.ring_current).epsilon(1e-8).margin(1e-9));
        CHECK(a.current_ring == Approx(b.current_ring).epsilon(1e-6).margin(1e-9));
        CHECK(a.ring_ring == Approx(b.ring_ring).epsilon(1e-6).margin(1e-9));
        CHECK(a.ring_gap == Approx(b.ring_gap).epsilon(1e-6).margin(1e-9));
        CHECK(together[k].stress_pull == Approx(alone.stress_pull).epsilon(1e-8));
        CHECK(together[k].largest_field == Approx(alone.largest_field).epsilon(1e-8));
        CHECK(together[k].beyond_data == alone.beyond_data);
        const auto tangent = newton.flux_tangent(0);
        double apart = 0, largest = 0;
        for (std::size_t j = 0; j < tangent.size(); ++j) {
          apart = std::max(apart, std::fabs(tangent[j] - tangents[k][j]));
          largest = std::max(largest, std::fabs(tangent[j]));
        }
        CHECK(apart < 1e-6 * largest);
        const auto coil = alone_in(*bare, in_air, 1e-3, 0, open).response;
        CHECK(airs[k][0] == Approx(coil.current_psi).epsilon(1e-10));
        CHECK(airs[k][1] == Approx(coil.current_gap / 1e-3).epsilon(1e-6));
        if (open) continue;
        const auto loop = alone_in(*bare, in_air, ratio * 1e-6, 1e-6, false).response;
        CHECK(airs[k][2] ==
              Approx(loop.ring_ring + ratio * (2 * loop.current_ring + ratio * loop.current_psi))
                  .epsilon(1e-9));
        CHECK(airs[k][3] == Approx((loop.ring_gap + ratio * loop.current_gap) / 1e-6).epsilon(1e-6));
      }
    }
  }
}
