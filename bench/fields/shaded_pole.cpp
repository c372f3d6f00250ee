#include "bench/fields/shaded_pole.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "bench/fields/harmonic.h"
#include "core/units.h"
#include "sim/magnetics/plane/core_mesh.h"

namespace powbench::bench {
namespace {

using namespace sim;
using Complex = std::complex<double>;
using Complexes = std::vector<Complex>;

/// The magnet with its ring as a conductor; windings: coil, ring, the ring's inner side, its outer side.
FieldProblem conducting(const ShadedCase& c) {
  FieldSetup f = magnet_problem(c.design, c.options).setup();
  f.conductivity.assign(CoreRegion::count, 0);
  for (const int side : {CoreRegion::ring_inner, CoreRegion::ring_outer}) {
    f.conductivity[static_cast<std::size_t>(side)] = c.copper;
    f.windings.push_back({{{side, 1.0}}});
  }
  FieldProblem p(core_mesh(c.design.shape, c.options.sizes, c.options.largest_gap), f);
  p.set_gap(c.design.residual_gap);
  return p;
}

double section(const FieldProblem& p, int region) {
  return region_area(p.space().mesh, region);
}

Complex along(const std::vector<double>& c, const Complexes& a) {
  Complex sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += c[k] * a[k];
  return sum;
}

double degrees_behind(Complex late, Complex early) {
  return std::arg(early / late) * 180 / pi;
}

}  // namespace

ShadedCase::ShadedCase() {
  design.steel = Steel::linear(2000);
  options.sizes = sizes_for(2e-3);
}

double ring_resistance(const ShadedCase& c) {
  const FieldProblem p = conducting(c);
  return p.setup().depth / c.copper *
         (1 / section(p, CoreRegion::ring_inner) + 1 / section(p, CoreRegion::ring_outer));
}

ShadedPole by_phasors(const ShadedCase& c) {
  const FieldProblem p = conducting(c);
  const Harmonic field(p, c.hertz);
  const double inner = section(p, CoreRegion::ring_inner), outer = section(p, CoreRegion::ring_outer),
               depth = p.setup().depth;
  const auto& coil = p.winding(0);
  const std::size_t n = coil.size();
  std::vector<double> side(n);  // integral of A over both sides of the ring, times the depth
  for (std::size_t k = 0; k < n; ++k) side[k] = inner * p.winding(2)[k] + outer * p.winding(3)[k];
  Complexes load(n);
  for (std::size_t k = 0; k < n; ++k) load[k] = c.copper * side[k];
  const auto by_ring = field.solve(load), by_coil = field.solve(Complexes(coil.begin(), coil.end()));
  // no net current: (inner + outer) depth g = j w side . a;   j w coil . a + R I = U
  const Complex jw(0, 2 * pi * c.hertz);
  const Complex a11 = (inner + outer) * depth - jw * along(side, by_ring), a12 = -jw * along(side, by_coil),
                a21 = jw * along(coil, by_ring), a22 = jw * along(coil, by_coil) + c.resistance;
  const Complex det = a11 * a22 - a12 * a21;
  const Complex g = -a12 * c.volts / det, current = a11 * c.volts / det;
  std::vector<double> u(n), v(n), force(n);
  Complexes a(n);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    a[k] = g * by_ring[k] + current * by_coil[k];
    u[k] = a[k].real();
    v[k] = a[k].imag();
  }
  const auto pull = [&](const std::vector<double>& x, const std::vector<double>& y) {
    p.gap_gradient(x.data(), force.data());
    double sum = 0;
    for (std::size_t k = 0; k + 1 < n; ++k) sum += 0.5 * y[k] * force[k];
    return sum;
  };
  const double uu = pull(u, u), vv = pull(v, v), uv = pull(u, v);
  const Complex ring = along(p.winding(1), a), whole = along(coil, a) / c.design.turns;
  return {degrees_behind(ring, whole - ring), 0.5 * (uu + vv) - std::hypot(0.5 * (uu - vv), uv),
          0.5 * (uu + vv)};
}

TransientSetup shaded_setup(const ShadedCase& c, double step, int periods) {
  TransientSetup s;
  const double omega = 2 * pi * c.hertz;
  // cosine: near the steady state of an inductance from the start
  s.voltage = [omega, volts = c.volts](double t) { return volts * std::cos(omega * t); };
  s.resistance = c.resistance;
  s.ring_resistance = ring_resistance(c);
  s.moves = false;
  s.start_gap = 0;
  s.step = step;
  s.duration = periods / c.hertz;
  return s;
}

ShadedPole by_time(double hertz, double turns, const TransientSetup& s, const TransientResult& r) {
  const double omega = 2 * pi * hertz;
  const auto period = static_cast<std::size_t>(std::lround(1 / (hertz * s.step)));
  Complex psi = 0, ring_current = 0;
  ShadedPole out;
  out.least_pull = 1e300;
  for (std::size_t k = r.samples.size() - period; k < r.samples.size(); ++k) {
    const auto& sample = r.samples[k];
    const double middle = sample.time - 0.5 * s.step;  // of the step: where currents and pull are
    psi += sample.psi * std::polar(1.0, -omega * sample.time);
    ring_current += sample.ring_current * std::polar(1.0, -omega * middle);
    out.least_pull = std::min(out.least_pull, sample.pull);
    out.mean_pull += sample.pull / static_cast<double>(period);
  }
  const Complex ring = -s.ring_resistance * ring_current / Complex(0, omega);
  out.lag = degrees_behind(ring, psi / turns - ring);
  return out;
}

}  // namespace powbench::bench
