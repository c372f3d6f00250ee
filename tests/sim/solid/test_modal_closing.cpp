#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>

#include "core/units.h"
#include "sim/models/modal_closing.h"
#include "sim/models/rigid_closing.h"
#include "sim/specimen/specimen_potential.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

Conditions at(double degrees) {
  Conditions c;
  c.closing_angle = radians(degrees);
  return c;
}

Trajectory close(const Specimen& s, const Conditions& c, const ModalParts& parts, double step,
                 double duration = 0.03) {
  ModalClosingOptions o;
  o.step = step;
  o.duration = duration;
  return modal_closing(s, c, SpecimenPotential(s), parts, o);
}

/// No elastic coordinates at all: places move with the rigid ones.
ModalParts rigid_places(int poles) {
  ModalParts none;
  none.base.shape.resize(static_cast<std::size_t>(2 * poles + 1));
  none.bridge.shape.resize(bridge_places);
  return none;
}

}  // namespace

TEST_CASE("modal closing without elastic coordinates goes to the rigid rung with the step") {
  const Specimen s;
  for (const double angle : {0.0, 60.0, 90.0}) {
    const auto rigid = simulate_rigid(s, at(angle), 0.03, 0, 1e-10, false).truth;
    const auto coarse = close(s, at(angle), rigid_places(3), 0.1).truth;
    const auto fine = close(s, at(angle), rigid_places(3), 0.0125).truth;
    CAPTURE(angle);
    CHECK(std::fabs(*fine.touch - *rigid.touch) < 0.2e-6);  // 90 deg creeps along the edge of the cliff
    CHECK(std::fabs(*fine.touch - *rigid.touch) < 0.1 * std::fabs(*coarse.touch - *rigid.touch));
    CHECK(std::fabs(*fine.core_seat - *rigid.core_seat) < 0.1e-6);
    CHECK(std::fabs(*fine.settled - *rigid.settled) <
          40e-6);  // impacts are of first order, and bounces amplify
    CHECK(fine.openings.size() == rigid.openings.size());
  }
}

TEST_CASE("modal closing with parts of very stiff material is the rigid rung") {
  const Specimen s;
  ModalPartsOptions stiff;
  stiff.stiffness = 1e3;
  const auto rigid = simulate_rigid(s, at(60), 0.02, 0, 1e-10, false).truth;
  const auto modal = close(s, at(60), modal_parts(s, stiff), 0.5, 0.02);
  std::cout << "modal closing, Young's modulus x 1000: settled "
            << 1e6 * (*modal.truth.settled - *rigid.settled) << " us from the rigid rung\n";
  CHECK(std::fabs(*modal.truth.touch - *rigid.touch) < 1e-8);
  CHECK(std::fabs(*modal.truth.core_seat - *rigid.core_seat) < 1e-8);
  CHECK(std::fabs(*modal.truth.settled - *rigid.settled) < 5e-6);
  CHECK(modal.truth.openings.size() == rigid.openings.size());
  CHECK(modal.energy_residual < 1e-3);
}

TEST_CASE(
    "parts of a contactor bend: the base at some 20 kHz, and each place gives way by its own compliance") {
  const Specimen s;
  const ModalParts parts = modal_parts(s);
  REQUIRE(parts.base.modes() > 6);
  REQUIRE(parts.bridge.modes() > 4);
  CHECK(parts.base.omega.front() / (2 * pi) > 5e3);
  // a free bar of the bridge's length and thickness: first bending mode by Euler and Bernoulli, less for its shear
  const double length = 2 * (s.bridges.half_length + 2e-3), width = 6e-3, density = 8960, young = 1.17e11;
  const double thickness = s.bridges.mass / (density * length * width);
  const double beam =
      4.73004074 * 4.73004074 * thickness / (length * length) * std::sqrt(young / (12 * density));
  CHECK(parts.bridge.omega.front() < beam * 1.05);
  CHECK(parts.bridge.omega.front() > beam * 0.7);
  // 1 N at a pad: more attachment modes or more elastic ones do not change how far it gives way beside the inertia
  ModalPartsOptions many;
  many.bridge_modes = 12;
  const auto compliance = [](const ElasticPart& part, std::size_t place) {
    double c = 0;
    for (int r = 0; r < part.modes(); ++r) {
      const auto i = static_cast<std::size_t>(r);
      c += part.shape[place][i] * part.shape[place][i] / (part.omega[i] * part.omega[i]);
    }
    return c;
  };
  CHECK(compliance(parts.bridge, pad_place) ==
        Approx(compliance(modal_parts(s, many).bridge, pad_place)).epsilon(0.01));
}

TEST_CASE("modal closing: half a period later is the same closing, and the coil can be switched off") {
  const Specimen s;
  const ModalParts parts = modal_parts(s);
  const auto a = close(s, at(40), parts, 0.5), b = close(s, at(220), parts, 0.5);
  CHECK(*a.truth.touch == Approx(*b.truth.touch).epsilon(1e-12));
  CHECK(a.truth.openings.size() == b.truth.openings.size());
  Conditions c = at(40);
  c.hold_time = 0.03;
  ModalClosingOptions o;
  o.step = 0.5;
  o.duration = 0.08;
  o.sample = 1e-4;
  const auto r = modal_closing(s, c, SpecimenPotential(s), parts, o);
  const auto plant = simulate(s, c, 0.08, 0).truth;
  REQUIRE(r.samples.size() == 800);
  REQUIRE(r.truth.opened.has_value());
  CHECK(*r.truth.opened == Approx(*plant.opened).margin(20e-6));
  CHECK(r.samples.back().coil_current == 0);
}

TEST_CASE("modal closing takes any potential: the specimen needs no circuit of its own") {
  Specimen s;
  const SpecimenPotential potential(s);
  const ModalParts parts = rigid_places(3);
  ModalClosingOptions o;
  o.duration = 0.02;
  const auto with = modal_closing(s, at(60), potential, parts, o).truth;
  s.lumped = false;  // as of a drawing
  const auto without = modal_closing(s, at(60), potential, parts, o).truth;
  REQUIRE(with.touch.has_value());
  CHECK(*with.touch == *without.touch);
  CHECK(*with.core_seat == *without.core_seat);
}

TEST_CASE("modal closing says what it cannot do") {
  const Specimen s;
  const ModalParts parts = rigid_places(3);
  CHECK_THROWS_WITH(close(s, at(0), parts, 2), Catch::Contains("step = 2.0"));
  Specimen floating;
  floating.base.core_mass = 0.1;
  CHECK_THROWS_WITH(close(floating, at(0), parts, 0.5), Catch::Contains("core_mass_g"));
  ModalPartsOptions soft;
  soft.stiffness = 0;
  CHECK_THROWS_WITH(modal_parts(s, soft), Catch::Contains("stiffness = 0"));
}
