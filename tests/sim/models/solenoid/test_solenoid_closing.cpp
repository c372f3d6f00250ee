// The solenoid as a system: closed forms of R and L, the energy of every supply, the tap, the published pull-in.

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/fields/published_solenoid.h"
#include "sim/models/solenoid/solenoid_closing.h"
#include "sim/models/solenoid/solenoid_live.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

/// W = psi^2 / (2 L),  L = most / (1 + gap / length).
struct PlainMagnet final : MagneticPotential {
  double most = 0.5, length = 1e-3;
  bool has_ring() const override { return false; }
  MagneticResponse at(const MagneticState& s) const override {
    const double inverse = (1 + s.gap / length) / most;
    MagneticResponse r;
    r.energy = 0.5 * s.psi * s.psi * inverse;
    r.current = s.psi * inverse;
    r.pull = 0.5 * s.psi * s.psi / (most * length);
    r.current_psi = inverse;
    r.current_gap = s.psi / (most * length);
    return r;
  }
};

SolenoidCase on_dc(Suppression::Kind across, double duration) {
  SolenoidCase c;
  c.supply.mains.kind = Mains::Kind::dc;
  c.supply.mains.volts = 24;
  c.supply.suppression.kind = across;
  c.duration = duration;
  return c;
}

SolenoidSpecimen held() {
  SolenoidSpecimen s;
  s.plunger.return_preload = 1e5;
  s.plunger.stop_stiffness = 1e9;
  return s;
}

}  // namespace

TEST_CASE("a held plunger: the current of a solenoid is that of R and L, on and off through a diode") {
  const PlainMagnet magnet;
  const auto s = held();
  auto c = on_dc(Suppression::Kind::diode, 120e-3);
  c.tolerance = 1e-11;
  c.hold = 60e-3;
  c.supply.suppression.forward = 0.9;
  c.coil_kelvin = 293.15 + 40;
  const double r = 9 * (1 + 40 * 3.93e-3), l = 0.5 / 11,
               off_current = 24 / r * (1 - std::exp(-r / l * c.hold));
  const auto run = simulate_solenoid(s, magnet, c);
  CHECK_FALSE(run.truth.seat);
  for (const auto& q : run.samples) {
    const double t = q.time - c.hold,
                 expected = t <= 0 ? 24 / r * (1 - std::exp(-r / l * q.time))
                                   : std::max((off_current + 0.9 / r) * std::exp(-r / l * t) - 0.9 / r, 0.0);
    // the stop gives by nanometres under the pull
    CHECK(std::fabs(q.current - expected) < 3e-6);
  }
}

TEST_CASE("energies of a closing and an opening balance on every supply") {
  const PlainMagnet magnet;
  SolenoidSpecimen s;
  s.plunger.friction = 0.4;
  s.plunger.load_mass = 0.02;
  for (const auto source : {Mains::Kind::dc, Mains::Kind::half_wave, Mains::Kind::full_wave})
    for (const auto across : {Suppression::Kind::none, Suppression::Kind::diode, Suppression::Kind::varistor,
                              Suppression::Kind::rc}) {
      if (source != Mains::Kind::dc && across == Suppression::Kind::rc) continue;
      INFO("source " << static_cast<int>(source) << ", across " << static_cast<int>(across));
      auto c = on_dc(across, 150e-3);
      c.supply.mains.kind = source;
      c.supply.mains.volts = 40;
      c.supply.suppression.clamp = 80;
      c.supply.suppression.resistance = across == Suppression::Kind::rc ? 100 : 0;
      c.supply.suppression.capacitance = 1e-6;
      c.hold = 90e-3;
      c.tolerance = 1e-9;
      const auto run = simulate_solenoid(s, magnet, c);
      CHECK(run.truth.seat);
      CHECK(run.energy_residual < 1e-6);
      CHECK(run.truth.dip_current < run.truth.peak_current);
    }
}

TEST_CASE("release: a diode holds longest, a varistor lets go sooner") {
  const PlainMagnet magnet;
  const auto later = [&](Suppression::Kind across) {
    auto c = on_dc(across, 400e-3);
    c.supply.suppression.clamp = 60;
    c.hold = 100e-3;
    const auto run = simulate_solenoid(SolenoidSpecimen{}, magnet, c);
    REQUIRE(run.truth.unseat);
    REQUIRE(run.truth.back);
    CHECK(*run.truth.back > *run.truth.unseat);
    return *run.truth.unseat - c.hold;
  };
  const double diode = later(Suppression::Kind::diode), varistor = later(Suppression::Kind::varistor),
               cut = later(Suppression::Kind::none);
  CHECK(diode > 3 * varistor);
  CHECK(varistor > cut);
}

TEST_CASE(
    "an economiser with a hold winding: ampere turns stay at the tap, the last current is that of both "
    "windings") {
  const PlainMagnet magnet;
  SolenoidSpecimen s;
  s.design.turns = 800;
  s.coil.hold_turns = 2400;
  s.coil.hold_resistance = 91;
  s.coil.hold_from = 8e-3;
  auto c = on_dc(Suppression::Kind::diode, 800e-3);
  c.sample_step = 5e-6;
  const auto run = simulate_solenoid(s, magnet, c);
  REQUIRE(run.truth.seat);
  CHECK(run.energy_residual < 1e-6);
  int taps = 0;
  for (const auto& e : run.events) {
    if (e.kind != SolenoidEvent::Kind::tap) continue;
    ++taps;
    const auto k = static_cast<std::size_t>(e.time / c.sample_step);
    const double before = run.samples[k - 1].current, after = run.samples[k + 2].current;
    CHECK(after / before == Approx(taps % 2 == 1 ? 0.25 : 4.0).epsilon(2e-2));
  }
  CHECK(taps % 2 == 1);
  CHECK(run.truth.last_current == Approx(0.24).epsilon(1e-3));
}

TEST_CASE("a pull-in of the Modelica library's solenoid is within 1.5 percent of its finite elements") {
  SolenoidSpecimen s;
  s.design = bench::published_solenoid();
  s.coil.resistance = 10;
  s.plunger.mass = 7853 * 26e-3 * pi * 25e-6;
  s.plunger.load_mass = 0.01;
  s.plunger.return_preload = s.plunger.return_rate = 0;
  TableOptions o;
  o.accuracy = 0.01;
  Team team(2);
  const TablePotential table(build_table(s.design, o, team));
  auto c = on_dc(Suppression::Kind::diode, 15e-3);
  c.supply.mains.volts = 12;
  const auto run = simulate_solenoid(s, table, c);
  REQUIRE(run.truth.seat);
  CHECK(*run.truth.seat == Approx(bench::published_pull_in_time).epsilon(0.015));
  CHECK(run.truth.peak_current == Approx(bench::published_peak_current).epsilon(0.015));
  CHECK(run.energy_residual < 2e-5);
  CHECK(run.beyond == 0);
}

TEST_CASE("a solenoid closes with the field in the loop as by its table", "[.slow]") {
  SolenoidSpecimen s;
  TableOptions o;
  o.accuracy = 0.0125;  // mesh of 0.5 %
  o.psi_nodes = o.gap_nodes = 24;
  Team team(2);
  const TablePotential table(build_table(s.design, o, team));
  FieldOptions f;
  f.sizes = sizes_for(5e-3);
  const LiveSolenoid live(s.design, f);
  auto c = on_dc(Suppression::Kind::diode, 30e-3);
  const auto quick = simulate_solenoid(s, table, c);
  c.tolerance = 1e-6;
  const auto field = simulate_solenoid(s, live, c);
  REQUIRE(quick.truth.seat);
  REQUIRE(field.truth.seat);
  CHECK(*quick.truth.seat == Approx(*field.truth.seat).epsilon(5e-3));
  CHECK(quick.truth.dip_current == Approx(field.truth.dip_current).epsilon(5e-2));
}

TEST_CASE("numbers of a solenoid that do not go together are told with key, value and range") {
  using Catch::Matchers::Contains;
  const PlainMagnet magnet;
  const auto refuse = [&](auto change, const char* text) {
    SolenoidSpecimen s;
    auto c = on_dc(Suppression::Kind::diode, 10e-3);
    change(s, c);
    CHECK_THROWS_WITH(simulate_solenoid(s, magnet, c), Contains(text) && Contains("allowed"));
  };
  refuse([](auto& s, auto&) { s.plunger.mass = 0; }, "plunger.mass_g = 0");
  refuse([](auto& s, auto&) { s.plunger.load = -6; }, "plunger.load_N = -6");
  refuse([](auto& s, auto&) { s.coil.hold_turns = 100; }, "coil.hold_from_mm = 0");
  refuse([](auto& s, auto&) { s.coil.hold_from = 1e-3; }, "coil.hold_from_mm = 1");
  refuse([](auto& s, auto&) { s.design.shape.cone_angle = 0.5; }, "cone_angle_deg");
  refuse([](auto&, auto& c) { c.supply.mains.kind = Mains::Kind::ac; }, "supply.kind = ac");
  refuse([](auto&, auto& c) { c.tolerance = 1; }, "tolerance");
}
