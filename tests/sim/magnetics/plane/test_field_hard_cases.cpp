#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/fields/contactor.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"

using namespace powbench::sim;

namespace {

MagnetDesign contactor(double residual_gap) {
  auto d = powbench::bench::reference_contactor();
  d.turns = 1000;
  d.residual_gap = residual_gap;
  return d;
}

TableOptions rough() {
  TableOptions o;
  o.accuracy = 0.05;
  o.psi_nodes = 16;
  o.gap_nodes = 12;
  return o;
}

}  // namespace

TEST_CASE("a residual gap of 10 um: the closed magnet is a node of the table, and pulls hardest") {
  const auto design = contactor(10e-6);
  Team team(2);
  const TablePotential table(build_table(design, rough(), team));
  MagnetField field(design, plan_table(design, rough()).field);
  CHECK(table.table().gap.front() == 0);
  field.set_gap(0);
  double worst = 0;
  for (const std::size_t k : {1u, 5u, 10u}) {
    const double psi = table.table().psi[k];
    const auto exact = field.at_flux(psi, 0).response;
    const auto r = table.at({psi, 0, 0});
    CHECK(r.pull == Approx(exact.pull).epsilon(1e-5));
    CHECK(r.current == Approx(exact.current).epsilon(1e-5));
    worst = std::max({worst, std::fabs(r.pull / exact.pull - 1), std::fabs(r.current / exact.current - 1)});
    // the same current holds harder where the gap is gone
    field.set_gap(30e-6);
    CHECK(field.at_current(exact.current, 0).response.pull < exact.pull);
    field.set_gap(0);
  }
  std::printf("residual gap 10 um, gap 0: table %.0e off the field\n", worst);
}

TEST_CASE(
    "beyond its last flux the table goes on with the inductance of air: the later it ends, the better") {
  const auto design = contactor(20e-6);
  Team team(2);
  const auto worst = [&](double largest_field) {
    auto o = rough();
    o.largest_field = largest_field;
    const TablePotential table(build_table(design, o, team));
    MagnetField field(design, plan_table(design, o).field);
    const double last = table.table().psi.back();
    double error = 0;
    for (const double gap : {0.0, 1e-3})
      for (const double factor : {1.1, 1.5, 2.0}) {
        field.set_gap(gap);
        const auto exact = field.at_flux(factor * last, 0);
        REQUIRE(exact.newton.converged);
        const double current = table.at({factor * last, 0, gap}).current;
        error = std::fmax(error, std::fabs(current / exact.response.current - 1));
      }
    return error;
  };
  // at 2.4 T in the centre leg some of the steel still carries more than air would
  const double early = worst(2.4), late = worst(4);
  CAPTURE(early, late);
  std::printf("beyond the table: current up to %.0f %% off behind 2.4 T, %.0f %% behind 4 T\n", 100 * early,
              100 * late);
  CHECK(early < 0.04);
  CHECK(late < 0.5 * early);
}

TEST_CASE(
    "switch-on at 0 deg without resistance: the flux doubles, far beyond the table, and no energy is lost") {
  const auto design = contactor(20e-6);
  Team team(2);
  const TablePotential table(build_table(design, rough(), team));
  TransientSetup s;
  constexpr double omega = 314.159265358979, volts = 220;
  s.voltage = [](double t) { return volts * std::sin(omega * t); };
  s.resistance = 1e-3;
  s.moves = false;
  s.start_gap = 0;
  s.step = 2e-6;
  s.duration = 20e-3;
  const auto r = run_transient(table, s);
  double psi = 0, current = 0;
  for (const auto& sample : r.samples) {
    psi = std::max(psi, sample.psi);
    current = std::max(current, sample.current);
  }
  std::printf(
      "switch-on at 0 deg: flux %.4f times 2 V / w, %.2f times the table's last, energy missing %.0e\n",
      psi / (2 * volts / omega), psi / table.table().psi.back(),
      std::fabs(r.energy.supplied - r.energy.coil_loss - r.energy.stored) / table.at({psi, 0, 0}).energy);
  CHECK(psi == Approx(2 * volts / omega).epsilon(5e-3));
  CHECK(psi > 1.5 * table.table().psi.back());
  CHECK(current == Approx(table.at({psi, 0, 0}).current).epsilon(1e-3));
  // u i dt over the period is all but zero: judged by what went in and out
  CHECK(std::fabs(r.energy.supplied - r.energy.coil_loss - r.energy.stored) <
        1e-3 * table.at({psi, 0, 0}).energy);
  // current through zero on the way back
  CHECK(std::fabs(r.samples.back().psi) < 1e-3 * psi);
}

TEST_CASE("steel above the last row of its curve is told, by state and by table") {
  auto design = contactor(20e-6);
  design.steel = Steel::table("short", {{0.5, 80}, {1.0, 150}, {1.4, 700}, {1.6, 3000}});
  MagnetField field(design, plan_table(design, rough()).field);
  field.set_gap(1e-3);
  const auto weak = field.at_current(0.05, 0), strong = field.at_current(5, 0);
  CHECK(weak.largest_field < 1.6);
  CHECK_FALSE(weak.beyond_data);
  CHECK(strong.largest_field > 1.6);
  CHECK(strong.beyond_data);
  Team team(2);
  TableReport report;
  const auto table = build_table(design, rough(), team, &report);
  CHECK(report.beyond_data > 0);
  CHECK(report.beyond_data < report.solutions);
  const auto e = extrapolated_share(table);
  CHECK(table.data_end == Approx(1.6));
  CHECK(e.share == static_cast<double>(report.beyond_data) / report.solutions);
  CHECK(e.largest_field > 1.6);
  // the smallest flux of all that are beyond: the node before is not
  for (std::size_t n = 0; n < table.steel_field.size(); ++n)
    if (table.psi[n % table.psi.size()] < e.from_psi) CHECK(table.steel_field[n] <= table.data_end);
  CHECK(e.from_psi > 0);
  CHECK(field.problem().share_beyond_data(weak.a.data()) == 0);
  std::printf("table up to 2.4 T on a curve to 1.6 T: %.0f %% of its states have steel beyond\n",
              100 * e.share);
  const double share = field.problem().share_beyond_data(strong.a.data());
  CHECK(share > 0);
  CHECK(share < 1);
}
