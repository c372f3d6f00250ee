// A magnet on a mesh drawn elsewhere: the same energy, current and pull as the built-in shape on the same mesh, the
// pull as the derivative of the energy whatever air stretches, halves and quarters, and what cannot move.

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <random>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/plane/magnet_field.h"
#include "tests/sim/magnetics/plane/four_gaps.h"

using namespace powbench::sim;
using Catch::Contains;

namespace {

using Role = DrawnRole;

/// The built-in core as if it had been drawn; `around`: what the air outside of the strip is.
std::shared_ptr<DrawnMagnet> as_drawn(const MagnetDesign& design, const CoreMeshSizes& sizes, Role around) {
  auto d = std::make_shared<DrawnMagnet>();
  d->mesh = core_mesh(design.shape, sizes, 6e-3);
  d->parts = {{"air", around},
              {"strip", Role::stretch},
              {"core", Role::fixed, 0},
              {"anchor", Role::armature, 0},
              {"coil", Role::coil, -1, design.turns},
              {"in", Role::ring, -1, 1},
              {"out", Role::ring, -1, -1}};
  if (design.shape.legs == 2) d->parts.push_back({"back", Role::coil, -1, -design.turns});
  if (design.shape.ring_share == 0) d->parts[5].role = d->parts[6].role = Role::air;
  d->steels = {design.steel.stacked(design.shape.stack_factor)};
  d->depth = design.shape.stack;
  d->copies = design.shape.legs == 3 ? 2 : 1;
  d->drawn_gap = strip_height;
  d->residual_gap = design.residual_gap;
  d->motion = drawn_motion(*d);
  return d;
}

CoreMeshSizes coarse() {
  return CoreMeshSizes{}.scaled(4);
}

/// A mesh of rectangles, each cut in two, between ascending lines.
Mesh grid_mesh(const std::vector<double>& x, const std::vector<double>& y,
               const std::function<int(double, double)>& region,
               const std::function<bool(double, double)>& zero) {
  Mesh m;
  for (const double b : y)
    for (const double a : x) {
      m.x.push_back(a);
      m.y.push_back(b);
      m.zero.push_back(zero(a, b) ? 1 : 0);
    }
  const int n = static_cast<int>(x.size());
  for (std::size_t j = 0; j + 1 < y.size(); ++j)
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const int v = static_cast<int>(j) * n + static_cast<int>(i);
      const bool up = 0.5 * (y[j] + y[j + 1]) > 0;  // cut as a mirror image
      if (up)
        m.triangle.insert(m.triangle.end(), {{v, v + 1, v + n + 1}, {v, v + n + 1, v + n}});
      else
        m.triangle.insert(m.triangle.end(), {{v, v + 1, v + n}, {v + 1, v + n + 1, v + n}});
      m.region.insert(m.region.end(), 2, region(0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])));
    }
  return m;
}

double far_from(double a, double b, double scale) {
  return std::fabs(a - b) / scale;
}

}  // namespace

TEST_CASE("the built-in core as a drawing has its energy, currents and pull at every gap", "[fields]") {
  std::mt19937_64 random(GENERATE(1u, 2u));
  MagnetDesign design;
  if (GENERATE(3, 2) == 2) {
    design.shape.legs = 2;
    design.shape.outer_width = design.shape.yoke = 12e-3;
  }
  MagnetField core(design, {coarse(), 2, 6e-3, {}});
  DrawnField field(as_drawn(design, coarse(), Role::air), {});
  REQUIRE(field.has_ring());
  for (int k = 0; k < 4; ++k) {
    const double gap = std::uniform_real_distribution(0.0, 5e-3)(random);
    const double psi = std::uniform_real_distribution(0.05, 1.2)(random);
    const double ring = psi / design.turns * std::uniform_real_distribution(0.1, 0.6)(random);
    core.set_gap(gap);
    field.set_gap(gap);
    const auto a = core.at_flux(psi, ring).response, b = field.at_flux(psi, ring).response;
    CAPTURE(gap, psi, ring);
    CHECK(far_from(a.energy, b.energy, a.energy) < 1e-9);
    CHECK(far_from(a.current, b.current, a.current) < 1e-8);
    CHECK(far_from(a.ring_current, b.ring_current, std::fabs(a.ring_current) + 1) < 1e-7);
    CHECK(far_from(a.pull, b.pull, a.pull) < 1e-8);
    CHECK(far_from(a.current_gap, b.current_gap, std::fabs(a.current_gap)) < 1e-6);
    CHECK(far_from(a.ring_gap, b.ring_gap, std::fabs(a.ring_gap) + a.pull) < 1e-6);
  }
}

TEST_CASE(
    "with all air stretching the pull is the derivative of the energy and that of the strip to the mesh",
    "[fields]") {
  std::mt19937_64 random(GENERATE(3u, 4u));
  const MagnetDesign design;
  const auto drawing = as_drawn(design, coarse(), Role::stretch);
  DrawnField field(drawing, {1e-12});
  MagnetField core(design, {coarse(), 2, 6e-3, {}});
  for (int k = 0; k < 3; ++k) {
    const double gap = std::uniform_real_distribution(0.05e-3, 6e-3)(random);
    const double psi = std::uniform_real_distribution(0.05, 1.2)(random), step = 1e-3 * (gap + 36e-6);
    field.set_gap(gap);
    const auto here = field.at_flux(psi, 0, {}, true).response;
    field.set_gap(gap + step);
    const auto above = field.at_flux(psi, 0, {}, true).response;
    field.set_gap(gap - step);
    const auto below = field.at_flux(psi, 0, {}, true).response;
    core.set_gap(gap);
    const auto strip = core.at_flux(psi, 0, {}, true).response;
    CAPTURE(gap, psi);
    CHECK(here.pull == Approx((above.energy - below.energy) / (2 * step)).epsilon(2e-6));
    CHECK(here.current_gap == Approx((above.current - below.current) / (2 * step)).epsilon(2e-6));
    CHECK(here.current == Approx(strip.current).epsilon(0.01));
    CHECK(here.pull == Approx(strip.pull).epsilon(0.02));
  }
}

TEST_CASE("the air that stretches does so from a closed magnet to any gap, and inside out nowhere",
          "[fields]") {
  MagnetDesign design;
  design.shape.centre_gap = GENERATE(0.0, 0.3e-3);
  const auto drawing = as_drawn(design, CoreMeshSizes{}.scaled(GENERATE(3.0, 6.0)), Role::stretch);
  const auto [from, to] = usable_gaps(*drawing);
  CHECK(measured_gap(*drawing) == Approx(strip_height).epsilon(1e-9));
  CHECK(from < 2e-6);
  CHECK(to > 20e-3);
  CHECK(least_angle(*drawing, 36e-6) > 0);
  CHECK(least_angle(*drawing, 8e-3) > 0);
  for (const double m : drawing->motion) CHECK((m >= 0 && m <= 1));
}

TEST_CASE("a quarter is the half whose other half is its image: energy, flux and pull", "[fields]") {
  // two I-shaped cores face to face, a coil round each, in series
  const std::vector<double> x{0, 3e-3, 6e-3, 8e-3, 12e-3, 16e-3, 30e-3, 60e-3};
  const std::vector<double> rows{0, 0.5e-3, 1e-3, 3e-3, 9e-3, 15e-3, 20e-3, 35e-3, 60e-3};
  enum { air, layer, iron, coil, lower_iron, lower_coil };
  const auto region = [](double a, double b) {
    const double h = std::fabs(b);
    if (h < 1e-3) return static_cast<int>(layer);
    if (a < 8e-3 && h < 20e-3) return static_cast<int>(b > 0 ? iron : lower_iron);
    if (a > 8e-3 && a < 16e-3 && h > 3e-3 && h < 15e-3) return static_cast<int>(b > 0 ? coil : lower_coil);
    return static_cast<int>(air);
  };
  const auto zero = [](double a, double b) { return a == 0 || a == 60e-3 || std::fabs(b) == 60e-3; };
  auto quarter = std::make_shared<DrawnMagnet>(), half = std::make_shared<DrawnMagnet>();
  quarter->parts = {{"air", Role::air},
                    {"layer", Role::stretch},
                    {"iron", Role::armature, 0},
                    {"coil", Role::coil, -1, 500}};
  half->parts = quarter->parts;
  half->parts.push_back({"lower", Role::fixed, 0});
  half->parts.push_back({"lower coil", Role::coil, -1, 500});
  quarter->mesh = grid_mesh(x, rows, region, zero);
  std::vector<double> both;
  for (std::size_t k = rows.size() - 1; k > 0; --k) both.push_back(-rows[k]);
  both.insert(both.end(), rows.begin(), rows.end());
  half->mesh = grid_mesh(x, both, region, zero);
  for (auto& d : {quarter, half}) {
    d->steels = {builtin_steel("lamination")};
    d->depth = 20e-3;
    d->copies = d == quarter ? 4 : 2;
    d->drawn_gap = 2e-3;
    d->motion = drawn_motion(*d);
    CHECK(measured_gap(*d) == Approx(2e-3));
    CHECK(triangles_across_gap(*d) == 8);  // four rows of cells, each cut in two
    CHECK(d->turns() == Approx(1000));
  }
  DrawnField a(quarter, {}), b(half, {});
  for (const double gap : {0.0, 1.3e-3, 4e-3}) {
    a.set_gap(gap);
    b.set_gap(gap);
    const auto p = a.at_flux(0.4, 0), q = b.at_flux(0.4, 0);
    CHECK(p.response.energy == Approx(q.response.energy).epsilon(1e-9));
    CHECK(p.response.current == Approx(q.response.current).epsilon(1e-8));
    CHECK(p.response.pull == Approx(q.response.pull).epsilon(1e-8));
  }
}

TEST_CASE("a drawing that cannot move is refused with the parts that hold it", "[fields]") {
  auto d = as_drawn({}, coarse(), Role::air);
  const auto refusal = [&] {
    try {
      static_cast<void>(drawn_motion(*d));
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  d->parts[1].role = Role::air;
  CHECK_THAT(refusal(), Contains("joined to the fixed iron 'core'") && Contains("'strip'"));
  d->parts[1].role = Role::stretch;
  d->parts[3].role = Role::fixed;
  CHECK_THAT(refusal(), Contains("no part is the armature"));
}

TEST_CASE("the table of a drawing is that of the built-in shape on its mesh, nodes apart", "[fields]") {
  const MagnetDesign design;
  const auto drawing = as_drawn(design, sizes_for(0.002), Role::air);
  TableOptions o;
  o.ring = false;
  o.psi_nodes = 8;
  o.gap_nodes = 5;
  Team team(2);
  TableReport report;
  drawing->largest_flux =
      design.turns * design.shape.centre_width * design.shape.stack * design.shape.stack_factor * 2.4;
  const TablePotential drawn(build_table(drawing, o, team, &report)), shape(build_table(design, o, team));
  CHECK(report.stress_error < 0.05);
  CHECK(drawn.table().mesh_error < 0.01);
  double current = 0, pull = 0;
  for (std::size_t n = 0; n < shape.table().nodes.size(); n += 4) {
    const auto &a = shape.table().nodes, &b = drawn.table().nodes;
    current = std::max(current, std::fabs(a[n + 1] - b[n + 1]) / (std::fabs(a[n + 1]) + 1e-4));
    pull = std::max(pull, std::fabs(a[n + 2] - b[n + 2]) / (std::fabs(a[n + 2]) + 1e-2));
  }
  CHECK(current < 1e-4);
  CHECK(pull < 1e-4);
  drawing->largest_flux = 0;
  CHECK(saturated_flux(drawing) > 0.8);
  CHECK(saturated_flux(drawing) < 2);
}

TEST_CASE("four gaps of a drawing side by side are four gaps, from any start and into saturation",
          "[fields]") {
  const MagnetDesign design;
  const auto drawing = as_drawn(design, CoreMeshSizes{}.scaled(6), Role::stretch);
  check_four_gaps(DrawnGap(drawing), 5e-3, 1, design.turns, GENERATE(11u, 12u));
}

TEST_CASE("a table by extrapolated starts is that of states solved alone, to the same bit by any team",
          "[fields]") {
  const auto drawing = as_drawn({}, CoreMeshSizes{}.scaled(7), Role::stretch);
  TableOptions o;
  o.psi_nodes = 10;
  o.gap_nodes = 8;
  o.ring_nodes = 4;
  for (const bool ring : {false, true}) {
    o.ring = ring;
    Team one(1), three(3);
    const auto t = build_table(drawing, o, one), other = build_table(drawing, o, three);
    CHECK(t.nodes == other.nodes);
    CHECK(t.air == other.air);
    CHECK(t.mesh_error == other.mesh_error);
    DrawnField field(drawing, {1e-14});
    const std::size_t values = t.values(), pull = values / 2, rings = std::max<std::size_t>(1, t.ring.size());
    double largest_pull = 0, largest_current = 0, current = 0, force = 0, slope = 0;
    for (std::size_t n = 0; n < t.nodes.size(); n += values) {
      largest_current = std::max(largest_current, std::fabs(t.nodes[n + 1]));
      largest_pull = std::max(largest_pull, std::fabs(t.nodes[n + pull]));
    }
    for (const std::size_t g : {1U, 2U, 7U}) {
      std::size_t n = g * rings * t.psi.size() * values;
      field.set_gap(t.gap[g]);
      for (std::size_t r = 0; r < rings; ++r)
        for (const double psi : t.psi) {
          const double loop = ring ? t.ring[r] : 0;
          const auto alone = field.at_flux(psi + t.ring_ratio * loop, loop, {}, !ring).response;
          const double* const node = t.nodes.data() + n;
          const double i = std::max(std::fabs(alone.current), 0.002 * largest_current),
                       f = std::max(std::fabs(alone.pull), 0.002 * largest_pull);
          current = std::max(current, std::fabs(node[1] - alone.current) / i);
          force = std::max(force, std::fabs(node[pull] - alone.pull) / f);
          const double across = node[ring ? 5 : 3] - alone.current_gap;
          slope = std::max(slope, std::fabs(across) * t.psi.back() / largest_pull);
          n += values;
        }
    }
    // far below the 0.5 % that are promised, interpolation included
    CHECK(current < 1e-5);
    CHECK(force < 1e-5);
    CHECK(slope < 1e-3);
  }
}

TEST_CASE("where a drawing's table ends is stated within its saturation, or found there", "[fields]") {
  const auto drawing = as_drawn({}, CoreMeshSizes{}.scaled(7), Role::stretch);
  TableOptions o;
  o.psi_nodes = 12;
  o.gap_nodes = 6;
  o.ring = false;
  Team team(2);
  const auto t = build_table(drawing, o, team);
  CHECK(extrapolated_share(t).largest_field < 2.6);
  const double end = t.psi.back();
  for (const double stated : {100.0, 3 * end, 0.01 * end, 1e-6}) {
    drawing->largest_flux = stated;
    CHECK_THROWS_WITH(build_table(drawing, o, team), Contains("largest_flux_Wb = ") && Contains("allowed"));
  }
  drawing->largest_flux = 2 * end;
  CHECK(build_table(drawing, o, team).psi.back() == 2 * end);
}

TEST_CASE("a drawing's table with ring is as near the field as it says, along both knees", "[fields]") {
  const auto drawing = as_drawn({}, CoreMeshSizes{}.scaled(7), Role::stretch);
  TableOptions o;
  o.psi_nodes = 18;
  o.gap_nodes = 12;
  o.ring_nodes = 12;
  Team team(2);
  const auto table = build_table(drawing, o, team);
  CHECK(std::fabs(table.ring_ratio) > 0);
  double stated = 0;
  for (const auto* errors : {&table.current_error, &table.pull_error})
    stated = std::max(stated, *std::max_element(errors->begin(), errors->end()));
  CHECK(stated < 0.02);
  const TablePotential t(table);
  DrawnField field(drawing, {1e-12});
  std::mt19937_64 random(5);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  double largest_current = 0, largest_pull = 0, current = 0, ring_current = 0, pull = 0, of_ring = 0;
  for (int k = 0; k < 60; ++k) {
    const double ring = number(table.ring.front(), table.ring.back()), gap = number(0, 5e-3);
    const double psi = number(0, table.psi.back()) + table.ring_ratio * ring;
    field.set_gap(gap);
    const auto a = t.at({psi, ring, gap}), b = field.at_flux(psi, ring).response;
    CHECK_FALSE(a.beyond);
    largest_current = std::max(largest_current, std::fabs(b.current));
    largest_pull = std::max(largest_pull, b.pull);
    of_ring = std::max(of_ring, std::fabs(b.ring_current));
    current = std::max(current, std::fabs(a.current - b.current));
    ring_current = std::max(ring_current, std::fabs(a.ring_current - b.ring_current));
    pull = std::max(pull, std::fabs(a.pull - b.pull));
    const auto c = t.at({-psi, -ring, gap});  // both polarities are one
    CHECK(c.current == -a.current);
    CHECK(c.ring_current == -a.ring_current);
    CHECK(c.pull == a.pull);
    CHECK(c.ring_gap == -a.ring_gap);
  }
  CHECK(current < stated * largest_current);
  CHECK(ring_current < stated * of_ring);
  CHECK(pull < stated * largest_pull);
}

TEST_CASE("a solution on the halved mesh is the same function of the place", "[fields]") {
  for (const bool round : {false, true}) {
    auto d = as_drawn({}, coarse(), Role::stretch);
    d->axisymmetric = round;
    const auto fine = std::make_shared<const DrawnMagnet>(refined(*d));
    const DrawnField one(d, {}), other(fine, {});
    const auto &space = one.problem().space(), &halved = other.problem().space();
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(-1, 1);
    std::vector<double> a(static_cast<std::size_t>(space.size()) + 1, 0);
    for (std::size_t k = 0; k + 1 < a.size(); ++k) a[k] = number(random);
    const auto b = on_refined(space, a, halved);
    // the middle of the inner part is that of the triangle; the middle of the first one lies at 2/3, 1/6, 1/6
    const auto value = [](const FieldSpace& s, std::size_t t, const std::array<double, 3>& l,
                          const std::vector<double>& v) {
      const auto shape = shape_at(s, t, l);
      double sum = 0;
      for (std::size_t k = 0; k < 6; ++k)
        sum += shape.value[k] * v[static_cast<std::size_t>(s.unknowns(t)[k])];
      return sum;
    };
    const std::array<double, 3> middle{1. / 3, 1. / 3, 1. / 3}, first{2. / 3, 1. / 6, 1. / 6};
    for (std::size_t t = 0; t < space.mesh.triangle.size(); ++t) {
      CHECK(value(halved, 4 * t + 3, middle, b) == Approx(value(space, t, middle, a)).margin(1e-12));
      CHECK(value(halved, 4 * t, middle, b) == Approx(value(space, t, first, a)).margin(1e-12));
    }
  }
}
