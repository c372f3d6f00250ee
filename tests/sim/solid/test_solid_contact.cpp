#include <catch2/catch.hpp>
#include <iostream>

#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

/// A unit cube standing on one corner above a plate of 2 x 2 faces, the corner at (x, y), `depth` below the surface.
struct CornerOnPlate {
  SolidMesh mesh;
  ContactReport report;
  double stored = 0;

  CornerOnPlate(double x, double y, double depth) {
    add_box(mesh, mesh.add_part("plate"), {-3, -3, -1}, {3, 3, 0}, 2, 2, 1);
    const int first = add_box(mesh, mesh.add_part("cube"), {0, 0, 0}, {1, 1, 1}, 1, 1, 1);
    // the space diagonal becomes vertical
    const Vec3 e3 = unit({1, 1, 1}), e1 = unit({1, -1, 0}), e2 = cross(e3, e1);
    map_nodes(mesh, first, [&](const Vec3& p) { return Vec3{dot(e1, p) + x, dot(e2, p) + y, dot(e3, p)}; });
    ContactOptions contact;
    contact.pairs.push_back({0, 1});
    SolidOptions options;
    options.ledger_every = 0;
    ExplicitSolid s(mesh, {material(1e6, 0.3, 1000), material(1e6, 0.3, 1000)}, options);
    for (int n = first; n < first + 8; ++n) s.set_node_displacement(n, {0, 0, -depth});
    s.set_contact(contact);
    s.step();
    report = s.contact()->report(0);
    stored = s.contact()->stored();
  }
};

}  // namespace

TEST_CASE("a corner that hits a shared edge is counted once") {
  const CornerOnPlate inside(1.3, 0.8, 0.01), edge(1.3, 0, 0.01), beside(1.3, 1e-12, 0.01);
  REQUIRE(inside.report.touching == 1);
  CHECK(edge.report.touching == 1);
  CHECK(beside.report.touching == 1);
  CHECK(edge.report.force.z == Approx(inside.report.force.z).epsilon(1e-12));
  CHECK(beside.report.force.z == Approx(inside.report.force.z).epsilon(1e-12));
  CHECK(edge.stored == Approx(inside.stored).epsilon(1e-12));
  CHECK(inside.report.force.z < 0);  // the plate is pushed down
}

TEST_CASE("crossed ridges meet edge to edge and rebound") {
  SolidMesh mesh;
  const double h = 1e-3, length = 12e-3, high = h * std::sqrt(2.0);
  const auto ridge = [&](const char* name, bool along_y, double z) {
    const int first = add_box(mesh, mesh.add_part(name), {-length / 2, -h / 2, -h / 2},
                              {length / 2, h / 2, h / 2}, 11, 2, 2);
    map_nodes(mesh, first, [&](const Vec3& p) {
      const double c = std::sqrt(0.5), y = c * (p.y - p.z), up = c * (p.y + p.z);
      return along_y ? Vec3{-y, p.x, up + z} : Vec3{p.x, y, up + z};
    });
  };
  ridge("lower", false, 0);
  ridge("upper", true, high + 1e-6);
  ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}});
  s.set_velocity(1, {0, 0, -1});
  ContactOptions contact;
  contact.pairs.push_back({0, 1});
  s.set_contact(contact);
  int touched = 0;
  double residual = 0;
  while (s.time() < 60e-6) {
    s.step();
    touched += s.contact()->report(0).touching > 0;
    residual = std::max(residual, std::fabs(s.energies().residual()) / s.energies().start);
  }
  std::cout << "crossed ridges: " << touched << " steps in touch, velocities after " << s.mean_velocity(0).z
            << " and " << s.mean_velocity(1).z << ", residual " << residual << "\n";
  CHECK(touched > 10);
  CHECK(s.mean_velocity(0).z + s.mean_velocity(1).z == Approx(-1).epsilon(1e-9));
  CHECK(s.mean_velocity(1).z > s.mean_velocity(0).z);  // parted
  CHECK(residual < 0.01);
  s.set_contact({});
}

TEST_CASE("faces that are parallel to 1e-9 act like parallel ones") {
  const auto force = [](double angle) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("a"), {0, 0, 0}, {3, 3, 1}, 3, 3, 1);
    const int first = add_box(mesh, mesh.add_part("b"), {0.4, 0.4, 1}, {2.6, 2.6, 2}, 2, 2, 1);
    map_nodes(mesh, first, [&](const Vec3& p) { return Vec3{p.x, p.y, p.z + angle * (p.x - 1.5)}; });
    SolidOptions options;
    options.ledger_every = 0;
    ExplicitSolid s(mesh, {material(1e6, 0.3, 1000), material(1e6, 0.3, 1000)}, options);
    for (int n = first; n < static_cast<int>(mesh.nodes.size()); ++n)
      s.set_node_displacement(n, {0, 0, -0.01});
    ContactOptions contact;
    contact.pairs.push_back({0, 1});
    contact.allowed_overlap = 1;
    s.set_contact(contact);
    s.step();
    return s.contact()->report(0);
  };
  const ContactReport level = force(0), tilted = force(1e-9);
  CHECK(tilted.force.z == Approx(level.force.z).epsilon(1e-6));
  CHECK(tilted.touching == level.touching);
  CHECK(std::isfinite(tilted.force.x));
}

TEST_CASE("parts that overlap at the start are refused by name") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("bridge"), {0, 0, 0}, {1, 1, 1}, 2, 2, 2);
  add_box(mesh, mesh.add_part("pad"), {0.2, 0.2, 0.95}, {0.8, 0.8, 2}, 2, 2, 2);
  ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}});
  ContactOptions contact;
  contact.pairs.push_back({0, 1});
  CHECK_THROWS_WITH(s.set_contact(contact),
                    Catch::Contains("bridge") && Catch::Contains("pad") && Catch::Contains("overlap"));
  contact.pairs[0].factor = 0;
  CHECK_THROWS_WITH(s.set_contact(contact), Catch::Contains("factor") && Catch::Contains("> 0"));
  contact.pairs[0] = {0, 2};
  CHECK_THROWS_AS(s.set_contact(contact), std::invalid_argument);
}

TEST_CASE("the order of the pairs changes nothing that matters") {
  const auto run = [](bool swapped) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("base"), {0, 0, 0}, {0.02, 0.01, 0.004}, 10, 5, 2);
    add_box(mesh, mesh.add_part("left"), {0.001, 0.002, 0.0041}, {0.007, 0.008, 0.01}, 3, 3, 3);
    add_box(mesh, mesh.add_part("right"), {0.012, 0.002, 0.0041}, {0.018, 0.008, 0.01}, 3, 3, 3);
    ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}, SolidMaterial{}});
    s.set_velocity(1, {0, 0, -5});
    s.set_velocity(2, {0, 0, -5});
    ContactOptions contact;
    contact.pairs =
        swapped ? std::vector<ContactPair>{{2, 0}, {1, 0}} : std::vector<ContactPair>{{0, 1}, {0, 2}};
    s.set_contact(contact);
    s.run_until(40e-6);
    return std::array<Vec3, 3>{s.mean_velocity(0), s.mean_velocity(1), s.mean_velocity(2)};
  };
  const auto a = run(false), b = run(true);
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(norm(a[k] - b[k]) < 1e-6);  // of 5 m/s: sums in another order, and what the rebound makes of that
}

TEST_CASE("coefficient of friction: static at rest, dynamic at speed, never above the static one") {
  ContactPair p;
  p.friction_static = 0.3;
  p.friction_dynamic = 0.2;
  p.decay = 20;
  CHECK(friction_coefficient(p, 0) == Approx(0.3));
  CHECK(friction_coefficient(p, 10) == Approx(0.2));
  CHECK(friction_coefficient(p, 0.05) == Approx(0.2 + 0.1 * std::exp(-1.0)));
}
