#include <catch2/catch.hpp>
#include <iostream>

#include "core/units.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

/// A rigid flat block of 1 kg pressed on a long rigid table.
struct Slider {
  std::unique_ptr<ExplicitSolid> s;

  explicit Slider(ContactPair pair, double pressed, double spring_rate = 0, double pulled = 0) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("table"), {-20, -2, -0.5}, {20, 2, 0}, 20, 2, 1);
    const int first = add_box(mesh, mesh.add_part("block"), {-0.5, -0.5, 0}, {0.5, 0.5, 0.02}, 1, 1, 1);
    SolidOptions options;
    options.ledger_every = 500;
    options.energy_bound = 0.02;
    s = std::make_unique<ExplicitSolid>(
        mesh, std::vector<SolidMaterial>{material(1e5, 0, 1000), material(1e5, 0, 50)}, options);
    for (int n = 0; n < first; ++n) s->fix(n, true, true, true);
    pair.a = 0;
    pair.b = 1;
    pair.damping = 0.5;
    ContactOptions contact;
    contact.pairs.push_back(pair);
    contact.allowed_overlap = 1e-3;
    s->set_contact(contact);
    s->add_load({s->whole_part(1), {0, 0, -pressed}});
    if (spring_rate > 0) {
      SolidSpring spring;
      spring.a = s->whole_part(1);
      spring.axis = {1, 0, 0};
      spring.rate = spring_rate;
      s->add_spring(spring);
      for (int n = first; n < static_cast<int>(mesh.nodes.size()); ++n)
        s->set_node_displacement(n, {pulled, 0, 0});
    }
    s->set_rigid(0, true);
    s->set_rigid(1, true);
  }
};

}  // namespace

TEST_CASE("sliding friction that falls with speed stops the block when the integral says") {
  // dv/dt = -g (mu_d + (mu_s - mu_d) exp(-c v)), v0 = 1: t = ln[(a e^(c v0) + b) / (a + b)] / (a c)
  ContactPair pair;
  pair.friction_static = 0.3;
  pair.friction_dynamic = 0.2;
  pair.decay = 20;
  Slider slider(pair, 9.81);
  auto& s = *slider.s;
  for (int n = s.cells().nodes_begin(1); n < s.cells().nodes_end(1); ++n) s.set_node_velocity(n, {1, 0, 0});
  s.set_rigid(1, false);
  s.set_rigid(1, true);  // frozen with its velocity
  s.step();
  s.set_step(2e-5);
  const double g = 9.81, a = 0.2 * g, b = 0.1 * g, c = 20;
  const double expected = std::log((a * std::exp(c) + b) / (a + b)) / (a * c);
  while (s.mean_velocity(1).x > 0) s.step();
  std::cout << "falling friction: stops after " << s.time() << " s, exact " << expected << " s, at "
            << s.mean_displacement(1).x << " m\n";
  CHECK(s.time() == Approx(expected).epsilon(2e-3));
  CHECK(std::fabs(s.energies().residual()) < 0.02 * 0.5);
}

TEST_CASE("spring and Coulomb friction: five turning points, then rest for good") {
  ContactPair pair;
  pair.friction_static = pair.friction_dynamic = 0.1;  // 1 N
  pair.stick_damping = 0.5;
  Slider slider(pair, 10, 1.0, 8.5);
  auto& s = *slider.s;
  s.step();
  s.set_step(1e-4);
  std::vector<double> turns;
  double before = -1e-9;
  while (s.time() < 30) {
    s.step();
    const double v = s.mean_velocity(1).x;
    if (v * before < 0 && s.time() > 0.5 &&
        std::fabs(s.mean_displacement(1).x - (turns.empty() ? 8.5 : turns.back())) > 0.1)
      turns.push_back(s.mean_displacement(1).x);
    before = v;
  }
  const double expected[] = {-6.5, 4.5, -2.5, 0.5};
  std::cout << "Coulomb stop: turns at";
  for (const double t : turns) std::cout << " " << t;
  std::cout << ", rests at " << s.mean_displacement(1).x << " with " << s.mean_velocity(1).x << " m/s\n";
  REQUIRE(turns.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) CHECK(turns[k] == Approx(expected[k]).margin(0.01));
  CHECK(s.mean_displacement(1).x == Approx(0.5).margin(0.01));
  CHECK(std::fabs(s.mean_velocity(1).x) < 1e-6);
}

TEST_CASE("the shear limit caps friction by area, and keeps its direction") {
  ContactPair pair;
  pair.friction_static = pair.friction_dynamic = 1;  // 10 N without the cap
  pair.shear_limit = 2;                              // Pa on 1 m2 each way
  Slider slider(pair, 10);
  auto& s = *slider.s;
  for (int n = s.cells().nodes_begin(1); n < s.cells().nodes_end(1); ++n) s.set_node_velocity(n, {3, 4, 0});
  s.set_rigid(1, false);
  s.set_rigid(1, true);
  s.step();
  s.set_step(1e-4);
  while (s.time() < 0.2) s.step();
  const Vec3 f = s.contact()->report(0).force;  // on the table
  CHECK(std::hypot(f.x, f.y) == Approx(2).epsilon(0.05));
  CHECK(f.y / f.x == Approx(4.0 / 3).epsilon(1e-3));
}
