#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "bench/fault_bench.h"
#include "firmware/duty_budget.h"
#include "firmware/survivor.h"
#include "firmware/watchdog_feed.h"
#include "tests/firmware/bench_fixture.h"

using namespace powbench;
using bench::FaultBench;
using firmware::BudgetConfig;
using firmware::DutyBudget;
using firmware::Fault;
using firmware::Refusal;
using firmware::State;
using firmware::Survivor;

namespace {

/// A whole shot on a sound bench.
void shoot(FaultBench& b) {
  b.arm();
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  for (int i = 0; i < 5000 && b.fire_control().state() == State::firing; ++i) b.step();
}

}  // namespace

TEST_CASE("the watchdog is fed only when all four parts have moved on", "[fault]") {
  using Part = firmware::WatchdogFeed::Part;
  constexpr std::array<Part, 4> all{Part::control_interrupt, Part::background, Part::main_loop,
                                    Part::communication};
  for (unsigned moved = 0; moved < 16; ++moved) {
    firmware::WatchdogFeed feed;
    for (unsigned p = 0; p < 4; ++p)
      if ((moved >> p & 1U) != 0)
        for (int again = 0; again < 3; ++again) feed.progress(all[p]);
    CHECK(feed.may_feed() == (moved == 15));
    CHECK_FALSE(feed.may_feed());
  }
}

TEST_CASE("what survives a reset is believed only when it is whole", "[fault]") {
  Survivor s;
  std::memset(&s, 0xA5, sizeof s);  // as after power-on
  CHECK_FALSE(s.has_crash());
  CHECK_FALSE(s.gate_was_on());
  s.forget();
  CHECK_FALSE(s.has_crash());
  s.record_crash(firmware::CrashCause::stack_overflow, 0x08000100U, 0x08000200U);
  REQUIRE(s.has_crash());
  for (unsigned bit = 0; bit < 32; ++bit) {
    for (auto* word : {&s.crash, &s.cause, &s.program_counter, &s.link_register, &s.check}) {
      *word ^= 1U << bit;
      CHECK_FALSE(s.has_crash());
      *word ^= 1U << bit;
    }
    s.note_gate(true);
    s.gate ^= 1U << bit;
    CHECK_FALSE(s.gate_was_on());
  }
  CHECK(s.has_crash());
}

TEST_CASE("the reason of a reset is told, and a crash where it happened", "[fault]") {
  test::Bench b;
  CHECK(b.ask("READ iio:device1 last_reset\n").find("power_on") != std::string::npos);
  Survivor s{};
  s.record_crash(firmware::CrashCause::hard_fault, 0x08001234U, 0x08005678U);
  b.fire_control().boot({.cause = firmware::ResetCause::software, .survivor = &s});
  CHECK(b.ask("READ iio:device1 last_reset\n").find("software hard_fault pc 08001234 lr 08005678") !=
        std::string::npos);
  CHECK(b.ask("READ iio:device1 fault\n").find("11 crash_reset") != std::string::npos);
  CHECK(b.fire_control().arm() == Refusal::faulted);
  b.fire_control().abort();
  CHECK(b.fire_control().state() == State::idle);
  CHECK_FALSE(s.has_crash());  // cleared means cleared
}

TEST_CASE("memory that a power-on left behind is not believed", "[fault]") {
  test::Bench b;
  Survivor s{};
  s.record_crash(firmware::CrashCause::nmi, 1, 2);
  s.note_gate(true);
  b.fire_control().boot({.cause = firmware::ResetCause::power_on, .survivor = &s});
  CHECK(b.fire_control().state() == State::idle);
}

TEST_CASE("the safety relay is in from arm to the end of the shot only", "[fault]") {
  FaultBench b;
  b.run(10'000);
  CHECK_FALSE(b.fire_control().relay_closed());
  REQUIRE(b.fire_control().arm() == firmware::Refusal::accepted);
  CHECK(b.fire_control().relay_closed());
  CHECK(b.fire_control().disarm() == firmware::Refusal::accepted);
  CHECK_FALSE(b.fire_control().relay_closed());
  REQUIRE(b.fire_control().arm() == firmware::Refusal::accepted);
  b.run(10'000);
  REQUIRE(b.fire_control().fire() == firmware::Refusal::accepted);
  bool open = false;
  while (b.fire_control().state() == State::firing) {
    open = open || !b.fire_control().relay_closed();
    b.step();
  }
  CHECK_FALSE(open);
  CHECK(b.fire_control().state() == State::captured);
  CHECK_FALSE(b.fire_control().relay_closed());
}

TEST_CASE("coil current in the first block after a reset is a fault by itself", "[fault]") {
  FaultBench b;
  b.world.next = 500;  // current at its crest
  b.world.causes.switch_stuck = b.world.causes.relay_stuck = b.world.relay_in = true;
  b.step();
  CHECK(b.fire_control().fault() == Fault::reset_while_energised);
}

TEST_CASE("no edge before the relay has been closed for longer than a stuck switch could hide",
          "[fault][relay]") {
  FaultBench b;
  b.world.causes.relay_dead = true;
  b.arm();
  REQUIRE(b.fire_control().fire() == firmware::Refusal::accepted);
  while (b.world.next < b.world.relay_told_at + 9000) b.step();
  CHECK(b.world.ons == 0);
  b.world.causes.relay_dead = false;  // 90 ms late: just in time
  const std::int64_t closed = b.world.next;
  for (const std::int64_t end = closed + 20'000; b.world.ons == 0 && b.world.next < end;) b.step();
  REQUIRE(b.world.ons == 1);
  CHECK(b.world.pin_on_since - closed > b.controller.config().interlocks.stuck_on_samples);
  CHECK(b.world.pin_on_since - closed <
        b.controller.config().interlocks.stuck_on_samples + 2 * FaultBench::cycle);
}

TEST_CASE("a switch that is stuck on is found by arm, before anything is fired", "[fault][relay]") {
  FaultBench b;
  b.run(2000);
  b.world.causes.switch_stuck = true;
  b.run(5000);
  CHECK(b.fire_control().fault() == Fault::none);  // the relay is open: no current, no heat
  CHECK(b.world.last_current < 0);
  REQUIRE(b.fire_control().arm() == firmware::Refusal::accepted);
  b.fire_control().fire();
  b.run(6000);
  CHECK(b.fire_control().fault() == Fault::coil_stuck_on);
  CHECK(b.world.ons == 0);
  CHECK_FALSE(b.world.relay_in);
}

TEST_CASE("the survivor says on exactly while the gate is on", "[fault]") {
  FaultBench b;
  b.fire_control().boot({.cause = firmware::ResetCause::pin, .survivor = &b.survivor});
  b.arm();
  b.fire_control().fire();
  for (int i = 0; i < 3000; ++i) {
    b.step();
    REQUIRE(b.survivor.gate_was_on() == b.fire_control().gate_on());
  }
  CHECK(b.world.ons == 1);
}

TEST_CASE("the budget counts operations and heat, and forgets both with time", "[fault]") {
  const BudgetConfig c{
      .operations_per_minute = 3, .pause_samples = 100, .heat_samples = 1000, .duty_per_mille = 250};
  constexpr std::int64_t minute = 60'000;
  using V = DutyBudget::Verdict;
  DutyBudget b;
  CHECK(b.judge(c, 0, 0, 1000, minute) == V::ready);  // nothing has been fired: no pause
  CHECK(b.judge(c, 0, 0, 1001, minute) == V::too_hot);
  b.note_operation(1000);
  CHECK(b.judge(c, 1099, 1000, 1, minute) == V::pause);
  CHECK(b.judge(c, 1100, 1000, 1, minute) == V::ready);
  b.note_operation(2000);
  b.note_operation(3000);
  CHECK(b.judge(c, 60'999, 3000, 1, minute) == V::too_many);
  CHECK(b.judge(c, 61'000, 3000, 1, minute) == V::ready);
  b.advance(c, 800, true);  // 800 on at a duty of 250: heat 600
  CHECK(b.judge(c, 70'000, 3000, 400, minute) == V::ready);
  CHECK(b.judge(c, 70'000, 3000, 401, minute) == V::too_hot);
  b.advance(c, 2400, false);
  CHECK(b.judge(c, 80'000, 3000, 1000, minute) == V::ready);
}

TEST_CASE("arm waits until current has ended and the contact is proven open", "[fault]") {
  FaultBench b;
  b.arm();
  b.fire_control().fire();
  while (!b.world.pin) b.step();
  b.run(4000);
  REQUIRE(b.contact_closed());
  b.fire_control().abort();
  int refused = 0;
  while (b.fire_control().arm() != Refusal::accepted) {
    ++refused;
    REQUIRE(refused < 1000);
    CHECK(b.fire_control().last_error().find("cannot arm") == 0);
    b.step();
  }
  CHECK_FALSE(b.contact_closed());
  CHECK(b.world.next - b.world.last_current > 600);
  CHECK(refused > 100);
}

TEST_CASE("a saturated force marks the record it falls into, and no other", "[fault]") {
  FaultBench b;
  b.world.causes.force_clipped = true;
  b.arm();
  b.world.causes.force_clipped = false;
  b.run(1000);  // longer than the pre-trigger: the record begins behind it
  b.fire_control().fire();
  for (int i = 0; i < 5000 && b.fire_control().state() == State::firing; ++i) b.step();
  REQUIRE(b.fire_control().state() == State::captured);
  CHECK(b.controller.recorder().marks() == 0);
  b.arm();
  b.fire_control().fire();
  while (!b.world.pin) b.step();
  b.run(500);
  b.world.causes.force_clipped = true;
  b.step();
  b.world.causes.force_clipped = false;
  for (int i = 0; i < 5000 && b.fire_control().state() == State::firing; ++i) b.step();
  REQUIRE(b.fire_control().state() == State::captured);
  CHECK(b.controller.recorder().marks() == bit(firmware::Mark::force_saturated));
}

TEST_CASE("a missed crossing is counted and the next one taken; missing all of them ends in a fault",
          "[fault]") {
  FaultBench b;
  b.arm();
  b.world.causes.late = 15;
  b.fire_control().fire();
  for (int i = 0; i < 450; ++i) b.step();  // 45 ms: two crossings or three
  CHECK(b.fire_control().deadlines_missed() >= 2);
  CHECK(b.world.ons == 0);
  b.run(250'000);
  CHECK(b.world.ons == 0);
  CHECK(b.fire_control().fault() == Fault::phase_stale);
}

TEST_CASE("on request it is the touch that falls on the angle", "[fire]") {
  for (const std::int64_t delay : {0, 1, 1234, 5000, 12'000, 20'000, 49'999}) {
    for (const int angle : {0, 4500, 18'000, 35'999}) {
      FaultBench b;
      REQUIRE(b.fire_control().set_touch_delay_us(delay) == Refusal::accepted);
      REQUIRE(b.fire_control().set_closing_angle(angle) == Refusal::accepted);
      b.arm();
      b.run(5000);
      REQUIRE(b.fire_control().fire() == Refusal::accepted);
      firmware::GateEdge on{};
      while (b.fire_control().state() == State::firing && !on.on) {
        b.step();
        for (std::size_t e = 0; e < b.world.edge_count; ++e)
          if (b.world.edges[e].on) on = b.world.edges[e];
      }
      REQUIRE(on.on);
      const double touch =
          static_cast<double>(on.at.sample) + on.at.fraction / 65536.0 + 0.1 * static_cast<double>(delay);
      const double error = 360.0 * std::remainder(touch / 2000.0 - angle / 36'000.0, 1.0);
      INFO("touch delay " << delay << " us, angle " << angle << ": error " << error << " deg");
      CHECK(std::abs(error) < 0.05);
      // the rising zero crossing last before the gate edge
      const auto since = static_cast<double>(on.at.sample - b.fire_control().zero_cross_sample());
      CHECK(since >= -1.0);
      CHECK(since <= 2001.0);
      CHECK(std::abs(std::remainder(static_cast<double>(b.fire_control().zero_cross_sample()) / 2000.0,
                                    1.0)) < 1e-3);
    }
  }
}

TEST_CASE("touch delay is a set-point like the others", "[fire]") {
  test::Bench b;
  CHECK(b.ask("WRITE iio:device1 touch_delay_us 6\n5000 t") == "6\n");
  CHECK(b.ask("WRITE iio:device1 touch_delay_us 7\n50001 t") == "-34\n");
  CHECK(b.ask("WRITE iio:device1 touch_delay_us 4\n-1 t") == "-34\n");
  CHECK(b.ask("WRITE iio:device1 touch_delay_us 5\n1.5 t") == "-22\n");
  CHECK(b.fire_control().touch_delay_us() == 5000);
}

TEST_CASE("limits of use are refused with a reason", "[fault]") {
  auto config = FaultBench::make_config();
  config.fire.budget.operations_per_minute = 2;
  config.fire.budget.pause_samples = 30'000;
  FaultBench b(config);
  shoot(b);
  CHECK(b.fire_control().arm() == Refusal::wrong_state);
  CHECK(b.fire_control().last_error().find("too soon") == 0);
  b.run(30'000);
  shoot(b);
  b.run(40'000);
  CHECK(b.fire_control().arm() == Refusal::wrong_state);
  CHECK(b.fire_control().last_error().find("too many") == 0);
  CHECK(b.world.ons == 2);
}
