// The energy ledger of the rigid rung, with a given pull and with a coil, and what happens when it does not close.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/mechanics/reference_closing.h"
#include "sim/models/rigid_closing.h"
#include "tests/sim/mechanics/gap_inductance.h"

using namespace powbench::sim;

TEST_CASE("the ledger of the reference closing", "[mechanics]") {
  for (const double tolerance : {1e-8, 1e-10}) {
    RigidOptions o;
    o.tolerance = tolerance;
    const auto run = run_rigid(powbench::bench::reference_closing(), {}, o);
    REQUIRE(run.completed);
    std::printf("  closing at %.0e: energy residual %.1e\n", tolerance, run.energy_residual);
    CHECK(run.energy_residual < (tolerance < 1e-9 ? 1e-9 : 1e-7));
    CHECK(run.energies.contact_loss > 1e-3);
    CHECK(run.energies.damping > 1e-4);
    CHECK(run.energies.kinetic < 1e-3);
  }
}

TEST_CASE("a ledger that passes its bound stops the run with a dump", "[mechanics]") {
  RigidOptions o;
  o.tolerance = 1e-3;
  o.energy_bound = 1e-12;
  const auto run = run_rigid(powbench::bench::reference_closing(), {}, o);
  CHECK_FALSE(run.completed);
  CHECK(run.reached < 0.06);
  CHECK_THAT(run.dump, Catch::Contains("energy ledger does not close") && Catch::Contains("y[33]") &&
                           Catch::Contains("contact 0: depth"));
  o.tolerance = 1;
  CHECK_THROWS_WITH(run_rigid(powbench::bench::reference_closing(), {}, o),
                    Catch::Contains("tolerance = 1, allowed"));
}

TEST_CASE("the six stages of the reference closing", "[mechanics]") {
  RigidOptions o;
  o.ledger = false;
  const auto run = run_rigid(powbench::bench::reference_closing(), {}, o);
  REQUIRE(run.stages.size() == 6);
  for (const auto& s : run.stages)
    std::printf("  %-10s from %8.3f ms\n", std::string(stage_name(s.stage)).c_str(), s.begin * 1e3);
  for (std::size_t k = 1; k < 6; ++k) {
    CHECK(static_cast<int>(run.stages[k].stage) == static_cast<int>(k));
    CHECK(run.stages[k].begin > run.stages[k - 1].begin);
  }
  CHECK(run.stages[4].begin == Approx(29.002637e-3).epsilon(1e-6));
}

TEST_CASE("coil and magnetics in the same state vector: the ledger closes over supply, coil and contacts",
          "[mechanics]") {
  GapInductance potential;
  CoilDrive drive;
  drive.potential = &potential;
  drive.resistance = 60;
  drive.supply.mains.volts = 230;
  RigidOptions o;
  o.tolerance = 1e-9;
  const auto run = run_rigid(powbench::bench::reference_closing(), drive, o);
  REQUIRE(run.completed);
  std::printf("  with a coil: supplied %.4f J, residual %.1e, %zu events\n", run.energies.supplied,
              run.energy_residual, run.events.size());
  CHECK(run.energies.supplied > 0.1);
  CHECK(run.energies.magnetic > 0);
  CHECK(run.stages.size() >= 5);
  CHECK(run.energy_residual < 1e-7);
}

TEST_CASE("every contact law closes its ledger", "[mechanics]") {
  const ContactLaw laws[] = {
      {1e8, 1.5, DampingForm::none, 0, 0},          {1e8, 1.5, DampingForm::lankarani_nikravesh, 0.7, 0},
      {1e8, 1.5, DampingForm::flores, 0.7, 0},      {1e8, 1.5, DampingForm::ramped, 50, 2e-5},
      {1e8, 1.5, DampingForm::linear, 50, 0},       {5e5, 1, DampingForm::linear, 20, 0},
      {1e10, 2, DampingForm::hunt_crossley, 0.6, 0}};
  for (const auto& law : laws) {
    auto parts = powbench::bench::reference_closing();
    parts.pad = law;
    RigidOptions o;
    o.tolerance = 1e-9;
    o.end = 0.032;
    const auto run = run_rigid(parts, {}, o);
    CAPTURE(static_cast<int>(law.form), law.exponent, run.dump);
    CHECK(run.completed);
    CHECK(run.energy_residual < 2e-6);
    CHECK(run.stages.size() >= 4);
  }
}

TEST_CASE("core friction sticks without creep and slides with its exact loss", "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  parts.core_friction = 0.5;
  RigidOptions o;
  o.tolerance = 1e-9;
  const auto run = run_rigid(parts, {}, o);
  CHECK(run.completed);
  std::printf("  with 0.5 N of friction: residual %.1e, lost by friction %.4f J\n", run.energy_residual,
              run.energies.friction);
  CHECK(run.energies.friction > 0.5 * 4.9e-3);
  CHECK(run.stages.size() >= 5);
  CHECK(run.energy_residual < 1e-6);
}

TEST_CASE("a coil that is switched off ends the closing: what opens later is no bounce of it",
          "[mechanics]") {
  powbench::Conditions c;
  c.closing_angle = 1;
  c.hold_time = 0.06;
  const auto held = simulate_rigid({}, c, 0.1, 0);
  c.hold_time = 1;
  const auto closed = simulate_rigid({}, c, 0.1, 0);
  REQUIRE(held.truth.opened);
  const auto begin = [](const Trajectory& t) {
    for (const auto& s : t.stages)
      if (s.stage == ClosingStage::closed) return s.begin;
    return -1.0;
  };
  CHECK(begin(held) > 0);
  CHECK(begin(held) == begin(closed));
  CHECK(begin(held) < c.hold_time);
}

TEST_CASE("contact laws, bending, tilt and buffer of a specimen file close and balance their energy",
          "[mechanics]") {
  powbench::Conditions c;
  c.closing_angle = 1;
  const auto touch_of = [&](const Specimen& s) {
    const auto t = simulate_rigid(s, c, 0.06, 0, 1e-8);  // with the ledger: throws where it does not balance
    REQUIRE(t.truth.touch);
    REQUIRE(t.truth.core_seat);
    CHECK(t.energy_residual < 1e-6);
    return std::array{*t.truth.touch, *t.truth.settled};
  };
  const auto plain = touch_of({});
  Specimen hertz;
  hertz.bridges.contact_exponent = hertz.core.stop_exponent = 1.5;
  Specimen bending;
  bending.base.flex_modes = 3;
  Specimen tilting;
  tilting.core.tilt_inertia = 3e-5;
  tilting.bridges.pitch = 14e-3;
  tilting.bridges.gap_spread = 20e-6;
  Specimen level = tilting;
  level.core.tilt_inertia = 0;
  Specimen all = hertz;
  all.base = bending.base;
  all.base.core_mass = 0.15;
  all.core.tilt_inertia = 3e-5;
  all.bridges.pitch = 14e-3;
  CHECK(touch_of(hertz)[1] != plain[1]);
  CHECK(touch_of(bending)[1] != plain[1]);
  CHECK(touch_of(tilting)[1] != touch_of(level)[1]);
  CHECK(touch_of(all)[0] > 0.005);
  // the plant knows none of them, and says so with the key
  for (const auto& [s, key] :
       {std::pair{hertz, "bridges.contact_exponent"}, std::pair{bending, "base.flex_modes"},
        std::pair{tilting, "core.tilt_inertia_g_mm2"}})
    CHECK_THROWS_WITH(simulate(s, c, 0.06, 0), Catch::Contains(key) && Catch::Contains("--mechanics rigid"));
  hertz.bridges.contact_exponent = 1.3;
  CHECK_THROWS_WITH(simulate_rigid(hertz, c, 0.06, 0),
                    Catch::Contains("contact_exponent = 1.3, allowed 1, 1.5 and 2"));
}
