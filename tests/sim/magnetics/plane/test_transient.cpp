#include <catch2/catch.hpp>
#include <cmath>

#include "bench/fields/analytic.h"
#include "bench/fields/blend.h"
#include "bench/fields/contactor.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"

using namespace powbench::sim;
using powbench::bench::BlendedPotential;

namespace {

/// 230 V, 50 Hz on the E-E contactor with 2000 turns.
TransientSetup switch_on() {
  TransientSetup s;
  s.voltage = [](double t) { return 325 * std::sin(2 * powbench::pi * 50 * t + 1.2); };
  s.resistance = 250;
  s.mass = 0.12;
  s.counter_force = [](double gap) { return 10 - 1500 * gap; };
  s.start_gap = 3e-3;
  s.step = 100e-6;
  s.duration = 25e-3;
  return s;
}

MagnetDesign contactor() {
  auto d = powbench::bench::reference_contactor();
  d.turns = 2000;
  d.residual_gap = 20e-6;
  return d;
}

FieldOptions coarse() {
  FieldOptions o;
  o.sizes = sizes_for(0.02);
  o.newton.tolerance = 1e-10;
  return o;
}

}  // namespace

TEST_CASE("a closing with the field in the loop keeps its energy and agrees with the table") {
  const auto design = contactor();
  const auto field = run_transient(design, coarse(), switch_on());
  CHECK(std::fabs(field.energy.residual()) < 1e-3);
  CHECK(field.closed_at > 5e-3);
  TableOptions o;
  o.accuracy = 0.05;  // mesh of 2 %
  o.psi_nodes = o.gap_nodes = 24;
  o.largest_gap = 6e-3;
  Team team(2);
  const TablePotential table(build_table(design, o, team));
  const auto quick = run_transient(table, switch_on());
  CHECK(std::fabs(quick.energy.residual()) < 1e-3);
  CHECK(quick.closed_at == Approx(field.closed_at).epsilon(2e-3));
  double largest = 0, worst = 0;
  for (std::size_t k = 0; k < field.samples.size(); ++k) {
    largest = std::max(largest, std::fabs(field.samples[k].current));
    worst = std::max(worst, std::fabs(field.samples[k].current - quick.samples[k].current));
  }
  CHECK(worst < 0.02 * largest);
}

TEST_CASE("the shading ring takes energy and keeps a least pull") {
  MagnetDesign design;
  auto s = switch_on();
  s.moves = false;
  s.start_gap = 0;
  s.voltage = [](double t) { return 325 * std::sin(2 * powbench::pi * 50 * t + powbench::pi / 2); };
  s.resistance = 250;
  s.step = 150e-6;
  s.duration = 30e-3;
  const auto least = [&](double ohm) {
    s.ring_resistance = ohm;
    const auto r = run_transient(design, coarse(), s);
    CHECK(std::fabs(r.energy.residual()) < 1e-3);
    double pull = 1e300;
    for (const auto& sample : r.samples)
      if (sample.time > 15e-3) pull = std::min(pull, sample.pull);
    return std::pair(pull, r.energy.ring_loss);
  };
  const auto with = least(1.2e-3), without = least(1e3), short_circuit = least(0);
  CHECK(with.first > 3 * without.first);
  CHECK(with.second > 0);
  CHECK(without.second < 1e-3 * with.second);
  CHECK(short_circuit.second == 0);
}

TEST_CASE("eddy currents in solid iron take energy and delay the closing") {
  auto s = switch_on();
  s.step = 80e-6;
  s.duration = 16e-3;
  const auto laminated = run_transient(contactor(), coarse(), s);
  s.iron_conductivity = 5e6;
  const auto solid = run_transient(contactor(), coarse(), s);
  CHECK(std::fabs(solid.energy.residual()) < 1e-3);
  CHECK(solid.energy.eddy_loss > 0.01 * solid.energy.supplied);
  CHECK(solid.closed_at > laminated.closed_at);
}

TEST_CASE("two rungs blend without a step, and derivatives stay those of the energy") {
  auto stiff = contactor();
  stiff.turns = 1000;
  TableOptions o;
  o.accuracy = 0.05;
  o.psi_nodes = o.gap_nodes = 12;
  Team team(2);
  const auto a = std::make_shared<TablePotential>(build_table(stiff, o, team));
  stiff.residual_gap = 60e-6;
  const auto b = std::make_shared<TablePotential>(build_table(stiff, o, team));
  const BlendedPotential blend(a, b, 1e-3, 2e-3);
  for (const double gap : {0.9e-3, 1e-3, 1.3e-3, 1.5e-3, 1.9e-3, 2e-3, 2.5e-3}) {
    constexpr double dg = 1e-9;
    const auto low = blend.at({0.2, 0, gap - dg}), high = blend.at({0.2, 0, gap + dg}),
               r = blend.at({0.2, 0, gap});
    CHECK((high.energy - low.energy) / (2 * dg) == Approx(r.pull).epsilon(1e-5));
    CHECK(high.pull == Approx(low.pull).epsilon(1e-4));
    CHECK((high.current - low.current) / (2 * dg) == Approx(r.current_gap).epsilon(1e-4));
  }
  CHECK_THROWS_AS(BlendedPotential(a, b, 2e-3, 1e-3), std::invalid_argument);
}

TEST_CASE("static fields with closed solutions, to half a percent") {
  for (const auto& r : powbench::bench::static_cases()) {
    INFO(r.name << ", " << r.quantity);
    CHECK(std::fabs(r.error()) < r.limit);
    CHECK(r.unknowns < 20000);
  }
}

TEST_CASE("alternating fields with closed solutions, to half a percent") {
  for (const auto& r : powbench::bench::alternating_cases()) {
    INFO(r.name << ", " << r.quantity);
    CHECK(std::fabs(r.error()) < r.limit);
    CHECK(r.unknowns < 20000);
  }
}

TEST_CASE("circuits with closed solutions, to half a percent") {
  for (const auto& r : powbench::bench::circuit_cases()) {
    INFO(r.name << ", " << r.quantity);
    CHECK(std::fabs(r.error()) < r.limit);
  }
}
