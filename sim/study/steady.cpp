#include "sim/study/steady.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/specimen/specimen_potential.h"

namespace powbench::sim {
namespace {

typedef double V2 __attribute__((vector_size(16)));
typedef std::int64_t M2 __attribute__((vector_size(16)));

/// Two places of the core, side by side; everything else is alike.
struct TwoNumbers {
  using Basis = TwoNumbers;
  using Number = V2;
  using Stored = double;
  using Mask = M2;
  static POWBENCH_EQUATION V2 at(double stored) { return all(stored); }
  static POWBENCH_EQUATION V2 all(double x) { return V2{x, x}; }
  template <class A, class B>
  static POWBENCH_EQUATION V2 choose(M2 first, const A& a, const B& b) {
    const V2 one = a(), other = b();
    return first ? one : other;
  }
};

POWBENCH_EQUATION IronOf<OneNumber> iron_of(const MagneticCircuit& c, double b) {
  return c.iron(b);
}
POWBENCH_EQUATION IronOf<TwoNumbers> iron_of(const MagneticCircuit& c, V2 b) {
  if (c.even_power() >= 0)
    return law_iron<TwoNumbers>(c.numbers(), even_power_of<TwoNumbers>(c.even_power(), b), b);
  const IronOf<OneNumber> p = c.iron(b[0]), q = c.iron(b[1]);
  return {V2{p.mmf, q.mmf}, V2{p.slope, q.slope}, V2{p.energy, q.energy}, V2{p.steep, q.steep}};
}

/// The coil on the mains, at one place of the core or at two.
template <class Of>
struct HeldCoil {
  using T = typename Of::Number;
  struct Rates {
    T phi, phi2;
  };

  double turns;
  MagneticCircuit circuit;
  ReluctanceOf<Of> gap;
  double resistance;
  double inductance;  ///< in series with the core, H

  POWBENCH_EQUATION T ring_flux(T phi, T phi2) const {
    return circuit.has_ring() ? phi2 : circuit.shaded_share() * phi;
  }
  POWBENCH_EQUATION FieldOf<Of> field(T phi, T phi2) const {
    return circuit_field<Of>(circuit.numbers(), gap, iron_of(circuit, phi / circuit.area()), phi,
                             ring_flux(phi, phi2));
  }
  /// N phi' + L i' = u - R i, phi2' = -R_sh i_sh.
  POWBENCH_EQUATION Rates rates(T u, T phi, T phi2) const {
    const FieldOf<Of> f = field(phi, phi2);
    const bool ring = circuit.has_ring();
    Rates r;
    r.phi2 = ring ? -circuit.ring_resistance() * f.ring_current : Of::all(0.0);
    const T slope = ring ? f.mmf_phi : f.mmf_phi + circuit.shaded_share() * f.mmf_phi2;
    const double ratio = inductance / turns;
    r.phi = (u - resistance * f.mmf / turns - ratio * f.mmf_phi2 * r.phi2) / (turns + ratio * slope);
    return r;
  }
  /// One step of the classical Runge-Kutta method with the voltage at its beginning, middle and end.
  POWBENCH_EQUATION void step(T h, T from, T middle, T to, T& phi, T& phi2) const {
    const Rates a = rates(from, phi, phi2);
    const Rates b = rates(middle, phi + h / 2 * a.phi, phi2 + h / 2 * a.phi2);
    const Rates c = rates(middle, phi + h / 2 * b.phi, phi2 + h / 2 * b.phi2);
    const Rates d = rates(to, phi + h * c.phi, phi2 + h * c.phi2);
    phi += h / 6 * (a.phi + 2.0 * b.phi + 2.0 * c.phi + d.phi);
    phi2 += h / 6 * (a.phi2 + 2.0 * b.phi2 + 2.0 * c.phi2 + d.phi2);
  }
};

HeldCoil<OneNumber> held_at(const Specimen& s, const Mains& mains, double separation) {
  require_circuit(s);
  const MagneticCircuit circuit(s.magnet, s.core.travel);
  return {s.coil.turns, circuit, reluctance<OneNumber>(circuit.numbers(), separation),
          s.coil.resistance + mains.resistance, s.coil.leakage + mains.inductance};
}

/// Of a period: at least `least`, more where the ring is faster.
int steps_of(const HeldCoil<OneNumber>& held, const Mains& mains, double least) {
  const Field unit = circuit_field(held.circuit.numbers(), held.gap, held.circuit.iron(0), 0.0, 1.0);
  const double ring_rate = held.circuit.ring_resistance() * unit.ring_current;
  const double fastest = held.circuit.has_ring() ? ring_rate : 0.0;
  return static_cast<int>(std::max(least, fastest / mains.hertz));
}

double voltage_at(const Mains& mains, double phase, double t) {
  return std::numbers::sqrt2 * mains.volts * std::sin(2 * pi * mains.hertz * t + phase);
}

/// Fluxes from rest, `phase` behind the voltage's positive-going zero; `visit(t, phi, phi2)` after every step.
template <class Visit>
void run(const HeldCoil<OneNumber>& held, const Mains& mains, double phase, int periods, int per_period,
         Visit&& visit) {
  const double h = 1 / (mains.hertz * per_period);
  const auto voltage = [&](double t) { return voltage_at(mains, phase, t); };
  double phi = 0;
  double phi2 = 0;
  for (int k = 0; k < periods * per_period; ++k) {
    const double t = k * h;
    held.step(h, voltage(t), voltage(t + h / 2), voltage(t + h), phi, phi2);
    visit(t + h, phi, phi2);
  }
}

constexpr int settling = 3;             ///< periods; the last one counts
constexpr double settling_steps = 800;  ///< of a period
constexpr double settling_phase = pi / 2;

double settled_from(const Mains& mains) {
  return (settling - 1 + 1e-9) / mains.hertz;
}

}  // namespace

double steady_current(const Specimen& s, const Mains& mains, double separation) {
  const HeldCoil<OneNumber> held = held_at(s, mains, separation);
  const int steps = steps_of(held, mains, settling_steps);
  double squares = 0;
  run(held, mains, settling_phase, settling, steps, [&](double t, double phi, double phi2) {
    if (t <= settled_from(mains)) return;
    const double i = held.field(phi, phi2).mmf / held.turns;
    squares += i * i;
  });
  return std::sqrt(squares / steps);
}

/// One step waits for the one before, so that two places side by side take hardly longer than one.
SteadyCurrents steady_currents(const Specimen& s, const Mains& mains) {
  const HeldCoil<OneNumber> open = held_at(s, mains, s.core.travel), closed = held_at(s, mains, 0);
  const ReluctanceOf<OneNumber>&p = open.gap, &q = closed.gap;
  const HeldCoil<TwoNumbers> both{open.turns,
                                  open.circuit,
                                  {V2{p.r, q.r}, V2{p.slope, q.slope}, V2{p.bend, q.bend}},
                                  open.resistance,
                                  open.inductance};
  const int steps[2] = {steps_of(open, mains, settling_steps), steps_of(closed, mains, settling_steps)};
  const double h[2] = {1 / (mains.hertz * steps[0]), 1 / (mains.hertz * steps[1])};
  const double from = settled_from(mains);
  double ends[2] = {0, 0};  // s, of the latest step: mostly the beginning of the next one to the bit
  V2 phi{}, phi2{}, squares{}, begin{}, middle{}, end{};
  for (int k = 0; k < settling * std::max(steps[0], steps[1]); ++k) {
    M2 counts{};
    for (int l = 0; l < 2; ++l) {
      if (k >= settling * steps[l]) continue;  // this one has ended: its numbers go on and count no more
      const double t = k * h[l];
      if (k == 0 || t != ends[l]) end[l] = voltage_at(mains, settling_phase, t);
      begin[l] = end[l];
      middle[l] = voltage_at(mains, settling_phase, t + h[l] / 2);
      ends[l] = t + h[l];
      end[l] = voltage_at(mains, settling_phase, ends[l]);
      counts[l] = ends[l] <= from ? 0 : -1;
    }
    both.step(V2{h[0], h[1]}, begin, middle, end, phi, phi2);
    if ((counts[0] | counts[1]) == 0) continue;
    const V2 i = both.field(phi, phi2).mmf / both.turns;
    squares = counts ? squares + i * i : squares;
  }
  return {std::sqrt(squares[0] / steps[0]), std::sqrt(squares[1] / steps[1])};
}

double least_pull(const Specimen& s, const Mains& mains) {
  constexpr int periods = 5;
  const HeldCoil<OneNumber> held = held_at(s, mains, 0);
  double least = std::numeric_limits<double>::infinity();
  run(held, mains, 0, periods, steps_of(held, mains, 200), [&](double t, double phi, double phi2) {
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
