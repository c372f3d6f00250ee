// A coil with an inductance in series is one potential again.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "sim/specimen/specimen_potential.h"
#include "sim/supply/series_inductance.h"

using namespace powbench::sim;

namespace {

double slope(const std::function<double(double)>& f, double x, double h) {
  return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * h);
}

}  // namespace

TEST_CASE("a series inductance keeps every derivative that of the energy, from no flux to deep saturation") {
  for (const double share : {0.0, 0.648}) {
    Specimen s;
    s.magnet.shaded_share = share;
    const SpecimenPotential coil(s);
    const SeriesInductance both(coil, 0.7);
    for (const double lambda : {-0.05, 0.3, 0.9, 2.5})
      for (const double gap : {1e-5, 1e-3}) {
        const MagneticState at{lambda, coil.has_ring() ? 2e-4 * lambda : 0.0, gap};
        const auto m = both.at(at);
        const auto along = [&](double MagneticState::*x, double MagneticResponse::*y, double h) {
          return slope(
              [&](double v) {
                MagneticState near = at;
                near.*x = v;
                return both.at(near).*y;
              },
              at.*x, h);
        };
        constexpr double d_psi = 1e-4, d_ring = 1e-8, d_gap = 1e-7;
        const auto close = [](double found, double expected) {
          return std::fabs(found - expected) <= 2e-6 * std::fabs(expected) + 1e-7;
        };
        CAPTURE(share, lambda, gap);
        using M = MagneticState;
        using R = MagneticResponse;
        CHECK(close(along(&M::psi, &R::energy, d_psi), m.current));
        CHECK(close(along(&M::gap, &R::energy, d_gap), m.pull));
        CHECK(close(along(&M::psi, &R::current, d_psi), m.current_psi));
        CHECK(close(along(&M::gap, &R::current, d_gap), m.current_gap));
        CHECK(close(along(&M::psi, &R::pull, d_psi), m.current_gap));
        CHECK(close(along(&M::gap, &R::pull, d_gap), m.pull_gap));
        // the state is the flux linkage of both
        const double psi = lambda - 0.7 * m.current;
        CHECK(coil.at({psi, at.ring, gap}).current == Approx(m.current).epsilon(1e-12).margin(1e-15));
        if (!coil.has_ring()) continue;
        CHECK(close(along(&M::ring, &R::energy, d_ring), m.ring_current));
        CHECK(close(along(&M::ring, &R::current, d_ring), m.current_ring));
        CHECK(close(along(&M::ring, &R::ring_current, d_ring), m.ring_ring));
        CHECK(close(along(&M::gap, &R::ring_current, d_gap), m.ring_gap));
      }
  }
}

TEST_CASE("more leakage in the specimen and as much inductance in series are the same potential") {
  Specimen more;
  more.coil.leakage += 0.3;
  const SpecimenPotential own{more}, plain{Specimen{}};
  const SeriesInductance series(plain, 0.3);
  for (const double lambda : {0.1, 0.8, 1.6}) {
    const MagneticState s{lambda, 1e-4 * lambda, 2e-4};
    const auto a = own.at(s), b = series.at(s);
    CHECK(b.energy == Approx(a.energy).epsilon(1e-12));
    CHECK(b.current == Approx(a.current).epsilon(1e-12));
    CHECK(b.ring_current == Approx(a.ring_current).epsilon(1e-12));
    CHECK(b.pull == Approx(a.pull).epsilon(1e-12));
    CHECK(b.current_psi == Approx(a.current_psi).epsilon(1e-11));
    CHECK(b.ring_ring == Approx(a.ring_ring).epsilon(1e-11));
    CHECK(b.pull_gap == Approx(a.pull_gap).epsilon(1e-10));
  }
  CHECK_THROWS_AS(SeriesInductance(plain, 0), std::invalid_argument);
}
