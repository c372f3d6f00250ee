#include <catch2/catch.hpp>
#include <iostream>

#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/models/mechanics.h"
#include "sim/models/solid_closing.h"
#include "sim/specimen/specimen_potential.h"

using namespace powbench;
using namespace powbench::sim;

TEST_CASE("the mesh of the contactor has the specimen's masses and gaps") {
  const Specimen specimen;
  const ContactorMesh c = contactor_mesh(specimen, 3e-3);
  check_mesh(c.mesh);
  std::vector<double> mass(c.mesh.parts.size(), 0.0);
  for (const auto& cell : c.mesh.cells) {
    const auto part = static_cast<std::size_t>(cell.part);
    mass[part] += c.materials[part].density * cell_volume(c.mesh, cell);
  }
  CHECK(mass[static_cast<std::size_t>(c.mover)] == Approx(specimen.core.mass).epsilon(1e-9));
  CHECK(mass[static_cast<std::size_t>(c.base)] == Approx(specimen.base.mass).epsilon(1e-9));
  REQUIRE(c.bridges.size() == static_cast<std::size_t>(specimen.bridges.poles));
  for (const int b : c.bridges)
    CHECK(mass[static_cast<std::size_t>(b)] == Approx(specimen.bridges.mass).epsilon(1e-9));
  Specimen light;
  light.base.mass = 1e-3;
  CHECK_THROWS_WITH(contactor_mesh(light, 3e-3), Catch::Contains("base.mass_g"));
  CHECK_THROWS_WITH(contactor_mesh(specimen, 1), Catch::Contains("cell"));
}

TEST_CASE("the lumped circuit as a potential: current and pull are derivatives of its energy") {
  const Specimen specimen;
  const SpecimenPotential field(specimen);
  const MagneticState at{0.5, 1e-5, 1e-3};
  const auto energy = [&](double psi, double ring, double gap) { return field.at({psi, ring, gap}).energy; };
  const MagneticResponse r = field.at(at);
  CHECK(r.current == Approx((energy(0.5001, 1e-5, 1e-3) - energy(0.4999, 1e-5, 1e-3)) / 2e-4).epsilon(1e-5));
  CHECK(r.pull == Approx((energy(0.5, 1e-5, 1.001e-3) - energy(0.5, 1e-5, 0.999e-3)) / 2e-6).epsilon(1e-4));
  CHECK(r.ring_current ==
        Approx((energy(0.5, 1.01e-5, 1e-3) - energy(0.5, 0.99e-5, 1e-3)) / 2e-7).epsilon(1e-4).margin(1e-3));
}

namespace {

SolidClosingResult closing(double cell, double end, bool deform) {
  Conditions conditions;
  conditions.closing_angle = radians(90);
  const Specimen specimen;
  const SpecimenPotential field(specimen);
  SolidClosingOptions options;
  options.cell = cell;
  options.end = end;
  options.deform = deform;
  options.solid.energy_bound = 1e-3;
  return solid_closing(specimen, conditions, field, options);
}

double lumped_touch() {
  Conditions conditions;
  conditions.closing_angle = radians(90);
  return *simulate(Specimen{}, conditions, 0.04, 0).truth.touch;
}

}  // namespace

TEST_CASE("at switch-on every part of the contactor is in balance with springs, seats and rest") {
  const Specimen specimen;
  Conditions dead;
  dead.supply_volts = 0;
  const SpecimenPotential field(specimen);
  SolidClosingOptions options;
  options.cell = 6e-3;
  options.end = 1e-3;
  const auto r = solid_closing(specimen, dead, field, options);
  for (const auto& s : r.samples) {
    CHECK(std::fabs(s.travel) < 1e-12);
    for (const double bridge : s.bridges) CHECK(std::fabs(bridge) < 1e-12);
  }
}

TEST_CASE("undeformed, a closing of the bodies is that of the lumped model, opening by opening, and balances",
          "[.slow]") {
  Conditions conditions;
  conditions.closing_angle = radians(90);
  const auto lumped = simulate(Specimen{}, conditions, 0.04, 0).truth;
  const SolidClosingResult r = closing(10e-3, 24e-3, false);
  std::cout << "closing, undeformed: first touch " << 1e3 * r.first_touch << " ms, lumped "
            << 1e3 * *lumped.touch << " ms, residual " << r.residual << ", of the coil "
            << r.electric.residual() / r.electric.supplied << "\n";
  const SolidClosingResult first = closing(6e-3, 18e-3, false);
  CHECK(first.first_touch == Approx(lumped_touch()).epsilon(3e-4));
  CHECK(first.residual < 1e-5);
  CHECK(std::fabs(first.electric.residual()) < 1e-6 * first.electric.supplied);
  CHECK(r.first_touch == Approx(*lumped.touch).margin(5e-6));
  CHECK(r.core_seat == Approx(*lumped.core_seat).margin(5e-6));
  CHECK(r.last_touch == Approx(*lumped.settled).margin(10e-6));
  REQUIRE(r.open.size() == lumped.openings.size());
  for (std::size_t k = 0; k < r.open.size(); ++k) {
    std::cout << "  opening " << 1e3 * r.open[k][0] << " .. " << 1e3 * r.open[k][1] << " ms, lumped "
              << 1e3 * lumped.openings[k].release << " .. " << 1e3 * lumped.openings[k].touch << "\n";
    CHECK(r.open[k][0] == Approx(lumped.openings[k].release).margin(10e-6));
    CHECK(r.open[k][1] == Approx(lumped.openings[k].touch).margin(10e-6));
  }
  CHECK(r.residual < 2e-5);
  CHECK(std::fabs(r.electric.residual()) < 1e-6 * r.electric.supplied);
}

TEST_CASE("as a rung, a closing of the bodies sees ambient and polarity once", "[.slow]") {
  Case c;
  c.conditions.closing_angle = radians(90);
  c.conditions.ambient = 313.15;
  c.conditions.polarity = -1;
  const auto rung = scene_rung(circuit_field(), "deformable");
  const double bodies = *rung.run(c, 20e-3, 10, 0).truth.touch,
               lumped = *simulate(c.specimen, c.conditions, 0.03, 0).truth.touch;
  Case cold = c;
  cold.conditions.ambient = 293.15;
  const double at_20 = *simulate(cold.specimen, cold.conditions, 0.03, 0).truth.touch;
  std::cout << "ambient 40 degC: touch " << 1e3 * bodies << " ms, lumped " << 1e3 * lumped
            << " ms, at 20 degC " << 1e3 * at_20 << " ms\n";
  CHECK(std::fabs(lumped - at_20) > 50e-6);
  CHECK(bodies == Approx(lumped).margin(15e-6));
}

TEST_CASE("a closing with deforming parts: first touch, bounce and energy do not depend on the cells",
          "[.slow]") {
  const SolidClosingResult coarse = closing(6e-3, 21e-3, true), fine = closing(4e-3, 21e-3, true);
  for (const auto* r : {&coarse, &fine})
    std::cout << "closing, " << r->cells << " cells: first touch " << 1e3 * r->first_touch << " ms, openings "
              << r->openings << ", peak " << r->peak_force << " N, residual " << r->residual << "\n";
  CHECK(fine.deformed_steps > 0);
  CHECK(fine.first_touch == Approx(lumped_touch()).epsilon(1e-3));
  CHECK(fine.first_touch == Approx(coarse.first_touch).epsilon(1e-4));
  CHECK(fine.openings == coarse.openings);
  CHECK(fine.peak_force == Approx(coarse.peak_force).epsilon(0.02));
  CHECK(fine.residual < 1e-4);
  CHECK(coarse.residual < 1e-4);
}
