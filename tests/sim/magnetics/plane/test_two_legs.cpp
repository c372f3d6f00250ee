// U- and C-cores: the plane field, its derivatives, the circuit beside it.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/fields/circuit.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/magnetics/space/magnet_field.h"

using namespace powbench::sim;
using powbench::pi;

namespace {

constexpr double vacuum = 4e-7 * pi;

enum class Core { u, c };

MagnetDesign two_legs(Core core) {
  MagnetDesign d;
  d.shape.legs = 2;
  d.shape.closed_leg = core == Core::c;
  d.shape.ring_share = 0;
  d.shape.outer_width = 12e-3;
  d.shape.yoke = 12e-3;
  return d;
}

FieldOptions mesh_for(double accuracy) {
  FieldOptions o;
  o.sizes = sizes_for(accuracy);
  o.newton.tolerance = 1e-12;
  return o;
}

const char* name_of(Core core) {
  return core == Core::u ? "U" : "C";
}

/// At |B| in the centre leg, if none leaked.
double flux_for(const MagnetDesign& d, double b) {
  return d.turns * b * d.shape.centre_width * d.shape.stack * d.shape.stack_factor;
}

}  // namespace

TEST_CASE("U- and C-core: current and pull of a small gap below steel without reluctance") {
  for (const Core core : {Core::u, Core::c}) {
    auto d = two_legs(core);
    d.steel = Steel::linear(1e7);
    d.shape.stack_factor = 1;
    d.shape.outer_width = d.shape.centre_width;
    d.residual_gap = 4e-6;
    MagnetField field(d, mesh_for(0.005));
    field.set_gap(0);
    const double b = 0.5, area = d.shape.centre_width * d.shape.stack, gaps = core == Core::u ? 2 : 1;
    const auto r = field.at_flux(flux_for(d, b), 0).response;
    const double current = gaps * b * d.residual_gap / vacuum / d.turns,
                 pull = gaps * b * b * area / (2 * vacuum);
    std::printf("%s-core, gap 4 um: current %.2f %%, pull %.2f %% off the closed solution\n", name_of(core),
                100 * (r.current / current - 1), 100 * (r.pull / pull - 1));
    // the edges of the gap add 4 um (0.52 + 2 ln(1 + 2 flank / gap) / pi) / 15.2 mm = 0.16 % to its permeance
    CHECK(r.current == Approx(current).epsilon(0.003));
    CHECK(r.pull == Approx(pull).epsilon(0.005));
  }
}

TEST_CASE("U- and C-core: current, pull and their derivatives are those of the energy, the ring's too") {
  for (const int kind : {0, 1, 2}) {  // U with ring, U, C
    auto d = two_legs(kind == 2 ? Core::c : Core::u);
    if (kind == 0) d.shape.ring_share = 0.6;
    MagnetField field(d, mesh_for(0.02));
    double worst_pull = 0, worst_mixed = 0;
    for (const double b : {0.8, 1.7})
      for (const double gap : {0.05e-3, 1.5e-3}) {
        const double psi = flux_for(d, b), ring = kind == 0 ? 0.4 * psi / d.turns : 0;
        const auto at = [&](double p, double r, double g) {
          field.set_gap(g);
          auto point = field.at_flux(p, r);
          REQUIRE(point.newton.converged);
          return field.at_flux(p, r, std::move(point.a)).response;
        };
        const auto r = at(psi, ring, gap);
        const double dp = 1e-4 * psi, dr = 1e-4 * psi / d.turns, dg = 1e-3 * (gap + d.residual_gap);
        const auto p1 = at(psi + dp, ring, gap), p0 = at(psi - dp, ring, gap);
        const auto g1 = at(psi, ring, gap + dg), g0 = at(psi, ring, gap - dg);
        CAPTURE(kind, b, gap);
        CHECK(r.current == Approx((p1.energy - p0.energy) / (2 * dp)).epsilon(1e-5));
        CHECK(r.pull == Approx((g1.energy - g0.energy) / (2 * dg)).epsilon(2e-5));
        CHECK(r.current_psi == Approx((p1.current - p0.current) / (2 * dp)).epsilon(1e-4));
        CHECK(r.current_gap == Approx((g1.current - g0.current) / (2 * dg)).epsilon(1e-4));
        CHECK(r.current_gap == Approx((p1.pull - p0.pull) / (2 * dp)).epsilon(1e-4));
        CHECK(r.pull_gap == Approx((g1.pull - g0.pull) / (2 * dg)).epsilon(1e-3).margin(1));
        worst_pull = std::fmax(worst_pull, std::fabs(r.pull / ((g1.energy - g0.energy) / (2 * dg)) - 1));
        worst_mixed =
            std::fmax(worst_mixed,
                      std::fabs((g1.current - g0.current) / (2 * dg) / ((p1.pull - p0.pull) / (2 * dp)) - 1));
        if (kind != 0) continue;
        const auto r1 = at(psi, ring + dr, gap), r0 = at(psi, ring - dr, gap);
        CHECK(r.ring_current == Approx((r1.energy - r0.energy) / (2 * dr)).epsilon(1e-4));
        CHECK(r.ring_gap == Approx((g1.ring_current - g0.ring_current) / (2 * dg)).epsilon(1e-3).margin(1));
        CHECK(r.current_ring == Approx((p1.ring_current - p0.ring_current) / (2 * dp)).epsilon(1e-3));
      }
    std::printf("%s: pull against differences of W %.1e, dF/dpsi against di/dgap %.1e\n",
                kind == 0   ? "U-core with ring"
                : kind == 1 ? "U-core"
                            : "C-core",
                worst_pull, worst_mixed);
  }
}

TEST_CASE(
    "U- and C-core: virtual work is the stress weighted with the displacement of the mesh, through a closed "
    "leg too") {
  for (const Core core : {Core::u, Core::c}) {
    const auto d = two_legs(core);
    MagnetField field(d, mesh_for(0.01));
    std::vector<double> displacement;
    for (const double y : field.problem().space().mesh.y)
      displacement.push_back(std::fmin(1, std::fmax(0, y / strip_height)));
    for (const double gap : {0.1e-3, 3e-3}) {
      field.set_gap(gap);
      const auto p = field.at_flux(flux_for(d, 1.7), 0);
      CHECK(-field.problem().stress_force(p.a.data(), displacement) == Approx(p.response.pull).epsilon(1e-9));
      CHECK(p.stress_pull == Approx(p.response.pull).epsilon(2e-3));
    }
  }
}

TEST_CASE("U- and C-core beside FreeFem++ on its own mesh: flux to 0.1 %, pull to 0.2 %") {
  // quadratic elements, 46 000 to 60 000 unknowns; `bench_fields_cores` runs it
  struct Row {
    Core core;
    double gap, current, flux, pull;
  };
  double worst_flux = 0, worst_pull = 0;
  for (const Row& row :
       {Row{Core::u, 0.1e-3, 0.2, 0.712168, 377.1202}, Row{Core::u, 0.5e-3, 1, 0.893457, 465.4794},
        Row{Core::u, 2e-3, 3, 1.042778, 373.9669}, Row{Core::u, 5e-3, 3, 0.816971, 110.2448},
        Row{Core::c, 0.1e-3, 0.2, 0.764465, 198.8644}, Row{Core::c, 0.5e-3, 1, 0.931332, 255.3207},
        Row{Core::c, 2e-3, 3, 1.093431, 255.8996}, Row{Core::c, 5e-3, 3, 0.982327, 134.4430}}) {
    auto d = two_legs(row.core);
    d.shape.stack_factor = 1;
    d.steel = builtin_steel("reference");
    d.residual_gap = 20e-6;
    MagnetField field(d, mesh_for(0.002));
    CHECK(field.unknowns() < 10000);
    field.set_gap(row.gap);
    const auto p = field.at_current(row.current, 0);
    CAPTURE(name_of(row.core), row.gap, row.current);
    CHECK(field.fluxes(p).first == Approx(row.flux).epsilon(1e-3));
    CHECK(p.response.pull == Approx(row.pull).epsilon(2e-3));
    worst_flux = std::fmax(worst_flux, std::fabs(field.fluxes(p).first / row.flux - 1));
    worst_pull = std::fmax(worst_pull, std::fabs(p.response.pull / row.pull - 1));
  }
  std::printf("U- and C-core beside FreeFem++: psi %.3f %%, F %.3f %% at worst\n", 100 * worst_flux,
              100 * worst_pull);
}

// the field at a right-angled corner of steel goes with r^(-1/3), so energies are right to h^(4/3) at least
TEST_CASE("U- and C-core: flux and pull converge with an order above 4/3", "[.slow]") {
  for (const Core core : {Core::u, Core::c}) {
    const auto d = two_legs(core);
    std::vector<double> flux, pull;
    for (const double factor : {2.0, 4.0, 8.0}) {
      FieldOptions o = mesh_for(0.001);
      o.sizes = {0.8e-3 / factor, 4e-3 / factor, 4e-3 / factor, 40e-3 / factor, 1 + 1 / factor};
      MagnetField field(d, o);
      field.set_gap(0.5e-3);
      const auto p = field.at_current(0.3, 0);
      flux.push_back(field.fluxes(p).first);
      pull.push_back(p.response.pull);
    }
    const auto order = [](const std::vector<double>& v) { return std::log2((v[1] - v[0]) / (v[2] - v[1])); };
    const double last_flux = flux[2] / flux[1] - 1, last_pull = pull[2] / pull[1] - 1;
    std::printf("%s-core: last halving of all cells: psi %+.3f %%, F %+.3f %%; order of psi %.2f",
                name_of(core), 100 * last_flux, 100 * last_pull, order(flux));
    if (core == Core::u) std::printf(", of F %.2f", order(pull));
    std::printf("\n");
    CHECK(order(flux) > 4. / 3);
    // the C-core's pull is not monotone in the cell size: its small errors nearly cancel
    if (core == Core::u) CHECK(order(pull) > 4. / 3);
    CHECK(std::fabs(last_flux) < 1e-3);
    CHECK(std::fabs(last_pull) < 1e-3);
  }
}

TEST_CASE("U- and C-core: circuit beside the field") {
  for (const Core core : {Core::u, Core::c}) {
    const auto d = two_legs(core);
    MagnetField field(d, mesh_for(0.01));
    const CircuitPotential circuit(d.shape, d.steel, d.turns, d.residual_gap, 0, {false});
    for (const auto& [low, high] : {std::pair{0.0, 0.5e-3}, {2e-3, 2e-3}, {5e-3, 5e-3}})
      for (const bool saturated : {false, true}) {
        double current = 0, pull = 0;
        for (const double gap : {low, high})
          for (const double b : saturated ? std::array{1.5, 1.8} : std::array{0.3, 1.0}) {
            field.set_gap(gap);
            const auto f = field.at_flux(flux_for(d, b), 0).response;
            const auto c = circuit.at({flux_for(d, b), 0, gap});
            current = std::fmax(current, std::fabs(c.current / f.current - 1));
            pull = std::fmax(pull, std::fabs(c.pull / f.pull - 1));
          }
        std::printf(
            "%s-core, circuit, gap %.1f .. %.1f mm, %s: current %.0f %%, pull %.0f %% off the field\n",
            name_of(core), low * 1e3, high * 1e3, saturated ? "1.5 .. 1.8 T" : "0.3 .. 1 T", 100 * current,
            100 * pull);
        CHECK(current < (saturated ? 0.65 : 0.15));
        CHECK(pull < (high > 2e-3 ? 0.45 : 0.25));
      }
  }
}

TEST_CASE("circuit of a C-core: every derivative is that of the energy, the leg that gets longer counted") {
  const auto d = two_legs(Core::c);
  const CircuitPotential circuit(d.shape, d.steel, d.turns, d.residual_gap, 0, {false});
  for (const double b : {0.5, 1.6, 2.2})
    for (const double gap : {0.0, 1e-3, 5e-3}) {
      const double psi = flux_for(d, b), dp = 1e-5 * psi, dg = 1e-7;
      const auto r = circuit.at({psi, 0, gap + dg});
      const auto p1 = circuit.at({psi + dp, 0, gap + dg}), p0 = circuit.at({psi - dp, 0, gap + dg});
      const auto g1 = circuit.at({psi, 0, gap + 2 * dg}), g0 = circuit.at({psi, 0, gap});
      CHECK(r.current == Approx((p1.energy - p0.energy) / (2 * dp)).epsilon(1e-6));
      CHECK(r.pull == Approx((g1.energy - g0.energy) / (2 * dg)).epsilon(1e-4));
      CHECK(r.current_gap == Approx((g1.current - g0.current) / (2 * dg)).epsilon(1e-3));
      CHECK(r.current_gap == Approx((p1.pull - p0.pull) / (2 * dp)).epsilon(1e-4));
    }
}

TEST_CASE("U-core: the table closes it as the field does") {
  const auto d = two_legs(Core::u);
  TableOptions o;
  o.accuracy = 0.05;
  o.psi_nodes = 14;
  o.gap_nodes = 10;
  o.largest_gap = 4e-3;
  Team team(2);
  const TablePotential table(build_table(d, o, team));
  CHECK(table.least_stiffness() > 0);
  TransientSetup s;
  s.voltage = [](double t) { return 325 * std::sin(314.159265358979 * t + 1.5); };
  s.resistance = 245;
  s.mass = 0.2;
  s.start_gap = 3e-3;
  s.counter_force = [](double) { return 15.0; };
  s.step = 50e-6;
  s.duration = 20e-3;
  const auto by_table = run_transient(table, s);
  const auto by_field = run_transient(d, plan_table(d, o).field, s);
  std::printf("U-core: closed at %.4f ms by the table, %.4f ms by the field; energy %.1e and %.1e\n",
              by_table.closed_at * 1e3, by_field.closed_at * 1e3, by_table.energy.residual(),
              by_field.energy.residual());
  REQUIRE(by_field.closed_at > 0);
  CHECK(by_table.closed_at == Approx(by_field.closed_at).epsilon(2e-3));
  CHECK(std::fabs(by_table.energy.residual()) < 1e-3);
  CHECK(std::fabs(by_field.energy.residual()) < 1e-3);
}

TEST_CASE("U- and C-core in three dimensions without ends are the plane ones") {
  for (const Core core : {Core::u, Core::c}) {
    const auto d = two_legs(core);
    space::CoreMeshSizes sizes = space::CoreMeshSizes{}.scaled(2.5);
    sizes.ends = false;
    space::MagnetField solid(d, sizes);
    MagnetField plane(d, mesh_for(0.005));
    for (const double gap : {0.0, 0.5e-3, 4e-3})
      for (const double field : {1.0, 1.8}) {
        solid.set_gap(gap);
        plane.set_gap(gap);
        const double psi = flux_for(d, field);
        const auto a = solid.at_flux(psi, 0).response, b = plane.at_flux(psi, 0).response;
        std::printf(
            "%s-core, gap %.1f mm, %.1f T: three dimensions %+.2f %% in the current, %+.2f %% in the pull\n",
            name_of(core), gap * 1e3, field, 100 * (a.current / b.current - 1), 100 * (a.pull / b.pull - 1));
        CHECK(a.current == Approx(b.current).epsilon(0.02));
        CHECK(a.pull == Approx(b.pull).epsilon(0.04));
      }
  }
}

TEST_CASE(
    "C-core in three dimensions: the pull and its derivative are those of the energy, its leg saturated") {
  auto d = two_legs(Core::c);
  d.shape.outer_width = 8e-3;  // the leg that stretches saturates first
  space::MagnetField field(d, space::CoreMeshSizes{}.scaled(4));
  double worst_pull = 0, worst_mixed = 0;
  for (const auto& [b, gap] : {std::pair{0.8, 1.5e-3}, {1.5, 0.05e-3}}) {
    const double psi = flux_for(d, b), dg = 1e-3 * (gap + d.residual_gap), dp = 1e-4 * psi;
    const auto at = [&](double p, double g) {
      field.set_gap(g);
      const auto point = field.at_flux(p, 0);
      REQUIRE(point.solution.converged);
      return point;
    };
    const auto r = at(psi, gap).response;
    const auto g1 = at(psi, gap + dg), g0 = at(psi, gap - dg), p1 = at(psi + dp, gap), p0 = at(psi - dp, gap);
    const double pull = (g1.response.energy - g0.response.energy) / (2 * dg),
                 di_dgap = (g1.response.current - g0.response.current) / (2 * dg),
                 df_dpsi = (p1.response.pull - p0.response.pull) / (2 * dp);
    CAPTURE(b, gap);
    CHECK(r.pull == Approx(pull).epsilon(2e-5));
    CHECK(r.current_gap == Approx(di_dgap).epsilon(1e-4));
    CHECK(r.current_gap == Approx(df_dpsi).epsilon(1e-4));
    CHECK(p1.stress_pull == Approx(p1.response.pull).epsilon(0.03));
    worst_pull = std::fmax(worst_pull, std::fabs(r.pull / pull - 1));
    worst_mixed = std::fmax(worst_mixed, std::fabs(df_dpsi / di_dgap - 1));
  }
  std::printf(
      "C-core in three dimensions: pull against differences of W %.1e, dF/dpsi against di/dgap %.1e\n",
      worst_pull, worst_mixed);
}

TEST_CASE("legs that cannot be are told with key, value and range") {
  const auto first = [](auto change) {
    MagnetShape s = two_legs(Core::u).shape;
    change(s);
    const auto errors = shape_errors(s);
    return errors.empty() ? std::string("none") : errors.front().key + " = " + errors.front().value;
  };
  CHECK(first([](MagnetShape&) {}) == "none");
  CHECK(first([](MagnetShape& s) { s.legs = 1; }) == "shape.legs = 1");
  CHECK(first([](MagnetShape& s) { s.legs = 4; }) == "shape.legs = 4");
  CHECK(first([](MagnetShape& s) { s.closed_leg = 2; }) == "shape.closed_leg = 2");
  CHECK(first([](MagnetShape& s) {
          s.legs = 3;
          s.closed_leg = 1;
        }) == "shape.closed_leg = 1");
  CHECK(first([](MagnetShape& s) {
          s.closed_leg = 1;
          s.ring_share = 0.5;
        }) == "shape.ring_share = 0.5");
}
