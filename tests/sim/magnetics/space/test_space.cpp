// Magnets drawn in space: the C-core's grid cut into tetrahedra, beside the C-core itself.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "sim/magnetics/plane/core_outline.h"
#include "sim/magnetics/space/core_mesh.h"
#include "sim/magnetics/space/face_tree.h"
#include "sim/magnetics/space/space_magnet.h"

namespace sim = powbench::sim;
using sim::DrawnRole;
using sim::Vec3;

namespace {

sim::MagnetDesign c_core() {
  sim::MagnetDesign d;
  d.shape.legs = 2;
  d.shape.closed_leg = 1;
  d.shape.ring_share = 0;
  d.shape.outer_width = 8e-3;
  d.shape.stack_factor = 1;
  return d;
}

sim::space::CoreMeshSizes flat() {
  auto sizes = sim::space::CoreMeshSizes{}.scaled(4);
  sizes.ends = false;
  return sizes;
}

/// Each cell of the core's grid as six tetrahedra.
sim::SpaceMagnet cut_core(const sim::MagnetDesign& design, const sim::space::CoreMeshSizes& sizes,
                          double gap) {
  const auto problem = sim::space::core_problem(design, sizes, gap);
  const auto& from = problem.mesh;
  sim::SpaceMagnet d;
  d.parts = {{"below", DrawnRole::air, -1, {}},        {"above", DrawnRole::air, -1, {}},
             {"strip", DrawnRole::stretch, -1, {}},    {"core", DrawnRole::fixed, 0, {}},
             {"armature", DrawnRole::armature, 0, {}}, {"leg", DrawnRole::stretch, 0, {}},
             {"coil", DrawnRole::coil, -1, {}}};
  const sim::CoreOutline o(design.shape, gap);
  const double coil_y = design.shape.stack / 2 + o.coil_left - o.x1;
  d.parts[6].coil = {
      0, 0, o.coil_left, coil_y, 0, o.coil_right - o.coil_left, o.coil_bottom, o.coil_top, design.turns, 2};
  d.steels = {design.steel};
  d.copies = 2;
  d.drawn_gap = gap;
  d.residual_gap = design.residual_gap;
  sim::space::Mesh mesh{sim::space::Cell::tet4, from.nodes, {}, {}};
  constexpr int cut[6][4] = {{0, 1, 2, 6}, {0, 1, 5, 6}, {0, 3, 2, 6},
                             {0, 3, 7, 6}, {0, 4, 5, 6}, {0, 4, 7, 6}};
  for (int c = 0; c < from.count(); ++c) {
    const int* cell = from.cells.data() + 20 * static_cast<std::ptrdiff_t>(c);
    const double z = 0.5 * (from.nodes[static_cast<std::size_t>(cell[0])].z +
                            from.nodes[static_cast<std::size_t>(cell[6])].z);
    const bool iron = from.region[static_cast<std::size_t>(c)] == sim::space::CoreRegion::iron;
    const int level = z < 0 ? 0 : z > gap ? 1 : 2;
    for (const auto& t : cut) {
      for (const int k : t) mesh.cells.push_back(cell[k]);
      mesh.region.push_back(level + (iron ? 3 : 0));
    }
  }
  d.mesh = sim::space::straight_tetrahedra(mesh);
  d.motion = sim::space_motion(d);
  return d;
}

}  // namespace

TEST_CASE("space: the nearest triangle of a tree is that of a search through all") {
  std::vector<sim::Face3> faces;
  unsigned seed = 7;
  const auto number = [&] { return (seed = seed * 1664525u + 1013904223u) / 4294967296.0; };
  for (int k = 0; k < 200; ++k) {
    const Vec3 a{number(), number(), number()};
    faces.push_back({a, a + Vec3{0.1 * number(), 0.1, 0}, a + Vec3{0, 0.1 * number(), 0.1}});
  }
  const sim::FaceTree tree(faces);
  for (int k = 0; k < 50; ++k) {
    const Vec3 p{2 * number() - 0.5, 2 * number() - 0.5, number()};
    double least = 1e300;
    for (const auto& f : faces) least = std::fmin(least, sim::distance(f, p));
    CHECK(tree.nearest(p) == least);
  }
  const sim::Face3 f{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  CHECK(sim::distance(f, {0.2, 0.3, -2}) == Approx(2));          // over the inside
  CHECK(sim::distance(f, {1, 1, 0}) == Approx(std::sqrt(0.5)));  // nearest to an edge
  CHECK(sim::distance(f, {-3, -4, 0}) == Approx(5));             // to a corner
}

TEST_CASE("space: the C-core's grid in tetrahedra moves, and has gaps, as the core does") {
  const double gap = 1e-3;
  const auto d = cut_core(c_core(), flat(), gap);
  CHECK(sim::measured_gap(d) == Approx(gap).epsilon(1e-9));
  double worst = 0;
  for (std::size_t n = 0; n < d.motion.size(); ++n)
    worst = std::fmax(worst, std::fabs(d.motion[n] - std::clamp(d.mesh.nodes[n].z / gap, 0.0, 1.0)));
  CHECK(worst < 1e-9);
  const auto [from, to] = sim::usable_gaps(d);
  CHECK(from < 1e-9);
  CHECK(std::isinf(to));
  auto stuck = d;
  for (auto& p : stuck.parts)
    if (p.role == DrawnRole::stretch && p.steel < 0) p.role = DrawnRole::air;
  CHECK_THROWS_WITH(sim::space_motion(stuck), Catch::Contains("joined to the fixed iron 'core' by"));
  for (auto& p : stuck.parts) p.role = DrawnRole::air;
  CHECK_THROWS_WITH(sim::space_motion(stuck), Catch::Contains("no part is the armature"));
}

TEST_CASE(
    "space: the C-core's grid in tetrahedra has its states, and a pull that is the derivative of its "
    "energy") {
  const auto design = c_core();
  const auto d = cut_core(design, flat(), 1e-3);
  auto field = sim::space_field(d, false);
  sim::space::MagnetField core(design, flat());
  CHECK(d.turns() == design.turns);
  const double psi = design.turns * 1.2 * design.shape.centre_width * design.shape.stack;
  for (const double gap : {0.1e-3, 3e-3}) {
    const auto at = [&](double flux, double g) {
      field.set_gap(g);
      const auto p = field.at_flux(flux, 0);
      REQUIRE(p.solution.converged);
      return p.response;
    };
    const auto r = at(psi, gap);
    core.set_gap(gap);
    const auto c = core.at_flux(psi, 0).response;
    std::printf("gap %.1f mm: tetrahedra %+.2f %% in the current, %+.2f %% in the pull off the bricks\n",
                gap * 1e3, 100 * (r.current / c.current - 1), 100 * (r.pull / c.pull - 1));
    // six tetrahedra hold complete polynomials of order two, a brick of twenty nodes a few more
    CHECK(r.current == Approx(c.current).epsilon(0.01));
    CHECK(r.pull == Approx(c.pull).epsilon(0.01));
    if (gap > 1e-3) continue;
    const double dg = 1e-3 * (gap + d.residual_gap), dp = 1e-4 * psi;
    const auto g1 = at(psi, gap + dg), g0 = at(psi, gap - dg), p1 = at(psi + dp, gap), p0 = at(psi - dp, gap);
    CHECK(r.pull == Approx((g1.energy - g0.energy) / (2 * dg)).epsilon(2e-5));
    CHECK(r.current_gap == Approx((g1.current - g0.current) / (2 * dg)).epsilon(1e-4));
    CHECK(r.current_gap == Approx((p1.pull - p0.pull) / (2 * dp)).epsilon(1e-4));
  }
}

TEST_CASE(
    "space: a table with ring has at its nodes the states of the field, currents and pull of one potential",
    "[.slow]") {
  auto sizes = flat();
  for (double* size : {&sizes.corner, &sizes.other, &sizes.largest}) *size *= 3;
  sizes.layers = 1;
  const auto design = c_core();
  auto d = cut_core(design, sizes, 1e-3);
  const sim::CoreOutline o(design.shape, 1e-3);
  // round the leg of the coil, above it
  d.parts.push_back({"ring", DrawnRole::ring, -1, {}});
  d.parts.back().coil = {0, 0, o.x1, design.shape.stack / 2, 0, o.coil_left - o.x1, o.coil_top, 0, 1, 2};
  REQUIRE(d.has_ring());
  d.travel = 2e-3;
  sim::TableOptions options;
  options.accuracy = 0.05;
  options.psi_nodes = options.gap_nodes = options.ring_nodes = 4;
  options.largest_gap = 3e-3;
  sim::TableReport report;
  const sim::TablePotential table(sim::build_table(d, options, &report));
  REQUIRE(table.has_ring());
  CHECK(report.solutions == 64);
  CHECK(table.table().mesh_error > 0);
  CHECK(table.table().design_hash == sim::table_hash(d, options));
  auto field = sim::space_field(d, false);
  const double psi = table.table().psi[1], ring = table.table().ring[2], gap = table.table().gap[1];
  // of each state how far the steel is driven, and so what share is above its B-H data
  REQUIRE(table.table().steel_field.size() == 64);
  const auto share = sim::extrapolated_share(table.table());
  CHECK(share.largest_field > 1.2);  // far more where the fluxes of coil and ring are opposed
  CHECK(share.share > 0);
  CHECK(share.share < 1);
  CHECK(table.table().data_end > 0);
  field.set_gap(gap);
  const auto state = field.at_flux(psi, ring).solution.state;
  CHECK(table.table().steel_field[1 + 4 * (2 + 4 * 1)] ==
        Approx(field.function().largest_steel_field(state)).epsilon(1e-4));
  const auto at = [&](double r, double g) {
    field.set_gap(g);
    return field.at_flux(psi, r).response;
  };
  const auto r = at(ring, gap);
  const auto t = table.at({psi, ring, gap});
  CHECK(t.current == Approx(r.current).epsilon(1e-5));
  CHECK(t.ring_current == Approx(r.ring_current).epsilon(1e-5));
  CHECK(t.pull == Approx(r.pull).epsilon(1e-5));
  const double dg = 1e-3 * gap, dr = 1e-3 * std::fabs(ring);
  const auto g1 = at(ring, gap + dg), g0 = at(ring, gap - dg), r1 = at(ring + dr, gap),
             r0 = at(ring - dr, gap);
  CHECK(r.pull == Approx((g1.energy - g0.energy) / (2 * dg)).epsilon(1e-4));
  CHECK(r.ring_current == Approx((r1.energy - r0.energy) / (2 * dr)).epsilon(1e-3));
  CHECK(r.ring_gap == Approx((g1.ring_current - g0.ring_current) / (2 * dg)).epsilon(1e-3));
  CHECK(r.ring_gap == Approx((r1.pull - r0.pull) / (2 * dr)).epsilon(1e-3));
}

TEST_CASE("space: the source of a winding has its ampere-turns round any axis") {
  for (const int axis : {0, 1, 2}) {
    sim::space::BoxCoil coil{0, 0, 4e-3, 3e-3, 1e-3, 2e-3, -5e-3, 5e-3, 10, axis};
    const auto t = sim::space::coil_field(coil);
    const auto at = [&](double u, double v, double w) {
      Vec3 p{};
      const auto a = static_cast<std::size_t>(axis);
      p[(a + 1) % 3] = u;
      p[(a + 2) % 3] = v;
      p[a] = w;
      return t(p);
    };
    const auto a = static_cast<std::size_t>(axis);
    CHECK(at(0, 0, 0)[a] == Approx(10 / 10e-3));
    CHECK(at(5e-3, 0, 0)[a] == Approx(0.5 * 10 / 10e-3));
    CHECK(at(0, 4e-3, 4e-3)[a] == Approx(0.5 * 10 / 10e-3));
    CHECK(at(0, 0, 6e-3)[a] == 0);
    CHECK(at(7e-3, 0, 0)[a] == 0);
    // a frame of two rectangles, its corners rounded by 1 and 3 mm
    CHECK(coil.volume() == Approx(10e-3 * (12e-3 * 10e-3 - 8e-3 * 6e-3 - (4 - M_PI) * (9e-6 - 1e-6))));
  }
}
