// Conical and stepped faces, and the permanent magnet: against FreeFem++ on its own mesh, virtual work and reciprocity.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/solenoid_field.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

FieldOptions mesh_of(double accuracy) {
  FieldOptions o;
  o.sizes = sizes_for(accuracy);
  return o;
}

SolenoidDesign conical() {
  SolenoidDesign d;
  d.shape.face = PlungerFace::conical;
  d.shape.cone_angle = pi / 4;
  d.shape.tip_radius = 2e-3;
  return d;
}

SolenoidDesign stepped() {
  SolenoidDesign d;
  d.shape.face = PlungerFace::stepped;
  d.shape.step_radius = 4e-3;
  d.shape.step_depth = 3e-3;
  d.shape.step_clearance = 0.5e-3;
  return d;
}

/// Slope of the energy by the gap at this flux, over the pull: 1.
double virtual_work(SolenoidField& field, double gap, double psi) {
  const double step = 0.01 * gap;
  const auto at = [&](double g) {
    field.set_gap(g);
    return field.at_flux(psi).response;
  };
  const double high = at(gap + step).energy, low = at(gap - step).energy;
  return (high - low) / (2 * step) / at(gap).pull;
}

}  // namespace

TEST_CASE("the pull on a conical and a stepped face is the slope of the energy, to the error of the mesh") {
  for (const auto& design : {conical(), stepped()}) {
    SolenoidField field(design, mesh_of(5e-3));
    for (const double gap : {0.5e-3, 3e-3, 7e-3})
      for (const double psi : {0.05, 0.3}) {
        INFO("face " << static_cast<int>(design.shape.face) << ", gap " << gap * 1e3 << " mm, " << psi
                     << " Wb");
        CHECK(virtual_work(field, gap, psi) == Approx(1).epsilon(8e-3));
      }
  }
}

TEST_CASE("a conical solenoid beside FreeFem++ on its own mesh: flux and pull to half a percent") {
  // quadratic elements for r A, 27 000 to 34 000 unknowns; `bench_fields_solenoid` runs it. At 1 A
  struct Row {
    double gap, flux, pull;
  };
  SolenoidField field(conical(), mesh_of(2e-3));
  for (const Row& row :
       {Row{0.5e-3, 0.369314, 123.902}, Row{3e-3, 0.175816, 21.6457}, Row{8e-3, 0.0794653, 4.51907}}) {
    INFO("gap " << row.gap * 1e3 << " mm");
    field.set_gap(row.gap);
    const auto p = field.at_current(1);
    CHECK(field.flux(p) == Approx(row.flux).epsilon(5e-3));
    CHECK(p.response.pull == Approx(row.pull).epsilon(5e-3));
  }
}

TEST_CASE("a cone of 45 degrees pulls less than a flat face near the stop and more far from it") {
  SolenoidField flat({}, mesh_of(0.02)), cone(conical(), mesh_of(0.02));
  const auto pull = [](SolenoidField& f, double gap) {
    f.set_gap(gap);
    return f.at_current(1).response.pull;
  };
  CHECK(pull(cone, 0) < 0.7 * pull(flat, 0));
  CHECK(pull(cone, 8e-3) > 1.3 * pull(flat, 8e-3));
}

TEST_CASE(
    "a permanent magnet: flux by reciprocity with the coil, polarity, pull as the slope of the energy") {
  SolenoidDesign d;
  d.steel = Steel::linear(800);
  d.shape.magnet_length = 4e-3;
  d.remanence = 0.6;
  SolenoidField with(d, mesh_of(5e-3));
  d.remanence = 0;
  SolenoidField without(d, mesh_of(5e-3));
  for (const double gap : {0.0, 4e-3}) {
    with.set_gap(gap);
    without.set_gap(gap);
    // linkage of the magnet = B_r / (mu0 mu_r) int B_z dV of one ampere over the magnet
    const auto unit = without.at_current(1);
    const auto& space = without.problem().space();
    double sum = 0;
    for (std::size_t t = 0; t < space.mesh.triangle.size(); ++t) {
      if (space.mesh.region[t] != SolenoidRegion::magnet) continue;
      for (const auto& p : shape_points(space, t, 4))
        for (int n = 0; n < space.nodes; ++n)
          sum += p.weight * p.curl_y[static_cast<std::size_t>(n)] *
                 unit.a[static_cast<std::size_t>(space.unknowns(t)[n])];
    }
    const double expected = 0.6 / (mu0 * d.magnet_permeability) * sum;
    CHECK(with.flux(with.at_current(0)) == Approx(expected).epsilon(1e-6));
    // linear iron: with current the linkages add up
    CHECK(with.flux(with.at_current(1)) == Approx(expected + without.flux(unit)).epsilon(1e-6));
    CHECK(with.at_current(1).response.pull > with.at_current(-1).response.pull);
  }
  CHECK(virtual_work(with, 4e-3, 0.1) == Approx(1).epsilon(8e-3));
  Team team(1);
  d.remanence = 0.6;
  CHECK_THROWS_AS(build_table(d, TableOptions{}, team), std::invalid_argument);
}

TEST_CASE("faces that cannot be are told with key, value and range") {
  using Catch::Matchers::Contains;
  const auto refuse = [](SolenoidDesign d, auto change, const char* text) {
    change(d);
    CHECK_THROWS_WITH(SolenoidField(d, mesh_of(0.02)), Contains(text) && Contains("allowed"));
  };
  refuse(
      conical(), [](auto& d) { d.shape.cone_angle = 1.4; }, "cone_angle_deg = 80");
  refuse(
      conical(), [](auto& d) { d.shape.tip_radius = 8e-3; }, "tip_radius_mm = 8");
  refuse(
      conical(), [](auto& d) { d.shape.cone_angle = 70 * pi / 180; }, "cone_depth_mm");
  refuse(
      conical(), [](auto& d) { d.shape.step_depth = 1e-3; }, "step_depth_mm = 1");
  refuse(
      stepped(), [](auto& d) { d.shape.step_clearance = 5e-3; }, "step_radius_mm");
  refuse(
      stepped(), [](auto& d) { d.shape.step_depth = 13e-3; }, "step_depth_mm = 13");
  refuse(
      {}, [](auto& d) { d.shape.magnet_length = 14e-3; }, "magnet_length_mm = 14");
  refuse(
      {}, [](auto& d) { d.remanence = 0.3; }, "remanence_T = 0.3");
}
