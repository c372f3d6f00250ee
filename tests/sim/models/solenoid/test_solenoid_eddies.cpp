// Eddy currents in the solid parts of a solenoid: diffusion into a cylinder, the frame of the plunger, the energy.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/solenoid_field.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

FieldOptions coarse_grid(double accuracy) {
  FieldOptions o;
  o.sizes = sizes_for(accuracy);
  return o;
}

TransientSetup pull_in(double conductivity) {
  TransientSetup s;
  s.voltage = [](double) { return 24.0; };
  s.resistance = 9;
  s.mass = 0.07;
  s.counter_force = [](double gap) { return 5 + 300 * (10e-3 - gap); };
  s.start_gap = 10e-3;
  s.step = 400e-6;
  s.duration = 24e-3;
  s.iron_conductivity = conductivity;
  return s;
}

}  // namespace

TEST_CASE("a step of current diffuses into a long cylinder as Bessel's series does") {
  // no iron: mu0 everywhere; a thin case far outside. psi of an infinite coil is N^2 i mu0 pi / l times its mean
  // squared radius less what the cylinder still keeps out: R^2 sum of 4 / j_n^2 exp(-j_n^2 t / tau), tau = mu0 sigma
  // R^2
  SolenoidDesign d;
  d.steel = Steel::linear(1);
  auto& s = d.shape;
  s.plunger_radius = 15e-3;
  s.bore_radius = 15.5e-3;
  s.coil_inner = 15.6e-3;
  s.coil_outer = 16e-3;
  s.case_inner = 100e-3;
  s.case_outer = 100.05e-3;
  s.window = 300e-3;
  s.stop_length = 30e-3;
  s.coil_clearance = 0.1e-3;
  s.plate = s.flange = 0.05e-3;
  s.plunger_length = 280e-3;
  d.residual_gap = 1e-6;
  d.largest_gap = 1e-3;
  constexpr double sigma = 5e6, r = 1e6, current = 1;
  const double tau = mu0 * sigma * s.plunger_radius * s.plunger_radius;
  TransientSetup t;
  t.voltage = [&](double) { return r * current; };
  t.resistance = r;
  t.moves = false;
  t.start_gap = 0;
  t.step = tau / 100;
  t.duration = 0.4 * tau;
  t.iron_conductivity = sigma;
  const auto run = run_transient(d, coarse_grid(0.02), t);
  SolenoidField still(d, coarse_grid(0.02));
  still.set_gap(0);
  const double whole = still.flux(still.at_current(current)),
               mean_square = (15.6e-3 * 15.6e-3 + 15.6e-3 * 16e-3 + 16e-3 * 16e-3) / 3;
  constexpr std::array<double, 6> roots{2.404825558, 5.520078110, 8.653727913,
                                        11.79153444, 14.93091771, 18.07106397};
  for (const double share : {0.05, 0.1, 0.2, 0.35}) {
    double kept = 0;
    for (const double j : roots) kept += 4 / (j * j) * std::exp(-j * j * (share + 0.005));
    const double expected = 1 - kept * s.plunger_radius * s.plunger_radius / mean_square;
    const auto k = static_cast<std::size_t>(share * 100);
    INFO("t = " << share << " tau");
    // the series is of an infinite coil; this one is 9 diameters long
    // a step of current makes the ends of the steps swing about their middles, which the rule gets right
    const double middle = 0.5 * (run.samples[k - 1].psi + run.samples[k].psi);
    CHECK(middle / whole == Approx(expected).margin(0.015));
  }
}

TEST_CASE("a field that moves with the plunger is carried along without change") {
  SolenoidDesign d;
  d.shape.face = PlungerFace::conical;
  d.shape.cone_angle = pi / 6;
  SolenoidField field(d, coarse_grid(0.02), 1e6);
  const double from = 9e-3, to = 2.5e-3;
  const auto wave = [](double r, double above) { return r * (1 + 40 * above + 900 * above * above); };
  field.set_gap(from);
  const auto& space = field.problem().space();
  std::vector<double> a(static_cast<std::size_t>(space.size()) + 1, 0), exact = a;
  for (std::size_t k = 0; k + 1 < a.size(); ++k) a[k] = wave(space.node_x[k], space.node_y[k] - from);
  field.set_gap(to);
  for (std::size_t k = 0; k + 1 < a.size(); ++k) exact[k] = wave(space.node_x[k], space.node_y[k] - to);
  const auto carried = field.carry(a, from);
  double worst = 0;
  for (std::size_t t = 0; t < space.mesh.triangle.size(); ++t)
    if (space.mesh.region[t] == SolenoidRegion::plunger)
      for (int n = 0; n < space.nodes; ++n) {
        const auto u = static_cast<std::size_t>(space.unknowns(t)[n]);
        worst = std::max(worst, std::fabs(carried[u] - exact[u]));
      }
  CHECK(worst < 1e-12);
}

TEST_CASE("what stands still keeps its vertices while the plunger moves") {
  SolenoidField field({}, coarse_grid(0.02));
  field.set_gap(10e-3);
  const auto before = field.problem().space().mesh;
  field.set_gap(0.5e-3);
  const auto& after = field.problem().space().mesh;
  double worst = 0;
  for (std::size_t t = 0; t < before.triangle.size(); ++t)
    if (before.region[t] == SolenoidRegion::fixed_iron)
      for (const int v : before.triangle[t])
        worst = std::max(
            worst, std::fabs(before.y[static_cast<std::size_t>(v)] - after.y[static_cast<std::size_t>(v)]));
  CHECK(worst < 1e-15);
}

TEST_CASE("eddy currents delay a pull-in, vanish with the conductivity, and keep the energy", "[.slow]") {
  const auto run = [](double conductivity) {
    return run_transient(SolenoidDesign{}, coarse_grid(0.02), pull_in(conductivity));
  };
  const auto none = run(0), little = run(1), iron = run(6e6);
  REQUIRE(none.closed_at > 0);
  CHECK(little.closed_at == Approx(none.closed_at).epsilon(1e-4));
  CHECK(little.energy.eddy_loss < 1e-6);
  CHECK(iron.closed_at > 1.02 * none.closed_at);
  CHECK(iron.energy.eddy_loss > 0.02 * iron.energy.supplied);
  CHECK(std::fabs(iron.energy.residual()) < 1e-2);
}
