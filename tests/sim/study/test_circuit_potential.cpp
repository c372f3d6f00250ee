// The rung `circuit`: derivatives, energy, limits, and the field rung beside it.

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/fields/circuit.h"
#include "core/random.h"
#include "core/units.h"
#include "sim/magnetics/plane/magnet_field.h"

using namespace powbench::sim;
using powbench::pi;
using powbench::Random;

namespace {

CircuitPotential reference(double ring_share = MagnetShape{}.ring_share) {
  MagnetShape s;
  s.ring_share = ring_share;
  return CircuitPotential(s, builtin_steel("lamination"), 2000, 36e-6, 0.05);
}

}  // namespace

TEST_CASE("circuit: every derivative is that of the energy, with and without a ring, into saturation") {
  for (const double share : {0.648, 0.0}) {
    const CircuitPotential circuit = reference(share);
    CHECK(circuit.has_ring() == (share > 0));
    Random random(5);
    for (int k = 0; k < 60; ++k) {
      const MagneticState s{3 * (random.uniform() - 0.5), 6e-4 * (random.uniform() - 0.5),
                            4e-3 * std::pow(random.uniform(), 3) + 1e-6};
      const auto r = circuit.at(s);
      const auto moved = [&](double psi, double ring, double gap) {
        return circuit.at({s.psi + psi, s.ring + ring, s.gap + gap});
      };
      CAPTURE(s.psi, s.ring, s.gap);
      const double hp = 1e-5, hr = 1e-9, hg = 1e-4 * (s.gap + 36e-6);
      CHECK(r.current ==
            Approx((moved(hp, 0, 0).energy - moved(-hp, 0, 0).energy) / (2 * hp)).epsilon(1e-5).margin(1e-6));
      CHECK(r.pull ==
            Approx((moved(0, 0, hg).energy - moved(0, 0, -hg).energy) / (2 * hg)).epsilon(1e-5).margin(1e-6));
      CHECK(r.current_psi ==
            Approx((moved(hp, 0, 0).current - moved(-hp, 0, 0).current) / (2 * hp)).epsilon(1e-3));
      CHECK(
          r.current_gap ==
          Approx((moved(0, 0, hg).current - moved(0, 0, -hg).current) / (2 * hg)).epsilon(1e-4).margin(1e-4));
      CHECK(r.current_gap ==
            Approx((moved(hp, 0, 0).pull - moved(-hp, 0, 0).pull) / (2 * hp)).epsilon(1e-3).margin(1e-3));
      CHECK(r.pull_gap ==
            Approx((moved(0, 0, hg).pull - moved(0, 0, -hg).pull) / (2 * hg)).epsilon(1e-4).margin(1));
      CHECK(r.current_psi > 0);
      if (share == 0) continue;
      const double scale = std::fabs(r.ring_ring) * std::fabs(s.ring) + 1;
      CHECK(r.ring_current ==
            Approx((moved(0, hr, 0).energy - moved(0, -hr, 0).energy) / (2 * hr)).margin(1e-4 * scale));
      CHECK(r.ring_ring ==
            Approx((moved(0, hr, 0).ring_current - moved(0, -hr, 0).ring_current) / (2 * hr)).epsilon(1e-3));
      CHECK(
          r.current_ring ==
          Approx((moved(0, hr, 0).current - moved(0, -hr, 0).current) / (2 * hr)).epsilon(1e-3).margin(1e-2));
      CHECK(r.ring_gap ==
            Approx((moved(0, hr, 0).pull - moved(0, -hr, 0).pull) / (2 * hr)).epsilon(1e-3).margin(1));
    }
  }
}

TEST_CASE("circuit: the energy is what the coil put in, and W is even") {
  const CircuitPotential circuit = reference(0);
  for (const double gap : {0.0, 1e-4, 4e-3}) {
    constexpr int n = 4000;
    const double psi = 1.6;
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += circuit.at({psi * (k + 0.5) / n, 0, gap}).current * psi / n;
    CHECK(circuit.at({psi, 0, gap}).energy == Approx(sum).epsilon(1e-5));
    const auto plus = circuit.at({psi, 0, gap});
    const auto minus = circuit.at({-psi, 0, gap});
    CHECK(plus.energy == minus.energy);
    CHECK(plus.current == -minus.current);
    CHECK(plus.pull == minus.pull);
  }
}

TEST_CASE(
    "circuit: a small gap without iron's share is N^2 mu0 A / g, a pull of B^2 A / mu0 over both poles") {
  MagnetShape s;
  s.ring_share = 0;
  const double residual = 20e-6;
  const CircuitPotential circuit(s, Steel::linear(1e6), 1000, residual, 0, {false});
  const double area = s.centre_width * s.stack;
  const double psi = 1000 * 0.2 * area;  // 0.2 T
  const auto r = circuit.at({psi, 0, 0});
  const double mu0 = 4e-7 * pi;
  // two gaps in series, both of the same area; the edges add 20e-6 (0.26 + ln(1 + 2 flank / g) / pi) / width
  CHECK(r.current == Approx(0.2 * 2 * residual / mu0 / 1000).epsilon(0.02));
  CHECK(r.pull == Approx(2 * 0.2 * 0.2 * area / (2 * mu0)).epsilon(0.03));
}

TEST_CASE("circuit: finite and increasing far beyond saturation and at no gap, bad input named") {
  const CircuitPotential circuit = reference();
  double before = 0;
  for (const double psi : {0.5, 1.0, 2.0, 4.0, 8.0, 50.0}) {
    const auto r = circuit.at({psi, 0.3 * psi / 2000, 0});
    CHECK(std::isfinite(r.energy));
    CHECK(r.current > before);
    before = r.current;
  }
  MagnetShape wrong;
  wrong.coil_width = 30e-3;
  CHECK_THROWS_WITH(CircuitPotential(wrong, builtin_steel("lamination"), 2000, 36e-6),
                    Catch::Contains("coil_width"));
  CHECK_THROWS_WITH(CircuitPotential({}, builtin_steel("lamination"), 2000, 0),
                    Catch::Contains("residual_gap"));
}

TEST_CASE("circuit beside the field in the plane: current and pull of the reference core") {
  MagnetDesign design;
  design.shape.ring_share = 0;
  FieldOptions options;
  options.sizes = sizes_for(0.02);
  MagnetField field(design, options);
  const CircuitPotential circuit(design.shape, design.steel, design.turns, design.residual_gap, 0, {false});
  for (const double gap : {0.5e-3, 4e-3})
    for (const double psi : {0.4, 0.9}) {
      field.set_gap(gap);
      const auto f = field.at_flux(psi, 0).response;
      const auto c = circuit.at({psi, 0, gap});
      CAPTURE(gap, psi, f.current, c.current, f.pull, c.pull);
      CHECK(c.current == Approx(f.current).epsilon(0.15));
      CHECK(c.pull == Approx(f.pull).epsilon(0.25));
    }
}
