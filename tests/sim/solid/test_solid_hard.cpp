// Hard cases of the bodies: numbers at the end of their range, runs that must stop, the limit of the penalty, threads.

#include <catch2/catch.hpp>
#include <cstring>
#include <iostream>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "core/units.h"
#include "sim/models/solid_closing.h"
#include "sim/solid/flush_denormals.h"
#include "sim/specimen/specimen_potential.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench;
using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

SolidMaterial small_steel() {
  SolidMaterial m;
  m.small_displacement = true;
  return m;
}

/// A bar of 200 cells, struck at its end.
std::vector<double> struck(double speed, int steps, int workers) {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {0.2, 1e-3, 1e-3}, 200, 1, 1);
  SolidOptions o;
  o.ledger_every = 0;
  o.workers = workers;
  o.dt = 5e-9;
  ExplicitSolid s(mesh, {small_steel()}, o);
  for (const int n : {0, 201, 402, 603}) s.set_node_velocity(n, {speed, 0, 0});
  for (int k = 0; k < steps; ++k) s.step();
  return s.displacements();
}

}  // namespace

TEST_CASE("denormals are zero in the loops over cells alone, and the results are the same") {
#ifdef __SSE2__
  const unsigned before = _mm_getcsr();
  {
    const FlushDenormals in_here;
    CHECK((_mm_getcsr() & 0x8040) == 0x8040);
  }
  CHECK((_mm_getcsr() & 0x8040) == (before & 0x8040));
#endif
  // ahead of the front displacements fall by the hundredth from cell to cell, down to nothing
  const int steps = 120;
  const auto plain = struck(1, steps, 1), two = struck(1, steps, 2);
  const double scale = std::ldexp(1.0, 300);
  const auto large = struck(scale, steps, 1);  // the same numbers, none of them denormal
  long tiny = 0, equal = 0, other = 0;
  double least = 1;
  for (std::size_t k = 0; k < plain.size(); ++k) {
    const double size = std::fabs(plain[k]);
    tiny += size > 0 && size < 1e-250;
    if (size > 0) least = std::min(least, size);
    if (size < 1e-280 && std::fabs(large[k]) / scale < 1e-280) continue;
    (plain[k] * scale == large[k] ? equal : other) += 1;
  }
  std::cout << "denormals: smallest displacement " << least << " m, " << tiny << " below 1e-250, " << equal
            << " equal to the bit, " << other << " not\n";
  CHECK(tiny > 0);
  CHECK(equal > 100);
  CHECK(other == 0);
  CHECK(plain == two);
  volatile double smallest = 4.9e-324;
  CHECK(smallest * 1 > 0);  // here they still are what they were
#ifdef __SSE2__
  CHECK((_mm_getcsr() & 0x8040) == (before & 0x8040));
#endif
}

TEST_CASE("forces in float and places in double: flight at 5 cm loses nothing, a rebound hardly anything") {
  // in float 5 cm are known to 3.7e-9 m: 4 % of a step of 1e-7 m
  const auto run = [](bool in_float, bool hits) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("bar"), {0.05, 0.05, 0.05}, {0.053, 0.053, 0.07}, 3, 3, 20);
    SolidOptions o;
    o.float_forces = in_float;
    auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{SolidMaterial{}}, o);
    s->set_velocity(0, {0, 0, -0.7});
    if (hits) s->add_plane(0, {0, 0, 0.05}, {0, 0, 1}, 0.65);
    const double end = hits ? 12e-6 : 2e-4;
    s->run_until(end);
    return s;
  };
  const auto flight = run(true, false);
  const double moved = flight->mean_displacement(0).z, meant = -0.7 * flight->time();
  const auto coarse = run(true, true), precise = run(false, true);
  const double apart = coarse->mean_velocity(0).z - precise->mean_velocity(0).z;
  std::cout << "float forces: " << flight->steps() << " steps of flight off by " << moved / meant - 1
            << ", rebound " << coarse->mean_velocity(0).z << " m/s, in double " << precise->mean_velocity(0).z
            << ", residual " << coarse->energies().residual() / coarse->energies().start << "\n";
  CHECK(std::fabs(moved / meant - 1) < 1e-12);
  CHECK(precise->mean_velocity(0).z > 0.6);
  CHECK(std::fabs(apart) < 1e-6);
  CHECK(std::fabs(coarse->energies().residual()) < 2e-3 * coarse->energies().start);
}

TEST_CASE("a cell that turns inside out stops the run, whatever it is made of") {
  for (const bool tets : {false, true})
    for (const double yield : {1e9, std::numeric_limits<double>::infinity()}) {
      SolidMesh hexes;
      add_box(hexes, hexes.add_part("box"), {0, 0, 0}, {1, 1, 3}, 1, 1, 3);
      const SolidMesh mesh = tets ? tetrahedra_of(hexes) : hexes;
      SolidMaterial m = material(1e6, 0.3, 1000);
      m.yield = yield;
      SolidOptions options;
      options.energy_bound = 1e9;
      ExplicitSolid s(mesh, {m}, options);
      for (int n = 4; n < 8; ++n) s.set_node_velocity(n, {0, 0, 3000});
      const auto run = [&] {
        for (int k = 0; k < 1000; ++k) s.step();
      };
      CHECK_FALSE(s.stopped());
      try {
        run();
        FAIL("went on");
      } catch (const SolidStop& stop) {
        CAPTURE(tets, yield, stop.what());
        CHECK(s.stopped());
        REQUIRE(stop.cell >= 0);
        CHECK(stop.cell / (tets ? 6 : 1) == 1);
        CHECK(stop.time == s.time());
        CHECK(std::string(stop.what()).find("cell " + std::to_string(stop.cell)) == 0);
        SolidMesh bent = mesh;  // the state is the one in which it is inside out
        for (std::size_t n = 0; n < bent.nodes.size(); ++n)
          bent.nodes[n] += s.displacement(static_cast<int>(n));
        CHECK_FALSE(cell_volume(bent, bent.cells[static_cast<std::size_t>(stop.cell)]) > 0);
      }
    }
}

TEST_CASE("an energy residual above its bound stops the run and says both") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {2e-3, 2e-3, 2e-2}, 2, 2, 20);
  SolidOptions options;
  options.ledger_every = 20;
  options.energy_bound = 1e-6;
  ExplicitSolid s(mesh, {SolidMaterial{}}, options);
  s.set_velocity(0, {0, 0, -1});
  s.add_plane(0, {0, 0, 0}, {0, 0, 1}, 0.65);
  try {
    s.run_until(20e-6);
    FAIL("went on");
  } catch (const SolidStop& stop) {
    std::cout << "stopped: " << stop.what() << "\n";
    CHECK(s.stopped());
    CHECK(stop.cell == -1);
    CHECK(std::string(stop.what()).find("energy residual") == 0);
    CHECK(std::string(stop.what()).find("allowed is 0.000001") != std::string::npos);
    CHECK(std::fabs(s.energies().residual()) > 1e-6 * s.energies().start);
  }
  options.energy_bound = 0;
  CHECK_THROWS_WITH(ExplicitSolid(mesh, {SolidMaterial{}}, options),
                    Catch::Contains("energy_bound = 0") && Catch::Contains("> 0"));
}

TEST_CASE("penalty that bounds the step: 0.99 of the limit is stable, 1.01 is not and is refused") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("a"), {0, 0, 0}, {2e-3, 2e-3, 2e-3}, 1, 1, 2);
  add_box(mesh, mesh.add_part("b"), {0, 0, 2e-3}, {2e-3, 2e-3, 4e-3}, 1, 1, 2);
  ContactPair pair{0, 1};
  pair.factor = 10;
  const auto pressed = [&](double dt) {
    SolidOptions o;
    o.dt = dt;
    o.energy_bound = 1e6;
    SolidMaterial m = small_steel();
    m.damping = 1e5;  // comes to rest pressed: nodes that switch are another matter
    auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>(2, m), o);
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
      if (mesh.nodes[static_cast<std::size_t>(n)].z < 1e-9) s->fix(n, true, true, true);
    s->add_load({s->whole_part(1), {}});
    return s;
  };
  double limit = 0;
  {
    const auto s = pressed(0);
    s->set_contact({{pair}});
    limit = s->critical_step();
    CHECK(limit < 0.8 * pressed(0)->critical_step());  // the penalty bounds it
  }
  const auto refused = pressed(1.01 * limit);
  refused->set_contact({{pair}});
  CHECK_THROWS_WITH(refused->step(), Catch::Contains("dt = ") && Catch::Contains("contacts"));
  const auto left = [&](double dt) {  // J, kinetic, long after the load came
    const auto s = pressed(dt);
    s->step();  // the step is judged here: without the contact it is a good one
    s->set_contact({{pair}});
    for (int k = 0; k < 12000; ++k) {
      s->set_force(0, {0, 0, -1e3 * std::min(1.0, k / 6000.0)});
      s->step();
    }
    s->ask_energies();
    s->step();
    return s->energies().kinetic;
  };
  const double stable = left(0.99 * limit), wild = left(1.01 * limit);
  std::cout << "penalty limit " << limit * 1e9 << " ns: kinetic energy left at 0.99 " << stable
            << " J, at 1.01 " << wild << " J\n";
  CHECK(stable < 1e-12);
  CHECK(wild > 1e-3);
}

namespace {

SolidClosingResult short_closing(int workers) {
  Conditions conditions;
  conditions.closing_angle = radians(90);
  const Specimen specimen;
  const SpecimenPotential field(specimen);
  SolidClosingOptions options;
  options.cell = 6e-3;
  options.end = 17.4e-3;
  options.flight_step = 2e-6;
  options.workers = workers;
  return solid_closing(specimen, conditions, field, options);
}

}  // namespace

TEST_CASE("a closing with deforming parts: one and two threads give the same bits") {
  const SolidClosingResult one = short_closing(1), two = short_closing(2);
  REQUIRE(one.deformed_steps > 500);
  REQUIRE(one.first_touch > 0);
  CHECK(one.first_touch == two.first_touch);
  CHECK(one.last_touch == two.last_touch);
  CHECK(one.peak_force == two.peak_force);
  CHECK(one.openings == two.openings);
  CHECK(one.electric.supplied == two.electric.supplied);
  REQUIRE(one.samples.size() == two.samples.size());
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    const auto &a = one.samples[k], &b = two.samples[k];
    REQUIRE(a.time == b.time);
    REQUIRE(a.travel == b.travel);
    REQUIRE(a.bridges == b.bridges);
    REQUIRE(a.pad_force == b.pad_force);
    REQUIRE(a.current == b.current);
  }
}

TEST_CASE("restart with frozen parts, layers and dashpots: bit for bit through freezing and thawing") {
  const auto made = [] {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("base"), {0, 0, 0}, {0.012, 0.012, 0.004}, 6, 6, 2);
    add_box(mesh, mesh.add_part("block"), {0.003, 0.003, 0.00401}, {0.009, 0.009, 0.01}, 3, 3, 3);
    SolidOptions o;
    o.ledger_every = 10;
    o.energy_bound = 0.1;
    auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>(2), o);
    s->set_velocity(1, {1, 0.5, -3});
    ContactPair pair{0, 1};
    pair.friction_static = 0.3;
    pair.friction_dynamic = 0.2;
    pair.layer = 1e12;
    pair.layer_damping = 1e5;
    pair.stick_damping = 0.3;
    s->set_contact({{pair}});
    SolidSpring spring;
    spring.a = s->whole_part(0);
    spring.b = s->whole_part(1);
    spring.rate = 1e5;
    s->add_spring(spring);
    s->set_rigid(0, true);
    return s;
  };
  const auto go = [](ExplicitSolid& s, int from, int to) {
    for (int k = from; k < to; ++k) {
      if (k == 60) s.set_rigid(0, false);
      if (k == 120) s.set_rigid(1, true);
      if (k == 200) s.set_rigid(1, false);
      s.step();
    }
  };
  const auto whole = made();
  std::vector<SolidState> saved;
  for (const int at : {30, 100, 150, 230}) {
    go(*whole, saved.empty() ? 0 : static_cast<int>(whole->steps()), at);
    saved.push_back(whole->save());
  }
  go(*whole, 230, 300);
  CHECK(whole->contact()->friction_lost() > 0);
  for (const SolidState& s : saved) {
    const auto again = made();
    again->restore(s);
    go(*again, static_cast<int>(s.step), 300);
    const SolidState a = again->save(), b = whole->save();
    CHECK(a.u == b.u);
    CHECK(a.v == b.v);
    CHECK(a.contact == b.contact);
    CHECK(a.booked == b.booked);
  }
  SolidMesh other;
  add_box(other, other.add_part("box"), {0, 0, 0}, {1, 1, 1}, 1, 1, 1);
  ExplicitSolid small(other, {SolidMaterial{}});
  CHECK_THROWS_WITH(small.restore(saved[0]), Catch::Contains("another mesh"));
}
