#include <catch2/catch.hpp>
#include <iostream>

#include "sim/mechanics/unilateral.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

/// A skewed block that falls on another with friction, one of them plastic: everything that has memory.
std::unique_ptr<ExplicitSolid> two_blocks(int workers) {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("base"), {0, 0, 0}, {0.012, 0.012, 0.004}, 12, 12, 4);
  const int first =
      add_box(mesh, mesh.add_part("block"), {0.003, 0.003, 0.00401}, {0.009, 0.009, 0.01}, 7, 7, 7);
  map_nodes(mesh, first, [](const Vec3& p) {
    return Vec3{p.x + 0.1 * (p.z - 0.00401), p.y, p.z + 1e-2 * (p.x - 0.003)};
  });
  SolidMaterial steel, soft = material(1.2e11, 0.34, 8930);
  soft.yield = 2e8;
  soft.hardening = 1e9;
  SolidOptions options;
  options.workers = workers;
  options.ledger_every = 50;
  auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{steel, soft}, options);
  s->set_velocity(1, {3, 1, -10});
  ContactOptions contact;
  ContactPair pair{0, 1};
  pair.friction_static = 0.3;
  pair.friction_dynamic = 0.2;
  pair.decay = 0.5;
  contact.pairs.push_back(pair);
  s->set_contact(contact);
  return s;
}

bool same_bits(const ExplicitSolid& a, const ExplicitSolid& b) {
  const SolidState x = a.save(), y = b.save();
  return x.u == y.u && x.v == y.v && x.cells == y.cells && x.contact == y.contact && x.booked == y.booked &&
         x.time == y.time && x.step == y.step;
}

}  // namespace

TEST_CASE("energy of an undamped vibration stays to round-off") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {0.004, 0.004, 0.01}, 4, 4, 10);
  SolidMaterial m = material(2e11, 0.3, 7850);
  m.small_displacement = true;
  SolidOptions options;
  options.ledger_every = 500;
  ExplicitSolid s(mesh, {m}, options);
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    s.set_node_velocity(n, {std::sin(n), std::cos(2 * n), std::sin(3 * n)});
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    s.step();
    worst = std::max(worst, std::fabs(s.energies().residual()) / s.energies().start);
  }
  std::cout << "undamped vibration, 2e4 steps: energy residual " << worst << "\n";
  CHECK(worst < 1e-9);
}

TEST_CASE("undamped vibration over 1e6 steps keeps its energy to 1e-9", "[.slow]") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {0.002, 0.002, 0.004}, 2, 2, 4);
  SolidMaterial m = material(2e11, 0.3, 7850);
  m.small_displacement = true;
  SolidOptions options;
  options.ledger_every = 10000;
  ExplicitSolid s(mesh, {m}, options);
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    s.set_node_velocity(n, {std::sin(n), std::cos(2 * n), std::sin(3 * n)});
  double worst = 0;
  for (int k = 0; k < 1000000; ++k) {
    s.step();
    worst = std::max(worst, std::fabs(s.energies().residual()) / s.energies().start);
  }
  std::cout << "undamped vibration, 1e6 steps: energy residual " << worst << "\n";
  CHECK(worst < 1e-9);
}

TEST_CASE("one and two threads give the same bits") {
  const auto one = two_blocks(1), two = two_blocks(2), three = two_blocks(3);
  for (int k = 0; k < 60; ++k) {
    one->step();
    two->step();
    three->step();
  }
  REQUIRE(one->contact()->report(0).touching > 0);
  REQUIRE(one->energies().plastic > 0);
  CHECK(same_bits(*one, *two));
  CHECK(same_bits(*one, *three));
}

TEST_CASE("a run continued from a saved state gives the bits of the run that went on") {
  const auto whole = two_blocks(1), again = two_blocks(1);
  for (int k = 0; k < 37; ++k) whole->step();
  const SolidState saved = whole->save();
  for (int k = 0; k < 63; ++k) whole->step();
  again->restore(saved);
  for (int k = 0; k < 63; ++k) again->step();
  CHECK(same_bits(*whole, *again));
  CHECK(whole->energies().residual() == again->energies().residual());
}

TEST_CASE("energy of an impact with friction and plastic flow is accounted for") {
  const auto s = two_blocks(1);
  double worst = 0;
  while (s->time() < 12e-6) {
    s->step();
    worst = std::max(worst, std::fabs(s->energies().residual()) / s->energies().start);
  }
  const SolidEnergies& e = s->energies();
  std::cout << "oblique impact: plastic " << e.plastic / e.start << ", friction " << e.friction / e.start
            << ", hourglass " << e.hourglass / e.start << ", residual " << worst << " of the energy\n";
  CHECK(e.plastic > 0.01 * e.start);
  CHECK(e.friction > 0);
  CHECK(worst < 0.01);
}

TEST_CASE("a frozen block rebounds from a damped layer with the ratio of its law, every joule booked") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("block"), {0, 0, 0}, {0.01, 0.01, 0.01}, 2, 2, 2);
  add_box(mesh, mesh.add_part("wall"), {-0.015, -0.015, -0.02}, {0.025, 0.025, -1e-5}, 3, 3, 1);
  SolidOptions options;
  options.ledger_every = 1;
  options.dt = 2e-8;
  ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}}, options);
  for (int n = s.cells().nodes_begin(1); n < s.cells().nodes_end(1); ++n) s.fix(n, true, true, true);
  s.set_velocity(0, {0, 0, -1});
  double mass = 0;
  for (int n = 0; n < s.cells().nodes_end(0); ++n) mass += s.cells().masses()[static_cast<std::size_t>(n)];
  constexpr double stiffness = 1e6, zeta = 0.3;
  ContactPair pair{0, 1};
  // no node of the wall meets the block: half of the layer acts
  pair.layer = 2 * stiffness / 1e-4;
  pair.layer_damping = 2 * 2 * zeta * std::sqrt(stiffness * mass) / 1e-4;
  s.set_contact({{pair}});
  s.set_rigid(0, true);
  s.set_rigid(1, true);
  double worst = 0;
  while (s.time() < 1.1e-5 || s.contact()->report(0).touching > 0) {
    s.step();
    worst = std::max(worst, std::fabs(s.energies().residual()) / s.energies().start);
  }
  s.step();
  const SolidEnergies& e = s.energies();
  std::cout << "damped layer: rebound " << s.mean_velocity(0).z << ", law " << rebound_ratio(zeta)
            << ", energy residual " << worst << "\n";
  CHECK(s.mean_velocity(0).z == Approx(rebound_ratio(zeta)).epsilon(2e-3));
  CHECK(e.contact_damping == Approx(e.start * (1 - rebound_ratio(zeta) * rebound_ratio(zeta))).epsilon(5e-3));
  CHECK(worst < 1e-4);
}

TEST_CASE("a dashpot in the contact lowers the critical step, and the run at that step is stable") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("a"), {0, 0, 0}, {1e-3, 1e-3, 2e-3}, 1, 1, 2);
  add_box(mesh, mesh.add_part("b"), {0, 0, 2e-3}, {1e-3, 1e-3, 4e-3}, 1, 1, 2);
  const auto pressed = [&](double layer_damping) {
    SolidOptions options;
    options.safety = 0.98;
    auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>(2), options);
    ContactPair pair{0, 1};
    pair.layer = 1e13;
    pair.layer_damping = layer_damping;
    s->set_contact({{pair}});
    s->set_velocity(0, {0, 0, 1e-3});
    s->set_velocity(1, {0, 0, -1e-3});
    return s;
  };
  const auto damped = pressed(4e7);
  CHECK(damped->critical_step() < 0.9 * pressed(0)->critical_step());
  for (int k = 0; k < 3000; ++k) damped->step();
  damped->ask_energies();
  damped->step();
  const SolidEnergies& e = damped->energies();
  CHECK(e.contact_damping > 0.01 * e.start);
  CHECK(e.stored() < e.start);
}

TEST_CASE("the critical step is the linear limit: 0.99 of it is stable, 1.01 is not and is refused") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {0.004, 0.003, 0.01}, 4, 4, 10);
  map_nodes(mesh, 0, [](const Vec3& p) { return Vec3{p.x + 0.2 * p.z * p.y / 0.01, p.y, p.z}; });
  SolidMaterial m = material(2e11, 0.3, 7850);
  m.small_displacement = true;
  const double limit = ExplicitSolid(mesh, {m}).critical_step();
  const auto growth = [&](double dt) {
    CellBatches cells(mesh, {m}, false);
    const std::size_t nodes = mesh.nodes.size();
    std::vector<double> u(4 * nodes, 0.0), v(4 * nodes, 0.0);
    double size = 0;
    for (std::size_t n = 0; n < nodes; ++n)
      for (std::size_t i = 0; i < 3; ++i) v[4 * n + i] = 1e-3 * std::sin(static_cast<double>(7 * n + i * i));
    for (int k = 0; k < 3000; ++k) {
      for (int b = 0; b < cells.count(); ++b) cells.compute(b, u.data(), v.data(), dt);
      if (!(size < 1e100)) return 1e300;
      size = 0;
      for (std::size_t n = 0; n < nodes; ++n) {
        const Vec3 f = cells.node_force(static_cast<int>(n));
        for (std::size_t i = 0; i < 3; ++i) {
          v[4 * n + i] += dt * f[static_cast<int>(i)] / cells.masses()[n];
          u[4 * n + i] += dt * v[4 * n + i];
          size = std::max(size, std::fabs(v[4 * n + i]));
        }
      }
    }
    return size / 1e-3;
  };
  CHECK(growth(0.99 * limit) < 1e2);
  CHECK(growth(1.01 * limit) > 1e6);
  SolidOptions options;
  options.dt = 1.01 * limit;
  ExplicitSolid s(mesh, {m}, options);
  CHECK_THROWS_WITH(s.step(), Catch::Contains("dt = ") && Catch::Contains("critical step"));
}

TEST_CASE("penalty contact lowers the critical step, and says so before the run") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("a"), {0, 0, 0}, {1e-3, 1e-3, 2e-3}, 1, 1, 2);
  add_box(mesh, mesh.add_part("b"), {0, 0, 2e-3}, {1e-3, 1e-3, 4e-3}, 1, 1, 2);
  ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}});
  const double alone = s.critical_step();
  ContactOptions contact;
  contact.pairs.push_back({0, 1});
  contact.pairs[0].factor = 10;
  s.set_contact(contact);
  CHECK(s.critical_step() < 0.6 * alone);
}

TEST_CASE("a cell that turns inside out stops the run with its number") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {1, 1, 3}, 1, 1, 3);
  SolidOptions options;
  options.energy_bound = 1e9;
  ExplicitSolid s(mesh, {material(1e6, 0.3, 1000)}, options);
  for (int n = 4; n < 8; ++n)
    s.set_node_velocity(n, {0, 0, 3000});  // faster than any wave, into the second cell
  try {
    for (int k = 0; k < 1000; ++k) s.step();
    FAIL("went on");
  } catch (const SolidStop& stop) {
    CHECK(stop.cell == 1);
    CHECK(std::string(stop.what()).find("cell 1") != std::string::npos);
  }
}

TEST_CASE("frozen parts keep momentum and angular momentum, and thaw as they were") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {0.02, 0.01, 0.005}, 4, 2, 1);
  ExplicitSolid s(mesh, {SolidMaterial{}});
  const Vec3 spin{100, -200, 300}, centre{0.01, 0.005, 0.0025};
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    s.set_node_velocity(n, Vec3{1, 2, 3} + cross(spin, mesh.nodes[static_cast<std::size_t>(n)] - centre));
  const auto turning = [&] {
    Vec3 sum, middle = centre + s.mean_displacement(0), drift = s.mean_velocity(0);
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
      sum +=
          s.cells().masses()[static_cast<std::size_t>(n)] *
          cross(mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n) - middle, s.velocity(n) - drift);
    return sum;
  };
  for (int k = 0; k < 50; ++k) s.step();
  const Vec3 before = turning();
  s.set_rigid(0, true);
  CHECK(norm(turning() - before) < 1e-9 * norm(before));
  const double rigid_start = s.time();
  s.set_step(1e-6);
  for (int k = 0; k < 5000; ++k) s.step();
  CHECK(norm(turning() - before) < 1e-9 * norm(before));
  CHECK(norm(s.mean_velocity(0) - Vec3{1, 2, 3}) < 1e-9);
  CHECK(s.time() - rigid_start == Approx(5e-3));
  // the faces of a turned brick still meet at right angles
  const auto place = [&](int n) { return mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n); };
  CHECK(std::fabs(dot(place(1) - place(0), place(5) - place(0))) < 1e-4 * 0.005 * 0.005);
}
