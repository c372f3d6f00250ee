#include "sim/study/steady.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/magnetic_circuit.h"
#include "sim/specimen_potential.h"

namespace powbench::sim {
namespace {

struct Rates {
  double phi = 0, phi2 = 0;
};

struct HeldCoil {
  double turns;
  MagneticCircuit circuit;
  ReluctanceOf<OneNumber> gap;
  double resistance;
  double inductance;  ///< in series with the core, H

  double ring_flux(double phi, double phi2) const {
    return circuit.has_ring() ? phi2 : circuit.shaded_share() * phi;
  }
  POWBENCH_EQUATION Field field(double phi, double phi2) const {
    return circuit_field(circuit.numbers(), gap, circuit.iron(phi / circuit.area()), phi,
                         ring_flux(phi, phi2));
  }
  /// N phi' + L i' = u - R i, phi2' = -R_sh i_sh.
  POWBENCH_EQUATION Rates rates(double u, double phi, double phi2) const {
    const Field f = field(phi, phi2);
    const bool ring = circuit.has_ring();
    Rates r;
    r.phi2 = ring ? -circuit.ring_resistance() * f.ring_current : 0.0;
    const double slope = ring ? f.mmf_phi : f.mmf_phi + circuit.shaded_share() * f.mmf_phi2;
    const double ratio = inductance / turns;
    r.phi = (u - resistance * f.mmf / turns - ratio * f.mmf_phi2 * r.phi2) / (turns + ratio * slope);
    return r;
  }
};

HeldCoil held_at(const Specimen& s, const Mains& mains, double separation) {
  require_circuit(s);
  const MagneticCircuit circuit(s.magnet, s.core.travel);
  return {s.coil.turns, circuit, reluctance<OneNumber>(circuit.numbers(), separation),
          s.coil.resistance + mains.resistance, s.coil.leakage + mains.inductance};
}

/// Fluxes from rest, `phase` behind the voltage's positive-going zero, with the classical Runge-Kutta method;
/// `visit(t, phi, phi2)` after every step. At least `steps` a period, more where the ring is faster; returns their
/// number.
template <class Visit>
int run(const HeldCoil& held, const Mains& mains, double phase, int periods, double steps, Visit&& visit) {
  const Field unit = circuit_field(held.circuit.numbers(), held.gap, held.circuit.iron(0), 0.0, 1.0);
  const double ring_rate = held.circuit.ring_resistance() * unit.ring_current;
  const double fastest = held.circuit.has_ring() ? ring_rate : 0.0;
  const int per_period = static_cast<int>(std::max(steps, fastest / mains.hertz));
  const double h = 1 / (mains.hertz * per_period);
  const auto voltage = [&](double t) {
    return std::numbers::sqrt2 * mains.volts * std::sin(2 * pi * mains.hertz * t + phase);
  };
  double phi = 0;
  double phi2 = 0;
  for (int k = 0; k < periods * per_period; ++k) {
    const double t = k * h, middle = voltage(t + h / 2);
    const Rates a = held.rates(voltage(t), phi, phi2);
    const Rates b = held.rates(middle, phi + h / 2 * a.phi, phi2 + h / 2 * a.phi2);
    const Rates c = held.rates(middle, phi + h / 2 * b.phi, phi2 + h / 2 * b.phi2);
    const Rates d = held.rates(voltage(t + h), phi + h * c.phi, phi2 + h * c.phi2);
    phi += h / 6 * (a.phi + 2 * b.phi + 2 * c.phi + d.phi);
    phi2 += h / 6 * (a.phi2 + 2 * b.phi2 + 2 * c.phi2 + d.phi2);
    visit(t + h, phi, phi2);
  }
  return per_period;
}

}  // namespace

double steady_current(const Specimen& s, const Mains& mains, double separation) {
  constexpr int periods = 3;
  const HeldCoil held = held_at(s, mains, separation);
  const double from = (periods - 1 + 1e-9) / mains.hertz;
  double squares = 0;
  const int steps = run(held, mains, pi / 2, periods, 800, [&](double t, double phi, double phi2) {
    if (t <= from) return;
    const double i = held.field(phi, phi2).mmf / held.turns;
    squares += i * i;
  });
  return std::sqrt(squares / steps);
}

double least_pull(const Specimen& s, const Mains& mains) {
  constexpr int periods = 5;
  const HeldCoil held = held_at(s, mains, 0);
  double least = std::numeric_limits<double>::infinity();
  run(held, mains, 0, periods, 200, [&](double t, double phi, double phi2) {
    if (t * mains.hertz < 0.5) return;
    least = std::min(least, held.field(phi, phi2).pull);
  });
  return least;
}

double closed_load(const Specimen& s) {
  const double overtravel = s.core.travel - s.bridges.gap;
  return s.core.return_preload + s.core.return_rate * s.core.travel +
         s.bridges.poles * (s.bridges.preload + s.bridges.rate * overtravel);
}

}  // namespace powbench::sim
