#include <catch2/catch.hpp>

#include "core/phase.h"
#include "core/random.h"
#include "tests/firmware/bench_fixture.h"

using namespace powbench;
using firmware::Fault;
using firmware::Refusal;
using firmware::State;
using powbench::test::Bench;

namespace {

/// Armed with a valid phase estimate.
Bench& armed(Bench& b) {
  b.run(0.1);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  b.run(0.2);
  REQUIRE(b.fire_control().phase().valid());
  return b;
}

double edge_error_deg(const Bench& b, const firmware::GateEdge& edge, CentiDegrees wanted) {
  const double sample = static_cast<double>(edge.at.sample) + edge.at.fraction / 65536.0;
  return degrees(wrap_half_turn(b.phase_at(sample) - radians(wanted / 100.0)));
}

}  // namespace

TEST_CASE("the gate edge falls on the commanded angle", "[fire]") {
  for (const double hertz : {45.0, 50.0, 60.0, 65.0}) {
    for (const CentiDegrees angle : {0, 1, 3000, 9000, 17999, 18000, 27000, 35999}) {
      Bench b(hertz);
      REQUIRE(b.fire_control().set_closing_angle(angle) == Refusal::accepted);
      armed(b);
      REQUIRE(b.fire_control().fire() == Refusal::accepted);
      b.run(0.3);
      REQUIRE(b.fire_control().state() == State::captured);
      REQUIRE(b.history.size() == 2);
      CHECK(b.history[0].on);
      CHECK_FALSE(b.history[1].on);
      INFO(hertz << " Hz, " << angle << " centideg: error " << edge_error_deg(b, b.history[0], angle)
                 << " deg");
      CHECK(std::abs(edge_error_deg(b, b.history[0], angle)) < 0.05);
      CHECK(b.history[1].at.sample - b.history[0].at.sample == 10'000);  // hold time 100 ms
    }
  }
}

TEST_CASE("the record spans the gate edge, with its pre-trigger in front", "[fire]") {
  Bench b;
  armed(b);
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  b.run(0.3);
  const auto& r = b.controller.recorder();
  REQUIRE(r.complete());
  CHECK(r.first_sample() + r.fire_sample() == b.history[0].at.sample_at_or_after());
  // the fixture writes the sample index into film A: the scans must be the right ones, in order
  for (const std::uint64_t i : {0, 1, 999, 1000, 2999}) {
    std::uint8_t bytes[2];
    r.copy(i, 1, 1U, bytes);
    const int value = bytes[0] | bytes[1] << 8;
    CHECK(value == (r.first_sample() + static_cast<std::int64_t>(i)) % 30000);
  }
}

TEST_CASE("one arm gives one fire", "[fire]") {
  Bench b;
  b.run(0.2);
  CHECK(b.fire_control().fire() == Refusal::wrong_state);
  armed(b);
  CHECK(b.fire_control().fire() == Refusal::accepted);
  CHECK(b.fire_control().fire() == Refusal::wrong_state);
  CHECK(b.fire_control().arm() == Refusal::wrong_state);
  b.run(0.4);
  CHECK(b.fire_control().fire() == Refusal::wrong_state);
  CHECK(b.history.size() == 2);
}

TEST_CASE("a board that is unfit is never armed, and says why", "[fire]") {
  Bench b;
  b.fire_control().boot({.unfit = "option bytes: not as required"});
  b.run(0.2);
  CHECK(b.fire_control().arm() == Refusal::faulted);
  CHECK(b.fire_control().last_error() == "option bytes: not as required");
  CHECK(b.fire_control().fire() == Refusal::wrong_state);
  b.fire_control().abort();
  CHECK(b.fire_control().arm() == Refusal::faulted);
  b.run(0.2);
  CHECK(b.history.empty());
}

TEST_CASE("a sagging supply is named even when the comparator's cut-off comes with it", "[fire][fault]") {
  Bench b;
  firmware::Interlocks interlocks(b.controller.config().interlocks);
  const std::vector<std::int16_t> scans(80);
  firmware::Block block{.scans = scans, .comparator_trip = true, .brown_out = true};
  CHECK(interlocks.check(block, {}) == Fault::brown_out);
  block.first_sample = 10;
  block.brown_out = false;
  CHECK(interlocks.check(block, {}) == Fault::coil_overcurrent);
}

TEST_CASE("set-points out of range are refused, never clamped", "[fire]") {
  Bench b;
  auto& f = b.fire_control();
  CHECK(f.set_closing_angle(-1) == Refusal::out_of_range);
  CHECK(f.set_closing_angle(36000) == Refusal::out_of_range);
  CHECK(f.set_hold_time_ms(0) == Refusal::out_of_range);
  CHECK(f.set_hold_time_ms(10'001) == Refusal::out_of_range);
  CHECK(f.set_angle_tolerance(9) == Refusal::out_of_range);
  CHECK(f.set_angle_tolerance(90'001) == Refusal::out_of_range);
  CHECK(f.closing_angle() == 0);
  CHECK(f.hold_time_ms() == 100);
  CHECK(f.tolerance_millideg() == 1000);
}

TEST_CASE("a shot is fired within the tolerance it was armed with, or not at all", "[fire][phase]") {
  const auto fired_on_hunting_mains = [](std::int64_t tolerance) {
    Bench b;
    b.hunting = radians(3);
    auto& f = b.fire_control();
    REQUIRE(f.set_angle_tolerance(tolerance) == Refusal::accepted);
    b.run(0.1);
    REQUIRE(f.arm() == Refusal::accepted);
    CHECK(f.set_angle_tolerance(1000) == Refusal::wrong_state);
    b.run(0.5);
    REQUIRE(f.fire() == Refusal::accepted);
    b.run(1.5);
    INFO(tolerance << " millidegrees: u " << f.angle_deviation() * 360 << " deg, " << name(f.state()));
    if (b.history.empty()) {
      CHECK(f.fault() == Fault::phase_invalid);
      return false;
    }
    CHECK(f.state() == State::captured);
    CHECK(f.angle_deviation() * 360'000 * 3 <= static_cast<float>(tolerance));
    CHECK(std::abs(edge_error_deg(b, b.history[0], 0)) * 1e3 < static_cast<double>(tolerance));
    return true;
  };
  CHECK(fired_on_hunting_mains(20'000));
  CHECK_FALSE(fired_on_hunting_mains(10));
}

TEST_CASE("no edge on a mains that has jumped half a millisecond before", "[fire][phase]") {
  const auto edges = [](std::int64_t jump_at, double jump) {
    Bench b;
    armed(b);
    REQUIRE(b.fire_control().fire() == Refusal::accepted);
    while (b.history.empty() && b.next < jump_at) b.step();
    b.phase += jump;
    const auto before = b.history.size();
    for (int i = 0; i < 50 && b.history.size() == before; ++i) b.step();
    return b.history;
  };
  const auto undisturbed = edges(1 << 20, 0);
  REQUIRE_FALSE(undisturbed.empty());
  const std::int64_t due = undisturbed.front().at.sample;
  for (int before = 60; before <= 400; before += 10) {
    INFO(before << " samples before the edge");
    CHECK(edges(due - before, 0.5).empty());
  }
}

TEST_CASE("the gate has one door, and it is shut unless all conditions hold", "[fire]") {
  using firmware::Gate;
  const Gate::Permit good{true, true, true, true, 1000, 2000};
  CHECK(Gate{}.energise(good, {100, 0}));
  for (int broken = 0; broken < 6; ++broken) {
    Gate::Permit p = good;
    if (broken == 0) p.armed_and_fired = false;
    if (broken == 1) p.phase_valid = false;
    if (broken == 2) p.no_fault = false;
    if (broken == 3) p.hold_samples = 0;
    if (broken == 4) p.hold_samples = 2001;
    if (broken == 5) p.config_intact = false;
    Gate gate;
    CHECK_FALSE(gate.energise(p, {100, 0}));
    CHECK(gate.edges_before(10'000).empty());
  }
  Gate twice;
  CHECK(twice.energise(good, {100, 0}));
  CHECK_FALSE(twice.energise(good, {200, 0}));
  CHECK(twice.edges_before(101).size() == 1);
  CHECK_FALSE(twice.energise(good, {200, 0}));
  twice.force_off(150);
  const auto off = twice.edges_before(151);
  REQUIRE(off.size() == 1);
  CHECK_FALSE(off[0].on);
  CHECK(off[0].at.sample == 150);
}

TEST_CASE("faults trip, switch the coil off and latch", "[fire][fault]") {
  SECTION("mains lost while energised") {
    Bench b;
    armed(b).fire_control().fire();
    while (!b.fire_control().gate_on()) b.step();
    b.run(0.01);
    b.mains_on = false;
    b.run(0.03);
    CHECK(b.fire_control().fault() == Fault::mains_lost);
    CHECK_FALSE(b.gate_level);
  }
  SECTION("emergency stop while armed") {
    Bench b;
    armed(b).step(true);
    CHECK(b.fire_control().fault() == Fault::emergency_stop);
    CHECK(b.fire_control().fire() == Refusal::faulted);
  }
  SECTION("coil overcurrent opens the gate within one block") {
    Bench b;
    armed(b).fire_control().fire();
    while (!b.gate_level) b.step();
    b.current = 30000;
    b.step();
    CHECK(b.fire_control().fault() == Fault::coil_overcurrent);
    b.step();
    CHECK_FALSE(b.gate_level);
  }
  SECTION("no current after the gate") {
    Bench b;
    b.current = 0;
    armed(b).fire_control().fire();
    b.run(0.1);
    CHECK(b.fire_control().fault() == Fault::coil_not_energising);
    CHECK_FALSE(b.gate_level);
  }
  SECTION("coil current with the gate off") {
    Bench b;
    armed(b).fire_control().fire();
    b.shorted = true;
    b.run(0.3);
    CHECK(b.fire_control().fault() == Fault::coil_stuck_on);
    b.fire_control().abort();
    CHECK(b.fire_control().state() == State::fault);  // the cause is still there
    b.shorted = false;
    b.run(0.1);
    b.fire_control().abort();
    CHECK(b.fire_control().state() == State::idle);
  }
  SECTION("lost samples") {
    Bench b;
    armed(b).fire_control().fire();
    while (!b.gate_level) b.step();
    b.drop_next = 3;
    b.step();
    CHECK(b.fire_control().fault() == Fault::samples_lost);
    b.step();
    CHECK_FALSE(b.gate_level);
  }
}

TEST_CASE("without mains nothing is ever energised", "[fire][fault]") {
  Bench b;
  b.mains_on = false;
  b.run(0.05);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  b.run(2.0);
  CHECK(b.fire_control().state() == State::fault);
  CHECK(b.history.empty());
  CHECK(b.fire_control().arm() == Refusal::faulted);
}

TEST_CASE("equal shots give equal edges whatever went before", "[fire]") {
  // same phase at arming, different histories
  Bench first, second;
  first.run(0.2);
  second.run(0.2);
  second.fire_control().arm();
  second.run(0.25);
  second.fire_control().disarm();
  second.run(0.35);
  for (auto* b : {&first, &second}) {
    b->fire_control().set_closing_angle(4500);
    b->fire_control().arm();
    const std::int64_t armed_at = b->next;
    b->run(0.2);
    b->fire_control().fire();
    b->run(0.3);
    REQUIRE(b->history.size() == 2);
    for (auto& e : b->history) e.at.sample -= armed_at;
  }
  CHECK(first.history[0].at.sample == second.history[0].at.sample);
  CHECK(first.history[0].at.fraction == second.history[0].at.fraction);
}

TEST_CASE("random commands never energise the coil without arm and fire, nor longer than asked", "[fire]") {
  Bench b;
  b.run(0.2);
  Random random(11);
  std::int64_t fires = 0;
  for (int i = 0; i < 20'000; ++i) {
    switch (random.below(9)) {
      case 0:
        b.fire_control().arm();
        break;
      case 1:
        b.fire_control().disarm();
        break;
      case 2:
        fires += b.fire_control().fire() == Refusal::accepted;
        break;
      case 3:
        b.fire_control().abort();
        break;
      case 4:
        b.fire_control().set_hold_time_ms(static_cast<std::int64_t>(random.below(40)) - 5);
        break;
      case 5:
        b.fire_control().set_closing_angle(static_cast<std::int64_t>(random.below(40'000)) - 2000);
        break;
      default:
        b.run(1e-3 * static_cast<double>(random.below(30)));
        break;
    }
  }
  std::int64_t ons = 0;
  for (std::size_t i = 0; i < b.history.size(); ++i) {
    if (!b.history[i].on) continue;
    ++ons;
    if (i + 1 == b.history.size()) continue;
    CHECK_FALSE(b.history[i + 1].on);
    CHECK(b.history[i + 1].at.sample - b.history[i].at.sample <= 35 * 100);
  }
  CHECK(ons > 10);
  CHECK(ons <= fires);
}
