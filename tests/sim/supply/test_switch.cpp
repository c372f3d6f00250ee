// The switch: when it closes, what it keeps going, and when it lets go.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/rigid_closing.h"
#include "tests/sim/supply/supply_cases.h"

using namespace powbench;
using namespace powbench::sim;
using Kind = CoilSwitch::Kind;

namespace {

Supply with(Kind kind) {
  Supply s;
  s.coil_switch.kind = kind;
  return s;
}

Supply triac(double latching, double holding, double pulse = 0, double period = 0) {
  Supply s = with(Kind::triac);
  s.coil_switch.latching_current = latching;
  s.coil_switch.holding_current = holding;
  s.coil_switch.gate_pulse = pulse;
  s.coil_switch.gate_period = period;
  return s;
}

std::vector<double> turn_offs(const Trajectory& run) {
  std::vector<double> times;
  for (const auto& e : run.events)
    if (e.kind == PlantEvent::Kind::coil_open) times.push_back(e.time);
  return times;
}

/// s, when the current of the plain coil first reaches `amperes`, on the closed form.
double time_of_current(const Specimen& s, double degrees, double amperes) {
  const double l = open_inductance(s), r = s.coil.resistance, omega = 2 * pi * 50, theta = radians(degrees);
  const double lag = std::atan2(omega * l, r), amplitude = std::sqrt(2.0) * 230 / std::hypot(r, omega * l);
  const auto current = [&](double t) {
    return amplitude * (std::sin(omega * t + theta - lag) - std::sin(theta - lag) * std::exp(-r / l * t));
  };
  double low = 0, high = 3e-3;
  for (int i = 0; i < 80; ++i) (current((low + high) / 2) < amperes ? low : high) = (low + high) / 2;
  return high;
}

}  // namespace

TEST_CASE("a relay's delay shifts the closing: as the later angle does, and by as much") {
  Supply relay = with(Kind::relay);
  relay.coil_switch.closing_delay = 2.5e-3;  // 45 deg
  const auto late = simulate({}, at_angle(30), 0.07, 1e-3, 1e-11, relay);
  const auto plain = simulate({}, at_angle(75), 0.07, 1e-3, 1e-11);
  CHECK(*late.truth.touch - 2.5e-3 == Approx(*plain.truth.touch).margin(1e-9));
  CHECK(*late.truth.core_seat - 2.5e-3 == Approx(*plain.truth.core_seat).margin(1e-9));
  CHECK(late.samples[1].coil_current == 0);
  CHECK(late.samples[2].coil_current != 0);
  const auto rigid = simulate_rigid({}, at_angle(30), 0.07, 1e-3, 1e-10, true, relay);
  CHECK(*rigid.truth.core_seat == Approx(*late.truth.core_seat).margin(1e-8));
}

TEST_CASE("a relay's bounce interrupts only where the current passes zero while it lasts") {
  const Specimen s = plain_coil();
  Supply relay = with(Kind::relay);
  relay.coil_switch.bounces[0] = {0.4e-3, 0.9e-3};  // the current rises: an arc carries it over
  const auto carried = simulate(s, at_angle(90), 0.03, 1e-4, 1e-10, relay);
  const auto plain = simulate(s, at_angle(90), 0.03, 1e-4, 1e-10);
  CHECK(turn_offs(carried).empty());
  for (std::size_t k = 0; k < plain.samples.size(); ++k)
    CHECK(carried.samples[k].coil_current == Approx(plain.samples[k].coil_current).margin(1e-9));

  double zero = 0;  // of the current, on the samples of the undisturbed run
  for (std::size_t k = 20; k + 1 < plain.samples.size() && zero == 0; ++k) {
    const double a = plain.samples[k].coil_current, b = plain.samples[k + 1].coil_current;
    if (a > 0 && b <= 0) zero = plain.samples[k].time + 1e-4 * a / (a - b);
  }
  REQUIRE(zero > 0);
  relay.coil_switch.bounces[1] = {zero - 0.3e-3, zero + 0.5e-3};
  const auto cut = simulate(s, at_angle(90), 0.03, 1e-4, 1e-10, relay);
  REQUIRE(turn_offs(cut).size() == 1);
  CHECK(turn_offs(cut)[0] == Approx(zero).margin(1e-6));
  for (const auto& p : cut.samples)
    if (p.time > zero + 1e-5 && p.time < zero + 0.49e-3) CHECK(p.coil_current == 0);
  CHECK(cut.samples[static_cast<std::size_t>(1e4 * zero) + 8].coil_current != 0);
  CHECK(cut.energy_residual < 1e-8);
}

TEST_CASE("a relay opens after its delay, at the next zero of the current; a short command never closes it") {
  Supply relay = with(Kind::relay);
  relay.coil_switch.closing_delay = 5e-3;
  relay.coil_switch.opening_delay = 4e-3;
  Conditions c = at_angle(60);
  c.hold_time = 50e-3;
  const auto run = simulate({}, c, 0.1, 1e-4, 1e-9, relay);
  const auto off = turn_offs(run);
  REQUIRE(off.size() == 1);
  CHECK(off[0] > 54e-3);
  CHECK(off[0] < 64e-3);
  CHECK(run.truth.opened);
  c.hold_time = 4.9e-3;
  for (const auto& p : simulate({}, c, 0.03, 1e-3, 1e-9, relay).samples) CHECK(p.coil_current == 0);
}

TEST_CASE(
    "triac: a pulse that ends before the latching current is reached drops out, one that ends after stays") {
  const Specimen s = plain_coil();
  constexpr double latching = 0.03, holding = 0.02, degrees = 60;
  const double reached = time_of_current(s, degrees, latching);
  const auto run = [&](double pulse) {
    return simulate(s, at_angle(degrees), 0.03, 1e-4, 1e-11, triac(latching, holding, pulse));
  };
  const auto late = run(reached + 1e-7), early = run(reached - 1e-7);
  REQUIRE(turn_offs(early).size() == 1);
  CHECK(turn_offs(early)[0] == Approx(reached - 1e-7).margin(1e-12));
  REQUIRE(turn_offs(late).size() == 1);
  CHECK(turn_offs(late)[0] > 5e-3);  // at the end of the half-wave
  CHECK(turn_offs(late)[0] < 16e-3);
  for (const auto& p : late.samples)
    if (p.time > turn_offs(late)[0]) CHECK(p.coil_current == 0);
  CHECK(early.energy_residual < 1e-7);  // of the few millijoules that were supplied
  CHECK(late.energy_residual < 1e-8);
}

TEST_CASE("triac: turns off where the current falls to the holding current, located exactly") {
  const Specimen s = plain_coil();
  const auto supply = triac(0.05, 0.04, 4e-3);
  Mains mains = closing_mains(at_angle(90), supply.mains);
  Plant scout(s, mains, {1e-12, 293.15, supply.coil_switch});
  scout.gate(true);
  scout.advance(0.03, {}, {});
  double off = 0;
  for (const auto& e : scout.events())
    if (e.kind == PlantEvent::Kind::coil_open) off = e.time;
  REQUIRE(off > 4e-3);
  Plant plant(s, mains, {1e-12, 293.15, supply.coil_switch});
  plant.gate(true);
  const std::vector<double> times{off - 1e-9, off + 1e-9};
  std::vector<PlantSample> out(2);
  plant.advance(0.03, times, out);
  CHECK(std::fabs(out[0].coil_current) == Approx(0.04).margin(2e-7));  // 1 ns at 150 A/s
  CHECK(out[1].coil_current == 0);
}

TEST_CASE("triac: a current that has latched and fallen below the latching current again stays on") {
  const Specimen s = plain_coil();
  // the gate is let go on the falling side, between holding and latching current
  const auto driven = simulate(s, at_angle(90), 0.02, 1e-5, 1e-11, triac(0.1, 0.02));
  double falling = 0;
  for (const auto& p : driven.samples)
    if (p.time > 3e-3 && falling == 0 && p.coil_current < 0.06 && p.coil_current > 0.05) falling = p.time;
  REQUIRE(falling > 0);
  const auto run = simulate(s, at_angle(90), 0.02, 1e-5, 1e-11, triac(0.1, 0.02, falling));
  REQUIRE(turn_offs(run).size() == 1);
  CHECK(turn_offs(run)[0] > falling + 1e-5);
  // just behind the zero it has not latched again
  double zero = 0;
  for (const auto& p : driven.samples)
    if (p.time > falling && zero == 0 && p.coil_current < -0.03) zero = p.time;
  REQUIRE(zero > 0);
  const auto next = simulate(s, at_angle(90), 0.02, 1e-5, 1e-11, triac(0.1, 0.02, zero));
  REQUIRE(turn_offs(next).size() == 1);
  CHECK(turn_offs(next)[0] == Approx(zero).margin(1e-12));
}

TEST_CASE("triac: driven without pause it is the ideal switch until it is let go") {
  Conditions c = at_angle(100);
  c.hold_time = 45e-3;
  const auto ideal = simulate({}, c, 0.1, 1e-3, 1e-10);
  const auto driven = simulate({}, c, 0.1, 1e-3, 1e-10, triac(0.03, 0.015));
  CHECK(*driven.truth.touch == Approx(*ideal.truth.touch).margin(1e-9));
  CHECK(*driven.truth.core_seat == Approx(*ideal.truth.core_seat).margin(1e-9));
  REQUIRE(turn_offs(driven).size() == 1);
  CHECK(turn_offs(driven)[0] < turn_offs(ideal)[0]);
  CHECK(turn_offs(ideal)[0] - turn_offs(driven)[0] < 2e-3);
  CHECK(driven.energy_residual < 1e-6);
  const auto rigid = simulate_rigid({}, c, 0.1, 1e-3, 1e-10, true, triac(0.03, 0.015));
  CHECK(*rigid.truth.opened == Approx(*driven.truth.opened).margin(1e-7));
  CHECK(rigid.energy_residual < 1e-6);
}

TEST_CASE("triac: one pulse is one half-wave and closes nothing; a train of pulses fires every half-wave") {
  const auto once = simulate({}, at_angle(90), 0.06, 1e-4, 1e-9, triac(0.03, 0.015, 3e-3));
  REQUIRE(turn_offs(once).size() == 1);
  const auto train = simulate({}, at_angle(90), 0.06, 1e-4, 1e-9, triac(0.03, 0.015, 0.4e-3, 0.5e-3));
  CHECK(turn_offs(train).size() >= 4);
  REQUIRE(train.truth.core_seat);
  const auto ideal = simulate({}, at_angle(90), 0.06, 0, 1e-9);
  CHECK(*train.truth.core_seat == Approx(*ideal.truth.core_seat).margin(1e-3));
  CHECK(train.energy_residual < 1e-6);
}

TEST_CASE("a current of the other sign is held and let go alike") {
  const Specimen s = plain_coil();
  const auto plus = simulate(s, at_angle(60), 0.03, 1e-4, 1e-11, triac(0.03, 0.02, 3e-3));
  const auto minus = simulate(s, at_angle(240), 0.03, 1e-4, 1e-11, triac(0.03, 0.02, 3e-3));
  REQUIRE(turn_offs(plus).size() == 1);
  REQUIRE(turn_offs(minus).size() == 1);
  CHECK(turn_offs(minus)[0] == Approx(turn_offs(plus)[0]).margin(1e-11));
}

TEST_CASE("switches that cannot be are refused by name") {
  const auto refused = [](auto change) {
    Supply bench = with(Kind::relay);
    change(bench.coil_switch);
    return [bench] { simulate({}, {}, 0.01, 0, 1e-8, bench); };
  };
  CHECK_THROWS_WITH(refused([](CoilSwitch& s) { s.closing_delay = -1; })(), Catch::Contains("closing_delay"));
  CHECK_THROWS_WITH(refused([](CoilSwitch& s) {
                      s.bounces[0] = {2e-3, 1e-3};
                    })(),
                    Catch::Contains("bounce close"));
  CHECK_THROWS_WITH(refused([](CoilSwitch& s) {
                      s.bounces[0] = {1e-3, 2e-3};
                      s.bounces[1] = {1.5e-3, 3e-3};
                    })(),
                    Catch::Contains("bounce open"));
  CHECK_THROWS_WITH(refused([](CoilSwitch& s) { s.holding_current = 0.1; })(),
                    Catch::Contains("holding_current"));
  CHECK_THROWS_WITH(refused([](CoilSwitch& s) {
                      s.gate_pulse = 2e-3;
                      s.gate_period = 1e-3;
                    })(),
                    Catch::Contains("gate_period"));
}
