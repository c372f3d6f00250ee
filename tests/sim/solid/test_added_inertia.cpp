// Selective mass scaling: what it changes (the step), and what it must not.

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <iostream>

#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

/// A steel beam 40 x 2 x 2 mm of 1 mm cells with a skin of cells `skin` thick on top; slightly skewed.
SolidMesh clad_beam(double skin) {
  SolidMesh mesh;
  std::vector<double> x, y{0, 1e-3, 2e-3}, z{0, 1e-3, 2e-3 - skin, 2e-3};
  for (int i = 0; i <= 40; ++i) x.push_back(1e-3 * i);
  add_grid(mesh, mesh.add_part("beam"), x, y, z, [](int, int, int) { return true; });
  map_nodes(mesh, 0, [](const Vec3& p) { return Vec3{p.x + 0.05 * p.y, p.y, p.z + 0.02 * p.y}; });
  return mesh;
}

SolidMaterial small_steel() {
  SolidMaterial m;
  m.small_displacement = true;
  return m;
}

constexpr double skin = 0.1e-3, wanted = 6e-8;

struct Motion {
  Vec3 momentum, turning;
  double kinetic = 0;
};

Motion motion(const ExplicitSolid& s, const SolidMesh& mesh) {
  Motion sum;
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const double m = s.cells().masses()[static_cast<std::size_t>(n)];
    const Vec3 v = s.velocity(n), x = mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n);
    sum.momentum += m * v;
    sum.turning += m * cross(x, v);
    sum.kinetic += 0.5 * m * dot(v, v);
  }
  return sum;
}

/// Frequencies squared of a free body, ascending, by dense matrices.
Eigen::VectorXd squares(const SolidMesh& mesh, const SolidMaterial& m, AddedInertia inertia) {
  CellBatches cells(mesh, {m}, false);
  const auto nodes = mesh.nodes.size();
  const auto size = static_cast<Eigen::Index>(3 * nodes);
  Eigen::MatrixXd k(size, size), mass = Eigen::MatrixXd::Zero(size, size);
  std::vector<double> u(4 * nodes, 0.0), rest(4 * nodes, 0.0);
  inertia.aim(mesh.nodes, rest.data(), rest.data(), 0, [](int) { return false; });
  for (std::size_t n = 0; n < nodes; ++n)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto column = static_cast<Eigen::Index>(3 * n + i);
      u[4 * n + i] = 1;
      for (int b = 0; b < cells.count(); ++b) cells.compute(b, u.data(), rest.data(), 0);
      for (std::size_t o = 0; o < nodes; ++o)
        for (int j = 0; j < 3; ++j)
          k(static_cast<Eigen::Index>(3 * o) + j, column) = -cells.node_force(static_cast<int>(o))[j];
      mass(column, column) += cells.masses()[n];
      const auto p = inertia.times(inertia.gather(u.data()));
      for (std::size_t o = 0; o < inertia.nodes().size(); ++o)
        for (std::size_t j = 0; j < 3; ++j)
          mass(3 * inertia.nodes()[o] + static_cast<Eigen::Index>(j), column) += p[3 * o + j];
      u[4 * n + i] = 0;
    }
  const Eigen::MatrixXd sym = 0.5 * (k + k.transpose());
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(sym, mass, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

}  // namespace

TEST_CASE("scaled masses: rigid motions have the momentum and the energy they had") {
  const SolidMesh mesh = clad_beam(skin);
  AddedInertia inertia(mesh, {SolidMaterial{}}, wanted);
  const Vec3 spin{300, -500, 700};
  std::vector<double> u(4 * mesh.nodes.size(), 0.0), v(u), stretch(u);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vec3 w = Vec3{3, -2, 5} + cross(spin, mesh.nodes[n]);
    for (int i = 0; i < 3; ++i) v[4 * n + static_cast<std::size_t>(i)] = w[i];
    stretch[4 * n + 2] = 1e3 * mesh.nodes[n].z;
  }
  inertia.aim(mesh.nodes, u.data(), v.data(), 0, [](int) { return false; });
  const CellBatches cells(mesh, {SolidMaterial{}}, false);
  double lumped = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) lumped += 0.5 * cells.masses()[n] * v[4 * n + i] * v[4 * n + i];
  inertia.start(v.data());
  const double rigid = inertia.kinetic_of(0, static_cast<int>(mesh.nodes.size()), v.data()) / lumped;
  Vec3 force, torque;
  inertia.start(stretch.data());
  double size = 0;
  for (std::size_t k = 0; k < inertia.nodes().size(); ++k) {
    const double* p = inertia.momentum().data() + 3 * k;
    const Vec3 one{p[0], p[1], p[2]};
    force += one;
    torque += cross(mesh.nodes[static_cast<std::size_t>(inertia.nodes()[k])], one);
    size += norm(one);
  }
  std::cout << "scaled masses, " << inertia.cells() << " of " << mesh.cells.size() << " cells, added "
            << inertia.share() << " of the mass: rigid motion " << rigid << " of its energy, sum of momenta "
            << norm(force) / size << ", of their moments " << norm(torque) / size / 40e-3 << "\n";
  CHECK(std::fabs(rigid) < 1e-12);
  CHECK(size > 0);
  CHECK(norm(force) < 1e-12 * size);
  CHECK(norm(torque) < 1e-12 * size * 40e-3);
}

TEST_CASE("scaled masses: a tumbling beam keeps momentum and energy to 1e-12 and turns on as before") {
  const SolidMesh mesh = clad_beam(skin);
  const auto tumble = [&](double scaled) {
    SolidOptions o;
    o.dt = 1e-8;
    o.ledger_every = 100;
    o.scale_masses_to = scaled;
    auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{SolidMaterial{}}, o);
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
      s->set_node_velocity(n, Vec3{3, -2, 5} + cross({0, 0, 20}, mesh.nodes[static_cast<std::size_t>(n)]));
    return s;
  };
  const auto plain = tumble(0), scaled = tumble(wanted);
  const Motion start = motion(*scaled, mesh);
  for (int k = 0; k < 2000; ++k) {
    plain->step();
    scaled->step();
  }
  const Motion end = motion(*scaled, mesh), same = motion(*plain, mesh);
  double apart = 0;
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    apart = std::max(apart, norm(scaled->displacement(n) - plain->displacement(n)));
  std::cout << "tumbling beam, 2000 steps: momentum "
            << norm(end.momentum - start.momentum) / norm(start.momentum) << ", angular momentum "
            << norm(end.turning - start.turning) / norm(start.turning) << ", kinetic energy "
            << end.kinetic / start.kinetic - 1 << " (without " << same.kinetic / start.kinetic - 1
            << ", the rest strains it), places " << apart << " m from the run without, residual "
            << scaled->energies().residual() / scaled->energies().start << "\n";
  CHECK(norm(end.momentum - start.momentum) < 1e-12 * norm(start.momentum));
  CHECK(norm(end.turning - start.turning) < 1e-12 * norm(start.turning));
  CHECK(std::fabs(end.kinetic - same.kinetic) < 1e-12 * start.kinetic);
  CHECK(apart < 1e-12);
}

TEST_CASE("scaled masses: lowest beam frequencies stay, the step grows to what was asked",
          "[.slow]") {  // all eigenvalues of a dense matrix: minutes under the sanitizers
  const SolidMesh mesh = clad_beam(skin);
  const SolidMaterial m = small_steel();
  const AddedInertia inertia(mesh, {m}, wanted);
  const Eigen::VectorXd before = squares(mesh, m, {}), after = squares(mesh, m, inertia);
  std::cout << "scaled masses: frequencies";
  for (Eigen::Index k = 6; k < 12; ++k) {
    const double change = std::sqrt(after[k] / before[k]) - 1;
    std::cout << " " << std::sqrt(before[k]) / 6.283185 << " Hz " << 100 * change << " %,";
    CHECK(change <= 1e-9);  // inertia can only slow down
    CHECK(change > -2e-3);
  }
  const double plain = 2 / std::sqrt(before[before.size() - 1]),
               larger = 2 / std::sqrt(after[after.size() - 1]);
  SolidOptions o;
  o.scale_masses_to = wanted;
  const ExplicitSolid scaled(mesh, {m}, o);
  std::cout << " step " << plain * 1e9 << " -> " << larger * 1e9 << " ns, asked " << wanted * 1e9 << " ns\n";
  CHECK(plain < 0.4 * wanted);
  CHECK(larger >= wanted);
  CHECK(larger < 1.25 * wanted);
  CHECK(scaled.critical_step() == Approx(larger).epsilon(1e-6));
}

TEST_CASE("scaled masses: at 0.99 of the new step energy stays, with 1.01 it is refused") {
  // what the momentum form leaves out is smaller than the energy by the speed of deformation over that of sound
  const SolidMesh mesh = clad_beam(skin);
  SolidOptions o;
  o.safety = 0.99;
  o.ledger_every = 50;
  o.scale_masses_to = wanted;
  double before = 0;
  for (const double speed : {1e-1, 1e-3, 1e-5}) {
    ExplicitSolid s(mesh, {small_steel()}, o);
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
      s.set_node_velocity(n, speed * Vec3{std::sin(n), std::cos(2 * n), std::sin(3 * n)});
    double worst = 0;
    for (int k = 0; k < 1000; ++k) {
      s.step();
      worst = std::max(worst, std::fabs(s.energies().residual()) / s.energies().start);
    }
    std::cout << "scaled masses, nodes shaken by " << speed << " m/s, 1000 steps of " << s.dt() * 1e9
              << " ns: energy residual " << worst << ", " << s.added_inertia().iterations() / 1000
              << " iterations a step\n";
    CHECK(s.dt() > 0.99 * wanted);
    CHECK(worst < 1e-4 * speed);
    if (before > 0) CHECK(worst < 0.02 * before);
    before = worst;
    SolidOptions over = o;
    over.dt = 1.01 * s.step_limit();
    ExplicitSolid t(mesh, {small_steel()}, over);
    CHECK_THROWS_WITH(t.step(), Catch::Contains("critical step"));
  }
}

namespace {

/// A clad beam that falls askew on a plate with friction, its skin scaled.
std::unique_ptr<ExplicitSolid> falling(int workers) {
  SolidMesh mesh;
  std::vector<double> x, y{0, 1e-3, 2e-3}, z{0, 0.1e-3, 1e-3, 2e-3};
  for (int i = 0; i <= 12; ++i) x.push_back(1e-3 * i);
  add_box(mesh, mesh.add_part("plate"), {-4e-3, -4e-3, -4e-3}, {16e-3, 6e-3, -1e-5}, 14, 7, 3);
  const int first = static_cast<int>(mesh.nodes.size());
  add_grid(mesh, mesh.add_part("beam"), x, y, z, [](int, int, int) { return true; });
  map_nodes(mesh, first, [](const Vec3& p) { return Vec3{p.x, p.y, p.z + 0.01 * p.x}; });
  SolidMaterial soft;
  soft.yield = 3e8;
  soft.hardening = 1e9;
  SolidOptions o;
  o.workers = workers;
  o.ledger_every = 20;
  o.scale_masses_to = 5e-8;
  auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{SolidMaterial{}, soft}, o);
  s->set_velocity(1, {2, 0, -8});
  ContactPair pair{0, 1};
  pair.friction_static = 0.3;
  pair.friction_dynamic = 0.2;
  s->set_contact({{pair}});
  return s;
}

}  // namespace

TEST_CASE("scaled masses: an impact is accounted for, with the bits of two threads and of a restart") {
  const auto one = falling(1), two = falling(2), again = falling(1);
  double worst = 0;
  int touched = 0;
  SolidState saved;
  for (int k = 0; k < 400; ++k) {
    if (k == 150) saved = one->save();
    one->step();
    two->step();
    touched += one->contact()->report(0).touching > 0;
    worst = std::max(worst, std::fabs(one->energies().residual()) / one->energies().start);
  }
  again->restore(saved);
  for (int k = 150; k < 400; ++k) again->step();
  const SolidState a = one->save(), b = two->save(), c = again->save();
  std::cout << "scaled masses, impact: " << one->added_inertia().cells() << " cells, energy residual "
            << worst << ", plastic " << one->energies().plastic / one->energies().start << "\n";
  REQUIRE(touched > 10);
  CHECK(worst < 0.01);
  CHECK(a.u == b.u);
  CHECK(a.v == b.v);
  CHECK(a.inertia == b.inertia);
  CHECK(a.u == c.u);
  CHECK(a.v == c.v);
  CHECK(a.inertia == c.inertia);
}

TEST_CASE("scaled masses: frozen parts carry none, and what freezing takes is booked") {
  const auto s = falling(1);
  while (s->contact()->report(0).touching == 0) s->step();
  for (int k = 0; k < 100; ++k) s->step();
  s->set_rigid(1, true);
  for (int k = 0; k < 40; ++k) s->step();
  s->set_rigid(1, false);
  double worst = 0;
  for (int k = 0; k < 100; ++k) {
    s->step();
    worst = std::max(worst, std::fabs(s->energies().residual()) / s->energies().start);
  }
  CHECK(s->energies().frozen > 0);
  CHECK(worst < 0.01);
}

TEST_CASE("scaled masses: off unless asked for, steps out of range refused") {
  const SolidMesh mesh = clad_beam(skin);
  CHECK(ExplicitSolid(mesh, {SolidMaterial{}}).added_inertia().empty());
  for (const double bad : {-1e-9, std::nan(""), 1e-3, std::numeric_limits<double>::infinity()}) {
    SolidOptions o;
    o.scale_masses_to = bad;
    CHECK_THROWS_WITH(ExplicitSolid(mesh, {SolidMaterial{}}, o), Catch::Contains("scale_masses_to = ") &&
                                                                     Catch::Contains("must be in (0, ") &&
                                                                     Catch::Contains("ns"));
  }
  SolidOptions nothing;
  nothing.scale_masses_to = 1e-12;  // every cell is slower than that
  CHECK(ExplicitSolid(mesh, {SolidMaterial{}}, nothing).added_inertia().share() == 0);
}
