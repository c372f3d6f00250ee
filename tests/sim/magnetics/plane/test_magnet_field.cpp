#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/fields/contactor.h"

using namespace powbench::sim;
using powbench::bench::reference_contactor;
using powbench::bench::reference_rows;

namespace {

double relative(double a, double b) {
  return std::fabs(a / b - 1);
}

/// Quick mesh for tests of identities.
FieldOptions coarse() {
  FieldOptions o;
  o.sizes = sizes_for(0.01);
  return o;
}

}  // namespace

TEST_CASE(
    "fifteen states of the E-E contactor: flux to 0.1 %, pull to 0.2 % with fewer than 10 000 unknowns") {
  const auto design = reference_contactor();
  MagnetField field(design, {});
  CHECK(field.unknowns() < 10000);
  for (const auto& row : reference_rows) {
    INFO("gap " << row.gap * 1e3 << " mm, " << row.ampere_turns << " A");
    field.set_gap(row.gap - design.residual_gap);
    const auto p = field.at_current(row.ampere_turns, 0);
    CHECK(p.newton.converged);
    CHECK(p.newton.iterations <= 15);
    CHECK(relative(field.fluxes(p).first, row.flux) < 1e-3);
    CHECK(relative(p.response.pull, row.pull) < 2e-3);
    CHECK(relative(p.stress_pull, p.response.pull) < 2e-3);
  }
}

TEST_CASE("given flux and given current are the same field") {
  FieldOptions options = coarse();
  options.newton.tolerance = 1e-13;  // at 1e-9 it depends on rounding whether 1e-7 is one iteration away
  MagnetField field(reference_contactor(), options);
  for (const double gap : {0.0, 0.3e-3, 4e-3}) {
    field.set_gap(gap);
    const auto p = field.at_current(1500, 0);
    const auto q = field.at_flux(field.fluxes(p).first, 0);
    CHECK(q.newton.converged);
    // apart by rounding: 4e-11 at 1 um, 5e-13 at the other gaps
    const double rounding = gap == 0 ? 1e-8 : 1e-10;
    CHECK(relative(q.response.current, 1500) < rounding);
    CHECK(relative(q.response.pull, p.response.pull) < rounding);
    std::printf("given flux and given current at %.1f mm: current %.1e, pull %.1e apart\n", gap * 1e3,
                relative(q.response.current, 1500), relative(q.response.pull, p.response.pull));
  }
}

TEST_CASE("current, pull and their derivatives are those of the energy") {
  MagnetDesign design;  // with shading ring
  MagnetField field(design, coarse());
  constexpr double psi = 0.7, ring = 6e-5, gap = 0.4e-3;
  const auto at = [&](double p, double r, double g) {
    field.set_gap(g);
    auto point = field.at_flux(p, r);
    REQUIRE(point.newton.converged);
    return field.at_flux(p, r, std::move(point.a)).response;
  };
  const auto r = at(psi, ring, gap);
  const auto check = [](double derivative, double high, double low, double step, double tolerance) {
    CHECK(derivative == Approx((high - low) / (2 * step)).epsilon(tolerance));
  };
  constexpr double dp = 1e-3, dr = 2e-7, dg = 1e-6;
  const auto p1 = at(psi + dp, ring, gap), p0 = at(psi - dp, ring, gap);
  const auto r1 = at(psi, ring + dr, gap), r0 = at(psi, ring - dr, gap);
  const auto g1 = at(psi, ring, gap + dg), g0 = at(psi, ring, gap - dg);
  check(r.current, p1.energy, p0.energy, dp, 1e-4);
  check(r.ring_current, r1.energy, r0.energy, dr, 1e-4);
  check(r.pull, g1.energy, g0.energy, dg, 1e-5);
  check(r.current_psi, p1.current, p0.current, dp, 1e-3);
  check(r.current_ring, r1.current, r0.current, dr, 1e-3);
  check(r.current_ring, p1.ring_current, p0.ring_current, dp, 1e-3);
  check(r.ring_ring, r1.ring_current, r0.ring_current, dr, 1e-3);
  check(r.current_gap, g1.current, g0.current, dg, 1e-4);
  check(r.current_gap, p1.pull, p0.pull, dp, 1e-3);
  check(r.ring_gap, g1.ring_current, g0.ring_current, dg, 1e-4);
  check(r.pull_gap, g1.pull, g0.pull, dg, 1e-3);
}

TEST_CASE("virtual work is Maxwell's stress weighted with the displacement of the mesh, to round-off") {
  MagnetField field(reference_contactor(), coarse());
  const auto& mesh = field.problem().space().mesh;
  std::vector<double> displacement;
  for (const double y : mesh.y) displacement.push_back(std::fmin(1, std::fmax(0, y / strip_height)));
  for (const double gap : {0.0, 0.1e-3, 5e-3}) {
    field.set_gap(gap);
    const auto p = field.at_current(2000, 0);
    // in a strip of 1 um, differences of A across it keep 9 digits
    const double round_off = gap > 0 ? 1e-10 : 1e-6;
    CHECK(relative(-field.problem().stress_force(p.a.data(), displacement), p.response.pull) < round_off);
  }
}

TEST_CASE("25 cold starts with the steel of TEAM 13 converge in at most 25 iterations") {
  auto design = reference_contactor();
  design.steel = builtin_steel("team13");
  MagnetField field(design, {});
  int most = 0;
  for (const double gap : {0.02e-3, 0.1e-3, 0.5e-3, 2e-3, 5e-3})
    for (const double current : {30.0, 300.0, 1000.0, 3000.0, 10000.0}) {
      INFO("gap " << gap * 1e3 << " mm, " << current << " A");
      field.set_gap(gap);
      const auto p = field.at_current(current, 0);
      CHECK(p.newton.converged);
      CHECK(p.newton.iterations <= 25);
      most = std::max(most, p.newton.iterations);
    }
  std::printf("25 cold starts, steel of TEAM 13: at most %d iterations\n", most);
}

TEST_CASE("the gap may close to a tenth of a micrometre, saturated or not") {
  auto design = reference_contactor();
  design.residual_gap = 0.1e-6;
  MagnetField field(design, {});
  double before = 0, stress = 0;
  int most = 0;
  for (const double current : {30.0, 3000.0}) {
    before = 0;
    for (const double gap : {100e-6, 10e-6, 1e-6, 0.0}) {
      field.set_gap(gap);
      const auto p = field.at_current(current, 0);
      INFO("gap " << gap * 1e6 << " um, " << current << " A");
      CHECK(p.newton.converged);
      CHECK(p.newton.iterations <= 20);
      CHECK(p.response.pull > before);
      CHECK(relative(p.stress_pull, p.response.pull) < 5e-3);
      before = p.response.pull;
      stress = std::max(stress, relative(p.stress_pull, p.response.pull));
      most = std::max(most, p.newton.iterations);
    }
  }
  std::printf(
      "gap 100 um .. 0.1 um, 30 and 3000 A turns: at most %d iterations, stress %.2f %% off virtual work\n",
      most, 100 * stress);
}

TEST_CASE("a bad start does no harm") {
  MagnetField field(reference_contactor(), coarse());
  field.set_gap(0.5e-3);
  const auto right = field.at_current(1000, 0);
  double worst = 0;
  for (const double factor : {-3.0, 10.0, 100.0}) {
    auto start = right.a;
    for (std::size_t k = 0; k < start.size(); k += 3) start[k] *= factor;
    start.back() = 0;
    const auto p = field.at_current(1000, 0, start);
    CHECK(p.newton.converged);
    CHECK(relative(p.response.pull, right.response.pull) < 1e-6);
    worst = std::max(worst, relative(p.response.pull, right.response.pull));
  }
  std::printf("starts 3, 10 and 100 times off in every third unknown: pull differs by %.0e\n", worst);
}

TEST_CASE("impossible shapes are told with key, value and range") {
  using Catch::Matchers::Contains;
  const auto message = [](auto change) {
    MagnetShape s;
    change(s);
    const auto errors = shape_errors(s);
    return errors.empty() ? std::string("none") : errors.front().key + " = " + errors.front().value;
  };
  CHECK(message([](MagnetShape&) {}) == "none");
  CHECK(message([](MagnetShape& s) { s.centre_width = 15.2; }) == "shape.centre_width_mm = 15200");
  CHECK(message([](MagnetShape& s) { s.coil_width = 10e-3; }) == "shape.coil_width_mm = 10");
  CHECK(message([](MagnetShape& s) { s.coil_height = 17e-3; }) == "shape.coil_height_mm = 17");
  CHECK(message([](MagnetShape& s) { s.centre_gap = -1e-3; }) == "shape.centre_gap_mm = -1");
  CHECK(message([](MagnetShape& s) { s.ring_slot = 8e-3; }) == "shape.ring_slot_mm = 8");
  CHECK(message([](MagnetShape& s) { s.ring_share = 1.2; }) == "shape.ring_share = 1.2");
  CHECK(message([](MagnetShape& s) { s.stack_factor = 0; }) == "shape.stack_factor = 0");
  MagnetField field(reference_contactor(), coarse());
  CHECK_THROWS_WITH(field.set_gap(-1e-6), Contains("gap_mm"));
}
