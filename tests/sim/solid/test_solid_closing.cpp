#include <catch2/catch.hpp>
#include <iostream>

#include "sim/closing.h"
#include "sim/solid/solid_closing.h"
#include "sim/specimen_potential.h"

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

TEST_CASE(
    "a closing with deforming parts: rigid flight follows the lumped model, its energy is accounted for",
    "[.slow]") {
  const Specimen specimen;
  Conditions conditions;
  conditions.closing_angle = radians(90);
  const SpecimenPotential field(specimen);
  SolidClosingOptions options;
  options.cell = 4e-3;
  options.end = 19e-3;
  options.solid.energy_bound = 0.05;
  const SolidClosingResult r = solid_closing(specimen, conditions, field, options);
  const double touch = *simulate(specimen, conditions, 0.04, 0).truth.touch;
  std::cout << "closing, " << r.cells << " cells: first touch " << 1e3 * r.first_touch << " ms, lumped "
            << 1e3 * touch << " ms, openings " << r.openings << ", peak " << r.peak_force << " N, residual "
            << r.residual << "\n";
  CHECK(r.first_touch == Approx(touch).epsilon(0.04));
  CHECK(r.deformed_steps > 0);
  CHECK(r.residual < 0.05);
}
