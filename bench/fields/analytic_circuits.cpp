#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>

#include "bench/fields/analytic.h"
#include "bench/fields/shaded_pole.h"
#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/grid.h"
#include "sim/magnetics/plane/newton.h"

namespace powbench::bench {
namespace {

using namespace sim;

/// Flux of one winding at a current.
double flux_at(const FieldProblem& p, double current) {
  Newton newton(p);
  std::vector<double> a(static_cast<std::size_t>(p.size()) + 1, 0), currents;
  newton.solve({{false, current, 0}}, a, currents);
  double psi = 0;
  for (std::size_t k = 0; k < a.size(); ++k) psi += p.winding(0)[k] * a[k];
  return std::fabs(psi);
}

/// A slab of steel between two sheets of current: H is the sheet's, B follows from the curve.
AnalyticResult close_coil(const char* name, double h) {
  constexpr double half = 5e-3, sheet = 0.1e-3, height = 2e-3;
  FieldSetup f;
  f.steels = {builtin_steel(name)};
  f.steel_of_region = {0, -1};
  f.windings = {{{{1, 1.0}}}};
  const FieldProblem p(
      tensor_mesh({0, half / 2, half, half + sheet}, {0, height},
                  [&](double x, double) { return x < half ? 0 : 1; }, {true, false, false, false}),
      f);
  double low = 0, high = 6;
  for (int k = 0; k < 100; ++k) (f.steels[0].h(0.5 * (low + high)) < h ? low : high) = 0.5 * (low + high);
  char text[80];
  std::snprintf(text, sizeof text, "steel %s in a close coil, %g A/m", name, h);
  // the field falls linearly through the sheet
  return {text, "flux, Wb/m", low * half + mu0 * h * sheet / 3, flux_at(p, h * height), p.size()};
}

/// Poles of infinite permeability, the coil between them fills what the aperture leaves: no fringing at all.
AnalyticResult window_frame(double gap) {
  constexpr double aperture = 20e-3, coil = 8e-3, current = 1000;
  FieldSetup f;
  f.windings = {{{{1, 1.0}}}};
  const FieldProblem p(
      tensor_mesh({0, aperture / 2, aperture, aperture + coil / 2, aperture + coil}, {0, gap},
                  [&](double x, double) { return x < aperture ? 0 : 1; }, {true, false, false, false}),
      f);
  char text[80];
  std::snprintf(text, sizeof text, "magnet with a gap of %g mm, coil from pole to pole", gap * 1e3);
  return {text, "flux, Wb/m", mu0 * current / gap * (aperture + coil / 3), flux_at(p, current), p.size()};
}

/// Two gaps side by side, one behind a ring: W = Rm1 (psi - phi_s)^2 / 2 + Rm2 phi_s^2 / 2, one turn.
class TwoGaps final : public MagneticPotential {
 public:
  TwoGaps(double area, double gap) : area_(area), reluctance_(gap / (mu0 * area)) {}
  bool has_ring() const override { return true; }
  MagneticResponse at(const MagneticState& s) const override {
    const double free = s.psi - s.ring;
    MagneticResponse r;
    r.energy = 0.5 * reluctance_ * (free * free + s.ring * s.ring);
    r.current = reluctance_ * free;
    r.ring_current = reluctance_ * (s.ring - free);
    r.pull = (free * free + s.ring * s.ring) / (2 * mu0 * area_);
    r.current_psi = reluctance_;
    r.current_ring = -reluctance_;
    r.ring_ring = 2 * reluctance_;
    return r;
  }

 private:
  double area_, reluctance_;
};

TransientSetup held(double step, double duration) {
  TransientSetup s;
  s.resistance = 0;
  s.moves = false;
  s.step = step;
  s.duration = duration;
  return s;
}

/// Without resistance psi swings from 0 to V/w (1 + |cos angle|).
AnalyticResult inrush(double degrees) {
  constexpr double volts = 311.127, omega = 2 * pi * 50;
  auto s = held(10e-6, 40e-3);
  s.voltage = [=](double t) { return volts * std::sin(omega * t + radians(degrees)); };
  double most = 0;
  for (const auto& sample : run_transient(TwoGaps(60e-6, 0.05e-3), s).samples)
    most = std::max(most, std::fabs(sample.psi));
  char text[80];
  std::snprintf(text, sizeof text, "switch-on at %g deg, no resistance", degrees);
  return {text, "largest psi, Wb", volts / omega * (1 + std::fabs(std::cos(radians(degrees)))), most, 0};
}

void shaded_gaps(std::vector<AnalyticResult>& all) {
  constexpr double area = 60e-6, gap = 0.05e-3, ohm = 0.15e-3, flux = 1e-4, hertz = 50;
  constexpr double omega = 2 * pi * hertz;
  auto s = held(10e-6, 0.3);
  s.ring_resistance = ohm;
  s.voltage = [](double t) { return omega * flux * std::cos(omega * t); };
  const auto found = by_time(hertz, 1, s, run_transient(TwoGaps(area, gap), s));
  // phi1 Rm = phi2 (Rm + j w / R), phi1 + phi2 given
  const double reluctance = gap / (mu0 * area);
  const std::complex<double> ratio(1, omega / (ohm * reluctance));
  const std::complex<double> phi2 = flux / (1.0 + ratio), phi1 = phi2 * ratio;
  const double mean = (std::norm(phi1) + std::norm(phi2)) / (4 * mu0 * area),
               swing = std::abs(phi1 * phi1 + phi2 * phi2) / (4 * mu0 * area);
  const std::string name = "shaded pole of two gaps, 50 Hz";
  all.push_back({name, "lag, deg", std::arg(ratio) * 180 / pi, found.lag, 0});
  all.push_back({name, "mean pull, N", mean, found.mean_pull, 0});
  all.push_back({name, "least pull, N", mean - swing, found.least_pull, 0});
}

}  // namespace

std::vector<AnalyticResult> circuit_cases() {
  std::vector<AnalyticResult> all;
  for (const double h : {100., 2000., 1e5}) all.push_back(close_coil("reference", h));
  all.push_back(close_coil("team13", 1000));
  for (const double gap : {5e-3, 0.1e-3}) all.push_back(window_frame(gap));
  for (const double degrees : {0., 30., 60., 90.}) all.push_back(inrush(degrees));
  shaded_gaps(all);
  return all;
}

}  // namespace powbench::bench
