// Coil and magnetic circuit against closed forms.

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <vector>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/models/plant.h"

using namespace powbench::sim;
using powbench::pi;

namespace {

/// A contactor whose core, base and bridges cannot move: only the circuit is left.
Specimen locked() {
  Specimen s;
  s.core.return_preload = 5000;
  s.core.friction = 1000;
  s.base.mass = 1000;
  s.base.hertz = 3000;
  s.base.damping = 1;
  return s;
}

double reluctance(const Magnet& m, double gap) {
  return gap / (mu0 * m.pole_area * (1 + m.fringing * gap / std::sqrt(m.pole_area)));
}

}  // namespace

TEST_CASE("RL circuit, sine switched on at an angle: current against the closed form") {
  Specimen s = locked();
  s.magnet.shaded_share = 0;
  s.magnet.bh_power = 0;
  Mains mains;
  const double r = reluctance(s.magnet, s.core.travel + s.magnet.residual_gap);
  const double iron = s.magnet.bh_linear * s.magnet.iron_length / s.magnet.pole_area;
  const double inductance = s.coil.leakage + s.coil.turns * s.coil.turns / (iron + 2 * r);
  const double omega = 2 * pi * mains.hertz;
  const double impedance = std::hypot(s.coil.resistance, omega * inductance);
  const double lag = std::atan2(omega * inductance, s.coil.resistance);
  for (const double angle : {0.0, 0.9, 2.0, 4.0}) {
    mains.phase = angle;
    Plant plant(s, mains, {1e-10, 293.15});
    plant.gate(true);
    std::vector<double> times;
    for (int k = 1; k <= 100; ++k) times.push_back(6e-4 * k);
    std::vector<PlantSample> out(times.size());
    plant.advance(0.06, times, out);
    const double amplitude = std::sqrt(2.0) * mains.volts / impedance;
    for (const auto& p : out) {
      const double expected =
          amplitude * (std::sin(omega * p.time + angle - lag) -
                       std::sin(angle - lag) * std::exp(-s.coil.resistance / inductance * p.time));
      CHECK(p.coil_current == Approx(expected).margin(1e-7 * amplitude));
      CHECK(p.flux_linkage == Approx(inductance * expected).margin(1e-7 * inductance * amplitude));
    }
  }
}

TEST_CASE("coil resistance follows the temperature") {
  Specimen s = locked();
  s.magnet.bh_power = 0;
  s.coil.leakage = 0;
  s.coil.turns = 300;  // little inductance: at the crest of the mains i = u / R(T)
  Mains mains;
  mains.resistance = 10;
  Plant plant(s, mains, {1e-9, 353.15});
  plant.gate(true);
  const double t = 5e-3;
  PlantSample p;
  plant.advance(t, {&t, 1}, {&p, 1});
  const double warm = s.coil.resistance * (1 + s.coil.temperature_coefficient * 60);
  CHECK(p.coil_current == Approx(p.mains_voltage / (warm + 10)).epsilon(1e-3));
  CHECK(p.coil_voltage == Approx(p.mains_voltage - 10 * p.coil_current).epsilon(1e-12));
}

TEST_CASE("shading ring: flux behind the ring against the phasor solution") {
  Specimen s = locked();
  s.magnet.bh_power = 0;
  s.coil.resistance = 2000;  // lets the switch-on transient die out
  Mains mains;
  Plant plant(s, mains, {1e-10, 293.15});
  plant.gate(true);
  const double g = s.core.travel + s.magnet.residual_gap;
  const double r = reluctance(s.magnet, g);
  const double iron = s.magnet.bh_linear * s.magnet.iron_length / s.magnet.pole_area;
  // Pole parts in parallel behind the common path: 1/R1 + 1/(R2 + j w / R_sh).
  using C = std::complex<double>;
  const double omega = 2 * pi * mains.hertz;
  const C bare = r / (1 - s.magnet.shaded_share);
  const C shaded = C(r / s.magnet.shaded_share, omega / s.magnet.ring_resistance);
  const C total = iron + r + 1.0 / (1.0 / bare + 1.0 / shaded);
  const C impedance =
      s.coil.resistance + C(0, omega) * (s.coil.leakage + s.coil.turns * s.coil.turns / total);
  const C current = std::sqrt(2.0) * mains.volts / impedance;
  for (const double t : {0.2501, 0.2537, 0.2593}) {
    PlantSample p;
    plant.advance(t, {&t, 1}, {&p, 1});
    const double expected = std::imag(current * std::polar(1.0, omega * t));
    CHECK(p.coil_current == Approx(expected).margin(1e-6 * std::abs(current)));
  }
}

TEST_CASE("pull is the derivative of the stored energy at constant flux, current its derivative by flux") {
  const Specimen s;
  const MagneticCircuit circuit(s.magnet, s.core.travel);
  REQUIRE(circuit.has_ring());
  for (const double separation : {-20e-6, 0.5e-3, 2e-3, 3.8e-3})
    for (const double phi : {1e-5, 2e-4, 4e-4})
      for (const double phi2 : {-5e-5, 1e-4}) {
        const auto f = circuit.field(phi, phi2, separation);
        const double ds = 1e-8;
        const double slope = (circuit.field(phi, phi2, separation + ds).energy -
                              circuit.field(phi, phi2, separation - ds).energy) /
                             (2 * ds);
        const double dp = 1e-9;
        const double mmf = (circuit.field(phi + dp, phi2, separation).energy -
                            circuit.field(phi - dp, phi2, separation).energy) /
                           (2 * dp);
        const double ring = (circuit.field(phi, phi2 + dp, separation).energy -
                             circuit.field(phi, phi2 - dp, separation).energy) /
                            (2 * dp);
        const double mmf_phi =
            (circuit.field(phi + dp, phi2, separation).mmf - circuit.field(phi - dp, phi2, separation).mmf) /
            (2 * dp);
        CHECK(f.pull == Approx(slope).epsilon(2e-5));
        CHECK(f.mmf == Approx(mmf).epsilon(1e-6).margin(1e-6));
        CHECK(f.ring_current == Approx(ring).epsilon(1e-6).margin(1e-3));
        CHECK(f.mmf_phi == Approx(mmf_phi).epsilon(1e-5));
      }
}

TEST_CASE("saturation law: whole odd exponents take the same values as the power function") {
  Magnet whole;
  Magnet nearly = whole;
  nearly.bh_exponent = 11 + 1e-12;
  const MagneticCircuit a(whole, 3.85e-3);
  const MagneticCircuit b(nearly, 3.85e-3);
  for (const double phi : {-5e-4, -1e-4, 0.0, 3e-4, 4.4e-4})
    CHECK(a.field(phi, 1e-4, 1e-3).mmf == Approx(b.field(phi, 1e-4, 1e-3).mmf).epsilon(1e-10).margin(1e-9));
}

TEST_CASE("the gap stays positive however hard the faces are pressed") {
  const Specimen s;
  const MagneticCircuit circuit(s.magnet, s.core.travel);
  CHECK(circuit.gap(0) == s.magnet.residual_gap);
  CHECK(circuit.gap(1e-3) == Approx(s.magnet.residual_gap + 1e-3));
  CHECK(circuit.gap(-1e-3) > 0);
  CHECK((circuit.gap(1e-9) - circuit.gap(0)) / (circuit.gap(0) - circuit.gap(-1e-9)) ==
        Approx(1).epsilon(1e-3));
}

TEST_CASE(
    "the flux behind a leakage inductance solves its equation to rounding, down to the smallest numbers") {
  constexpr double turns = 1200, ratio = 0.4 / turns;
  for (const double exponent : {1.5, 11.0, 8.3})
    for (const char* steel : {"", "m530-50a"})
      for (const double share : {0.0, 0.648}) {
        Specimen s;
        s.magnet.bh_exponent = exponent;
        s.magnet.shaded_share = share;
        s.magnet.steel = steel;
        const MagneticCircuit circuit(s.magnet, s.core.travel);
        for (const double psi : {0.0, 5e-324, 1e-310, 1e-120, 1e-20, 1e-6, 0.02, 0.3, 0.6, 2.0, -0.6})
          for (const double gap : {-20e-6, 0.0, 1e-3, 3.8e-3}) {
            CAPTURE(exponent, steel, share, psi, gap);
            const double ring = 0.3 * psi / turns;
            const double phi = circuit.flux(psi, turns, ratio, ring, gap);
            const double phi2 = circuit.has_ring() ? ring : share * phi;
            const double leak = ratio * circuit.field(phi, phi2, gap).mmf;
            CHECK(std::fabs(turns * phi + leak - psi) <= 4e-15 * std::fabs(psi) + 1e-300);
          }
      }
}
