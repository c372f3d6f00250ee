#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "sim/magnetics/space/end_table.h"

namespace sim = powbench::sim;

namespace {

sim::space::CoreMeshSizes coarse(bool ends) {
  auto sizes = sim::space::CoreMeshSizes{}.scaled(4);
  sizes.ends = ends;
  return sizes;
}

}  // namespace

TEST_CASE("An inductance in series adds its flux and its energy, with and without given flux") {
  sim::MagnetDesign bare, leaky;
  leaky.end_leakage = 0.2;
  sim::space::MagnetField a(bare, coarse(false)), b(leaky, coarse(false)), whole(leaky, coarse(true)),
      same(bare, coarse(true));
  const double current = 0.4;
  const auto p = a.at_current(current), q = b.at_current(current);
  CHECK(q.psi == Approx(p.psi + 0.2 * current).epsilon(1e-9));
  CHECK(q.response.energy == Approx(p.response.energy + 0.1 * current * current).epsilon(1e-9));
  CHECK(q.response.pull == Approx(p.response.pull).epsilon(1e-9));
  const auto back = b.at_flux(q.psi, 0, {}, true);
  CHECK(back.response.current == Approx(current).epsilon(1e-7));
  // with ends the leakage is in the mesh: nothing is added
  CHECK(whole.at_current(current).psi == same.at_current(current).psi);
}

TEST_CASE("Tables in three dimensions do without a ring", "[.slow]") {
  sim::MagnetDesign design;
  design.shape.ring_share = 0;
  sim::TableOptions options;
  options.psi_nodes = 8;
  options.gap_nodes = 4;
  sim::TableReport report;
  const sim::TablePotential table(sim::space::build_table(design, coarse(true), options, &report));
  CHECK_FALSE(table.has_ring());
  CHECK(report.solutions == 32);
  sim::space::MagnetField field(design, coarse(true));
  const double psi = table.table().psi[1], gap = table.table().gap[1];
  field.set_gap(gap);
  const auto p = field.at_flux(psi, 0);
  CHECK(table.at({psi, 0, gap}).pull == Approx(p.response.pull).epsilon(1e-6));
  CHECK(table.at({psi, 0, gap}).current == Approx(p.response.current).epsilon(1e-6));
}

TEST_CASE("The plane table with ends is the table of three dimensions to its own error", "[.slow]") {
  sim::MagnetDesign reference, c_core;
  c_core.shape.legs = 2;
  c_core.shape.closed_leg = 1;
  c_core.shape.ring_share = 0;
  for (const auto& design : {reference, c_core}) {
    sim::TableOptions options;
    options.accuracy = 0.01;
    options.ring = false;
    sim::EndTableOptions ends;
    ends.sizes = coarse(true);
    ends.psi_nodes = 10;
    ends.gap_nodes = 5;
    sim::Team team(1);
    const sim::TablePotential with(sim::build_table_with_ends(design, options, ends, team));
    const sim::TablePotential without(sim::build_table(design, {.accuracy = 0.01, .ring = false}, team));
    CHECK_FALSE(with.has_ring());
    CHECK(with.table().design_hash == sim::end_table_hash(design, options, ends));
    CHECK(with.table().design_hash != sim::table_hash(design, options));
    sim::space::MagnetField field(design, coarse(true));
    for (const double gap : {4e-3, 1.3e-3, 0.2e-3}) {
      field.set_gap(gap);
      const double psi = 0.3;
      const auto p = field.at_flux(psi, 0, {}, true).response;
      const auto a = with.at({psi, 0, gap}), b = without.at({psi, 0, gap});
      CAPTURE(design.shape.legs, gap, p.pull, a.pull, b.pull);
      std::printf("%d legs, gap %.1f mm: table with ends %+.2f %% in the current, %+.2f %% in the pull;",
                  design.shape.legs, gap * 1e3, 100 * (a.current / p.current - 1),
                  100 * (a.pull / p.pull - 1));
      std::printf(" plane %+.2f %%, %+.2f %%\n", 100 * (b.current / p.current - 1),
                  100 * (b.pull / p.pull - 1));
      // cells of 1 mm beside the pole edges put three dimensions 2 % off at the smallest of these gaps
      CHECK(a.current == Approx(p.current).epsilon(0.03));
      CHECK(a.pull == Approx(p.pull).epsilon(0.03));
      CHECK(std::fabs(a.current - p.current) < 0.2 * std::fabs(b.current - p.current));
      CHECK(std::fabs(a.pull - p.pull) < 0.2 * std::fabs(b.pull - p.pull));
    }
  }
}
