#include "bench/sim_euler_peer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/commanded_phase.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/mechanics/contact_damping.h"

namespace powbench::bench {
namespace {

struct Stop {
  double stiffness, damping;
  double force(double pen, double rate) const {
    return pen > 0 ? std::max(0.0, stiffness * pen + damping * rate) : 0.0;
  }
};

}  // namespace

EulerClosing euler_closing(const sim::Specimen& s, const Conditions& c, double duration, double h) {
  const auto& core = s.core;
  const auto& b = s.bridges;
  const double n = b.poles;
  const double omega = 2 * pi * c.mains_hertz;
  const double phase = commanded_phase(c);
  const double amplitude = std::numbers::sqrt2 * c.supply_volts;
  const double resistance = s.coil.resistance * (1 + s.coil.temperature_coefficient * (c.ambient - 293.15));
  const double base_omega = 2 * pi * s.base.hertz;
  const sim::MagneticCircuit circuit(s.magnet, core.travel);
  const Stop stop{core.stop_stiffness, sim::stop_damping(s)};
  const Stop contact{b.contact_stiffness, sim::pad_damping(s)};
  const Stop seat{b.seat_stiffness, sim::seat_damping(s)};
  const double open_depth = core.return_preload / core.stop_stiffness;
  const double seat_depth = b.preload / b.seat_stiffness;

  EulerClosing result;
  double phi = 0, phi2 = 0, x = 0, v = 0, z = 0, w = 0, y = 0, q = 0;
  bool touching = false;
  const auto total = static_cast<long>(std::llround(duration / h));
  for (long k = 0; k < total; ++k) {
    const double t = static_cast<double>(k) * h;
    const double separation = core.travel - (x - z);
    const auto f = circuit.field(phi, phi2, separation);
    const double ring_rate = -s.magnet.ring_resistance * f.ring_current;
    const double ratio = s.coil.leakage / s.coil.turns;
    const double voltage = amplitude * std::sin(omega * t + phase);
    const double other = f.mmf_phi2 * ring_rate + f.mmf_separation * (w - v);
    const double flux_rate =
        (voltage - resistance * f.mmf / s.coil.turns - ratio * other) / (s.coil.turns + ratio * f.mmf_phi);

    const double f_stop = stop.force(-separation, v - w);
    const double f_open = stop.force(open_depth - x, -v);
    const double f_seat = seat.force(seat_depth + y - x, q - v);
    const double f_contact = contact.force(y - z - b.gap, q - w);
    const double spring = b.preload + b.rate * (x - y);
    double on_core =
        f.pull - core.return_preload - core.return_rate * x + f_open - f_stop + n * (f_seat - spring);
    const double on_base = -f.pull + f_stop + n * f_contact -
                           s.base.mass * (base_omega * base_omega * z + 2 * s.base.damping * base_omega * w);
    // Friction: the force that would stop the core within the step, limited to the Coulomb force.
    on_core -= std::clamp(on_core + core.mass * v / h, -core.friction, core.friction);

    phi += h * flux_rate;
    phi2 += h * ring_rate;
    v += h * on_core / core.mass;
    w += h * on_base / s.base.mass;
    q += h * (spring - f_seat - f_contact) / b.mass;
    x += h * v;
    z += h * w;
    y += h * q;

    const double now = t + h;
    const bool closed = y - z - b.gap > 0 && contact.force(y - z - b.gap, q - w) > 0;
    if (closed && !touching) {
      if (result.touch < 0)
        result.touch = now;
      else
        ++result.openings;
      result.settled = now;
    }
    touching = closed;
    if (result.seat < 0 && x - z > core.travel) result.seat = now;
  }
  result.steps = total;
  return result;
}

}  // namespace powbench::bench
