#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "sim/magnetics/space/end_table.h"

namespace sim = powbench::sim;

namespace {

/// A small core whose edges lie on few planes, so that few cells hold it.
sim::MagnetDesign little_core() {
  sim::MagnetDesign d;
  auto& s = d.shape;
  s.coil_width = s.window_width;
  s.coil_offset = 0;
  s.coil_height =
      s.fixed_window - s.ring_depth - 0.1e-6;  // below the ring, which would get thinner beside it
  return d;
}

sim::space::CoreMeshSizes few_cells(bool ends = true) {
  sim::space::CoreMeshSizes s{.corner = 6e-3, .other = 12e-3, .largest = 20e-3, .far = 100e-3, .growth = 5};
  s.layers = 2;
  s.ends = ends;
  return s;
}

}  // namespace

TEST_CASE(
    "A ring's leakage in series adds its flux and its energy, in the plane as on the cells of three "
    "dimensions") {
  sim::MagnetDesign bare, leaky;
  leaky.ring_leakage = 2e-8;
  const auto sizes = few_cells(false);
  sim::space::MagnetField a(bare, sizes), b(leaky, sizes);
  sim::MagnetField c(bare, {}), d(leaky, {});
  const double current = 0.4, ring = -150;
  const auto p = a.at_current(current, ring), q = b.at_current(current, ring);
  CHECK(q.ring == Approx(p.ring + 2e-8 * ring).epsilon(1e-9));
  CHECK(q.response.energy == Approx(p.response.energy + 1e-8 * ring * ring).epsilon(1e-9));
  CHECK(q.psi == Approx(p.psi).epsilon(1e-9));
  CHECK(b.at_flux(q.psi, q.ring).response.ring_current == Approx(ring).epsilon(1e-6));
  const auto r = c.at_current(current, ring), s = d.at_current(current, ring);
  CHECK(d.fluxes(s).second == Approx(c.fluxes(r).second + 2e-8 * ring).epsilon(1e-9));
  const auto back = d.at_flux(d.fluxes(s).first, d.fluxes(s).second);
  CHECK(back.response.ring_current == Approx(ring).epsilon(1e-6));
  CHECK(back.response.energy == Approx(r.response.energy + 1e-8 * ring * ring).epsilon(1e-6));
  CHECK(sim::table_hash(leaky, {}) != sim::table_hash(bare, {}));
}

TEST_CASE("A table in three dimensions with a ring gives back its states and their mirror images",
          "[.slow]") {
  const auto design = little_core();
  sim::TableOptions options;
  options.psi_nodes = options.gap_nodes = 4;
  options.ring_nodes = 5;
  options.largest_gap = 2e-3;
  options.largest_field = 1.2;
  const auto sizes = few_cells();
  int called = 0, last = 0;
  sim::TableReport report;
  const auto t = sim::space::build_table(design, sizes, options, &report, [&](int done, int all) {
    ++called;
    last = done;
    CHECK(all == 80);
  });
  CHECK_NOTHROW(sim::check_table(t));
  REQUIRE(t.ring.size() == 5);
  CHECK(report.solutions == 80);
  CHECK(called == 4);
  CHECK(last == 80);
  sim::space::MagnetField field(design, sizes);
  for (const auto [p, r, g] : {std::array<std::size_t, 3>{1, 1, 1}, {2, 3, 2}}) {
    field.set_gap(t.gap[g]);
    const auto direct = field.at_flux(t.psi[p], t.ring[r]).response;
    const double* const found = t.nodes.data() + 8 * (p + t.psi.size() * (r + t.ring.size() * g));
    const double right[] = {direct.energy, direct.current,     direct.ring_current, direct.current_ring,
                            direct.pull,   direct.current_gap, direct.ring_gap};
    for (std::size_t k = 0; k < 7; ++k) {
      CAPTURE(k);
      CHECK(found[k] == Approx(right[k]).epsilon(1e-4));
    }
  }
  // the node of the mirrored line is the mirror image
  const auto node = [&](std::size_t r, std::size_t k) { return t.nodes[(t.psi.size() * r) * 8 + k]; };
  for (const std::size_t k : {0, 4}) CHECK(node(1, k) == Approx(node(3, k)).epsilon(1e-9));
  for (const std::size_t k : {1, 2}) CHECK(node(1, k) == Approx(-node(3, k)).epsilon(1e-9));
}

TEST_CASE("The table with ends and ring: plane, plus whole less flat, between the nodes too", "[.slow]") {
  auto design = little_core();
  sim::TableOptions options;
  options.accuracy = 0.05;
  options.psi_nodes = 12;
  options.ring_nodes = 11;
  options.gap_nodes = 5;
  options.largest_gap = 2e-3;
  options.largest_field = 1.8;
  sim::EndTableOptions ends;
  ends.sizes = few_cells();
  ends.psi_nodes = 7;
  ends.ring_nodes = 5;
  ends.gap_nodes = 4;
  sim::Team team(2);
  const sim::TablePotential table(sim::build_table_with_ends(design, options, ends, team));
  REQUIRE(table.has_ring());
  CHECK(table.table().design_hash == sim::end_table_hash(design, options, ends));
  auto open = options;
  open.ring = false;
  const sim::TablePotential two(sim::build_table_with_ends(design, open, ends, team));
  CHECK_FALSE(two.has_ring());
  CHECK(two.table().design_hash != table.table().design_hash);

  const auto heads = sim::space::end_corrections(design, few_cells(), 0.05, {ends.leakage_gap}).front();
  auto leaky = design;
  leaky.end_leakage = heads.leakage;
  leaky.ring_leakage = heads.ring_leakage;
  CHECK(heads.ring_leakage > 0);
  sim::space::MagnetField whole(design, few_cells()), flat(leaky, few_cells(false));
  sim::MagnetField plane(leaky, sim::plan_table(design, options).field);
  std::mt19937 random(20261);
  std::uniform_real_distribution<double> any(0, 1);
  const double psi_end = table.table().psi.back(), ring_end = table.table().ring.back();
  double current_sum = 0, pull_sum = 0;
  int states = 0;
  for (int k = 0; k < 4; ++k) {
    const double gap = 2e-3 * any(random) * any(random);
    whole.set_gap(gap), flat.set_gap(gap), plane.set_gap(gap);
    for (int n = 0; n < 4; ++n) {
      const double x = 0.1 + 0.7 * any(random), psi = psi_end * x,
                   ring = ring_end * x * (0.3 + 0.7 * any(random));
      const auto a = whole.at_flux(psi, ring).response, b = flat.at_flux(psi, ring).response,
                 c = plane.at_flux(psi, ring).response, t = table.at({psi, ring, gap});
      CAPTURE(gap, psi, ring, a.current, c.current, t.current, a.ring_current, c.ring_current,
              t.ring_current);
      const double current = c.current + a.current - b.current, pull = c.pull + a.pull - b.pull,
                   ring_current = c.ring_current + a.ring_current - b.ring_current;
      // ampere-turns of both, for either may pass through zero
      const double turns = design.turns * std::fabs(current) + std::fabs(ring_current);
      const double off =
          (design.turns * std::fabs(t.current - current) + std::fabs(t.ring_current - ring_current));
      CHECK(off < 0.05 * turns);
      CHECK(t.pull == Approx(pull).epsilon(0.05));
      current_sum += off * off / (turns * turns);
      pull_sum += (t.pull / pull - 1) * (t.pull / pull - 1);
      ++states;
      // one potential, symmetric to the last bit
      const auto mirror = table.at({-psi, -ring, gap});
      CHECK(mirror.current == -t.current);
      CHECK(mirror.ring_current == -t.ring_current);
      CHECK(mirror.pull == t.pull);
      const double h = 1e-5 * psi_end, hr = 1e-5 * ring_end;
      const auto slope = [&](double dp, double dr) {
        return table.at({psi + dp, ring + dr, gap}).pull - table.at({psi - dp, ring - dr, gap}).pull;
      };
      const double scale = std::fabs(t.pull) / psi_end, ring_scale = std::fabs(t.pull) / ring_end;
      CHECK(slope(h, 0) / (2 * h) == Approx(t.current_gap).margin(1e-3 * scale));
      CHECK(slope(0, hr) / (2 * hr) == Approx(t.ring_gap).margin(1e-3 * ring_scale));
    }
  }
  CHECK(std::sqrt(current_sum / states) < 0.01);
  CHECK(std::sqrt(pull_sum / states) < 0.01);

  // where the ring's current is zero it is the table without: the least energy over the ring flux
  for (const double gap : {0.2e-3, 1.1e-3}) {
    const double psi = 0.45 * psi_end;
    sim::MagneticState s{psi, 0, gap};
    for (int k = 0; k < 60; ++k) {
      const auto r = table.at(s);
      s.ring -= 0.8 * r.ring_current / r.ring_ring;
    }
    const auto with = table.at(s), without = two.at(s);
    CAPTURE(gap, s.ring, with.current, without.current);
    CHECK(std::fabs(with.ring_current) < 1e-3);
    CHECK(with.current == Approx(without.current).epsilon(0.01));
    CHECK(with.pull == Approx(without.pull).epsilon(0.01));
    CHECK(with.energy == Approx(without.energy).epsilon(0.01));
  }
}
