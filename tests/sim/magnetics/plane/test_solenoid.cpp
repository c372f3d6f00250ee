#include <catch2/catch.hpp>
#include <cmath>

#include "sim/magnetics/plane/solenoid_field.h"

using namespace powbench::sim;

namespace {

FieldOptions options(double accuracy) {
  FieldOptions o;
  o.sizes = sizes_for(accuracy);
  o.newton.tolerance = 1e-10;
  return o;
}

double relative(double a, double b) {
  return std::fabs(a / b - 1);
}

}  // namespace

TEST_CASE("a solenoid beside FreeFem++ on its own mesh: flux and pull to half a percent") {
  // quadratic elements for r A, 22 000 to 25 000 unknowns; `bench_fields_actuator` runs it
  struct Row {
    double gap, current, flux, pull;
  };
  SolenoidField field({}, options(2e-3));
  CHECK(field.unknowns() < 10000);
  for (const Row& row : {Row{0.5e-3, 1, 0.336106, 160.071}, Row{2e-3, 2, 0.317147, 96.4544},
                         Row{5e-3, 2, 0.181043, 24.8709}, Row{10e-3, 1, 0.0543018, 2.13951}}) {
    INFO("gap " << row.gap * 1e3 << " mm, " << row.current << " A");
    field.set_gap(row.gap);
    const auto p = field.at_current(row.current);
    CHECK(p.newton.converged);
    CHECK(relative(field.flux(p), row.flux) < 5e-3);
    CHECK(relative(p.response.pull, row.pull) < 5e-3);
    CHECK(relative(p.stress_pull, row.pull) < 5e-3);
  }
}

TEST_CASE("the pull on a plunger is the slope of the energy, to the error of the mesh") {
  SolenoidField field({}, options(2e-3));
  for (const double gap : {0.4e-3, 2e-3, 7e-3})
    for (const double psi : {0.05, 0.3}) {
      INFO("gap " << gap * 1e3 << " mm, " << psi << " Wb");
      const auto at = [&](double g) {
        field.set_gap(g);
        auto p = field.at_flux(psi);
        REQUIRE(p.newton.converged);
        return p.response;
      };
      const double step = 0.01 * gap;
      const auto low = at(gap - step), high = at(gap + step), r = at(gap);
      CHECK(relative((high.energy - low.energy) / (2 * step), r.pull) < 4e-3);
      CHECK(relative((high.current - low.current) / (2 * step), r.current_gap) < 6e-3);
      field.set_gap(gap);
      const double more = field.at_flux(psi * 1.001).response.pull,
                   less = field.at_flux(psi * 0.999).response.pull;
      CHECK((more - less) / (0.002 * psi) == Approx(r.current_gap).epsilon(1e-4));
    }
}

TEST_CASE("the pull does not shake with the position of the plunger") {
  // parabola through five neighbours: what is left is noise
  SolenoidField field({}, options(5e-3));
  std::vector<double> pull;
  for (int k = 0; k < 9; ++k) {
    field.set_gap(3e-3 + 0.02e-3 * k);
    pull.push_back(field.at_flux(0.2).response.pull);
  }
  for (std::size_t k = 1; k + 2 < pull.size(); ++k) {
    const double third = pull[k + 2] - 3 * pull[k + 1] + 3 * pull[k] - pull[k - 1];
    CHECK(std::fabs(third) < 1e-5 * pull[k]);
  }
}

TEST_CASE("a solenoid pulls in by its table as with the field in the loop", "[.slow]") {
  const SolenoidDesign design;
  TransientSetup s;
  s.voltage = [](double) { return 24.0; };
  s.resistance = 9;
  s.mass = 0.07;
  s.counter_force = [](double gap) { return 5 + 300 * (10e-3 - gap); };
  s.start_gap = 10e-3;
  s.step = 200e-6;
  s.duration = 26e-3;
  TableOptions o;
  o.accuracy = 0.0125;  // mesh of 0.5 %
  o.psi_nodes = o.gap_nodes = 20;
  Team team(2);
  TableReport report;
  const TablePotential table(build_table(design, o, team, &report));
  CHECK(report.stress_error < 1e-3);
  const auto field = run_transient(design, options(5e-3), s), quick = run_transient(table, s);
  REQUIRE(field.closed_at > 15e-3);
  CHECK(std::fabs(field.energy.residual()) < 1e-3);
  CHECK(std::fabs(quick.energy.residual()) < 1e-3);
  CHECK(relative(quick.closed_at, field.closed_at) < 5e-3);
}

TEST_CASE("solenoids that cannot be are told with key, value and range") {
  using Catch::Matchers::Contains;
  const auto refuse = [](auto change, const char* text) {
    SolenoidDesign d;
    change(d);
    CHECK_THROWS_WITH(SolenoidField(d, options(0.02)), Contains(text) && Contains("allowed"));
  };
  refuse([](SolenoidDesign& d) { d.shape.plunger_radius = 8; }, "plunger_radius_mm = 8000");
  refuse([](SolenoidDesign& d) { d.shape.bore_radius = 8e-3; }, "bore_radius_mm = 8");
  refuse([](SolenoidDesign& d) { d.shape.coil_outer = 17e-3; }, "case_inner_mm = 16.5");
  refuse([](SolenoidDesign& d) { d.shape.plunger_length = 29e-3; }, "plunger_length_mm = 29");
  refuse([](SolenoidDesign& d) { d.largest_gap = 23e-3; }, "gap_mm");
  refuse([](SolenoidDesign& d) { d.residual_gap = 0; }, "residual_gap_um = 0");
  refuse([](SolenoidDesign& d) { d.turns = 0; }, "turns = 0");
  SolenoidField field({}, options(0.02));
  CHECK_THROWS_WITH(field.set_gap(-1e-6), Contains("gap_mm"));
  CHECK_THROWS_WITH(field.set_gap(11e-3), Contains("gap_mm"));
  TransientSetup s;
  s.voltage = [](double) { return 24.0; };
  s.sheet_resistance = 1;
  CHECK_THROWS_WITH(run_transient(SolenoidDesign{}, options(0.02), s), Contains("sheet_resistance"));
  s.sheet_resistance = 0;
  s.iron_conductivity = -1;
  CHECK_THROWS_WITH(run_transient(SolenoidDesign{}, options(0.02), s), Contains("iron_conductivity"));
}

TEST_CASE("vertices move only where no triangle turns over") {
  SolenoidField field({}, options(0.02));
  FieldProblem problem(field.problem());
  auto x = problem.space().mesh.x, y = problem.space().mesh.y;
  std::swap(y.front(), y.back());
  CHECK_THROWS_AS(problem.move_vertices(x, y), std::invalid_argument);
  x.pop_back();
  CHECK_THROWS_AS(problem.move_vertices(x, y), std::invalid_argument);
}
