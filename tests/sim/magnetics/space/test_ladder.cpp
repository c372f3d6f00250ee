#include <catch2/catch.hpp>
#include <cmath>

#include "bench/space/team13.h"
#include "bench/space/team20.h"
#include "sim/magnetics/space/force.h"
#include "sim/magnetics/space/ladder.h"

namespace sim = powbench::sim;
namespace bench = powbench::bench;

TEST_CASE(
    "Without ends the core is the plane problem: potentials from above, the vector potential from below") {
  const sim::MagnetDesign design;
  sim::space::CoreMeshSizes sizes;
  sizes.ends = false;
  sim::space::MagnetField field(design, sizes);
  sim::MagnetField plane(design, {});
  for (const double gap : {0.5e-3, 0.0}) {
    field.set_gap(gap);
    plane.set_gap(gap);
    const auto a = field.at_current(0.3);
    const auto b = plane.at_current(0.3, 0);
    CAPTURE(gap);
    CHECK(a.psi == Approx(plane.fluxes(b).first).epsilon(5e-3));
    CHECK(a.ring == Approx(plane.fluxes(b).second).epsilon(5e-3));
    CHECK(a.response.pull == Approx(b.response.pull).epsilon(8e-3));
    CHECK(a.psi > plane.fluxes(b).first);
  }
}

TEST_CASE("The ends add leakage to the plane problem, and pull where the gap is wide") {
  const auto ends =
      sim::space::end_corrections({}, sim::space::CoreMeshSizes{}.scaled(4), 0.05, {4e-3, 0.5e-3});
  REQUIRE(ends.size() == 2);
  for (const auto& e : ends) {
    CHECK(e.leakage > 0.1);  // H; 2000 turns
    CHECK(e.leakage < 0.4);
    CHECK(e.pull > 1.0);
    CHECK(e.pull < 1.2);
  }
  CHECK(ends[0].pull > ends[1].pull);
  CHECK_THROWS_AS(sim::space::end_corrections({}, {}, 0, {1e-3}), std::invalid_argument);
}

TEST_CASE("The pull on the pole of TEAM 20 is the measured one within 3 per cent", "[.slow]") {
  const auto t = bench::team20(2);
  const sim::space::Coenergy w(t.problem);
  CHECK(w.unknowns() <= 100000);
  sim::space::Newton newton(w);
  for (const auto& row : bench::team20_measured) {
    const auto s = newton.solve({{false, row.ampere_turns}});
    CAPTURE(row.ampere_turns, s.iterations);
    CHECK(s.converged);
    CHECK(s.iterations <= 25);
    CHECK(-sim::space::stress_force(w, s.state, t.virtual_work)[2] == Approx(row.pull).epsilon(0.03));
  }
}

TEST_CASE("Newton arrives from zero in the thin plates of TEAM 13", "[.slow]") {
  const auto p = bench::team13(2.5);
  const sim::space::Coenergy w(p);
  sim::space::Newton newton(w);
  for (const double current : {1000.0, 3000.0}) {
    const auto s = newton.solve({{false, current}});
    CHECK(s.converged);
    CHECK(s.iterations <= 25);
  }
}

TEST_CASE("A table in three dimensions gives back its states", "[.slow]") {
  const sim::MagnetDesign design;
  const auto sizes = sim::space::CoreMeshSizes{}.scaled(4);
  sim::TableOptions options;
  options.psi_nodes = options.gap_nodes = 8;
  options.ring = false;
  sim::TableReport report;
  const sim::TablePotential table(sim::space::build_table(design, sizes, options, &report));
  CHECK(report.solutions == 64);
  CHECK(report.most_iterations <= 25);
  CHECK(table.least_stiffness() > 0);
  sim::space::MagnetField field(design, sizes);
  field.set_gap(1.3e-3);
  for (const double psi : {0.2, 0.6}) {
    const auto p = field.at_flux(psi, 0, {}, true);
    const auto r = table.at({psi, 0, 1.3e-3});
    CHECK(r.current == Approx(p.response.current).epsilon(0.01));
    CHECK(r.pull == Approx(p.response.pull).epsilon(0.01));
  }
}
