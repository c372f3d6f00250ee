#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "firmware/port/common/gate_timer.h"
#include "firmware/port/stm32g474/front_end.h"
#include "tests/firmware/bench_fixture.h"

/// When the board port switches the gate: ticks, the timer, and a controller that hands edges out early.

using namespace powbench;
using namespace powbench::firmware;
namespace board = powbench::firmware::stm32g474;

// --- ticks ---

TEST_CASE("instants become ticks to the nearest") {
  const port::TimeBase base = board::time_base;
  CHECK(base.ticks_per_sample == 1700);
  Random random(3);
  for (int i = 0; i < 10'000; ++i) {
    // a day of samples at 100 kS/s is 8.6e9
    const Tick at{static_cast<std::int64_t>(random.below(9'000'000'000ULL)),
                  static_cast<std::uint16_t>(random.below(65536))};
    const long double exact =
        1700.0L + 1700.0L * (static_cast<long double>(at.sample) + at.fraction / 65536.0L);
    CHECK(std::fabs(static_cast<double>(static_cast<long double>(base.ticks(at)) - exact)) <= 0.5);
  }
}

TEST_CASE("a counter reading is unwrapped over any distance below its range") {
  const port::TimeBase base = board::time_base;
  Random random(4);
  for (int i = 0; i < 10'000; ++i) {
    const auto sample = static_cast<std::int64_t>(random.below(9'000'000'000ULL));
    const std::int64_t truth = base.ticks({sample, 0}) + static_cast<std::int64_t>(random.below(65536));
    CHECK(base.unwrap(static_cast<std::uint16_t>(truth), sample) == truth);
  }
}

// --- gate timer against a timer that is simulated tick by tick ---

namespace {

/// Free-running counter with one compare register, as the hardware does it: a match every 2^16 ticks.
struct Hardware {
  enum class Mode { forced_off, frozen, on, off } mode = Mode::forced_off;
  bool enabled = false, level = false;
  std::int64_t now = 0;
  std::uint16_t compare = 0;
  std::int64_t end = -1;  ///< tick of the second compare, < 0: not armed
  std::vector<std::pair<bool, std::int64_t>> changes;

  void set(bool wanted) {
    if (wanted == level) return;
    level = wanted;
    changes.push_back({level, now});
  }
  void write(const port::GateTimer::Action& a) {
    using Write = port::GateTimer::Write;
    compare = a.compare;
    if (a.write == Write::on_at) mode = Mode::on, enabled = true, end = now + a.off_in;
    if (a.write == Write::off_at) mode = Mode::off;
    if (a.write == Write::off_now || a.write == Write::finished)
      mode = Mode::forced_off, enabled = false, end = -1, set(false);
  }
  void run(std::int64_t until) {
    for (; now < until; ++now) {
      if (now == end) enabled = false, set(false);
      if (static_cast<std::uint16_t>(now) != compare) continue;
      if (mode == Mode::on && enabled) set(true);
      if (mode == Mode::off) set(false);
    }
  }
  void poll(port::GateTimer& timer) {
    for (;;) {
      const auto action = timer.poll(now);
      if (action.write == port::GateTimer::Write::nothing) return;
      write(action);
    }
  }
};

constexpr std::int64_t block_ticks = 10 * 1700;

}  // namespace

TEST_CASE("the gate pin follows the edges to the tick, with the latency of a busy processor") {
  Random random(11);
  for (int shot = 0; shot < 40; ++shot) {
    port::GateTimer timer(board::time_base);
    Hardware hardware;
    const Tick on{static_cast<std::int64_t>(60 + random.below(200)),
                  static_cast<std::uint16_t>(random.below(65536))};
    const Tick off{on.sample + static_cast<std::int64_t>(100 + random.below(300)), on.fraction};
    bool on_given = false, off_given = false;
    for (std::int64_t end = 10; end < 800; end += 10) {
      // the controller gives an edge out when it is at least the lead ahead, up to 200 us late
      const auto late = static_cast<std::int64_t>(random.below(2 * block_ticks));
      hardware.run(board::time_base.ticks({end, 0}) + late);
      const auto due = [&](const Tick& t) { return t.sample < end + board::lead_samples + 10; };
      if (!on_given && due(on)) timer.take({true, on, off}), on_given = true;
      if (!off_given && due(off)) timer.take({false, off}), off_given = true;
      hardware.poll(timer);
    }
    REQUIRE(hardware.changes.size() == 2);
    CHECK(hardware.changes[0] == std::pair(true, board::time_base.ticks(on)));
    CHECK(hardware.changes[1] == std::pair(false, board::time_base.ticks(off)));
    CHECK_FALSE(hardware.enabled);
    CHECK(timer.missed() == 0);
  }
}

TEST_CASE("an on edge that comes too late is never made, an off edge at once") {
  port::GateTimer timer(board::time_base);
  Hardware hardware;
  hardware.run(1'000'000);
  const std::int64_t sample = (1'000'000 - 1700) / 1700;  // just gone by
  timer.take({true, {sample, 0}, {sample + 400, 0}});
  hardware.poll(timer);
  hardware.run(1'200'000);
  CHECK(timer.missed() == 1);
  CHECK(hardware.changes.empty());

  timer.take({true, {sample + 140, 0}, {sample + 9000, 0}});
  hardware.poll(timer);
  hardware.run(1'300'000);
  REQUIRE(hardware.changes.size() == 1);
  timer.take({false, {700, 0}});  // long ago
  hardware.poll(timer);
  REQUIRE(hardware.changes.size() == 2);
  CHECK(hardware.changes[1] == std::pair(false, std::int64_t{1'300'000}));
}

TEST_CASE("the coil goes off on time even if no code runs after the on edge has been set") {
  for (const std::int64_t hold : {15, 400, 100'000}) {  // 0.15 ms .. 1 s
    port::GateTimer timer(board::time_base);
    Hardware hardware;
    hardware.run(170'000);
    const Tick on{110, 12'345}, off{110 + hold, 12'345};
    timer.take({true, on, off});
    hardware.poll(timer);
    hardware.run(board::time_base.ticks(off) + 1'000'000);
    REQUIRE(hardware.changes.size() == 2);
    CHECK(hardware.changes[0] == std::pair(true, board::time_base.ticks(on)));
    CHECK(hardware.changes[1].second - board::time_base.ticks(off) == board::time_base.ticks_per_sample);
    CHECK_FALSE(hardware.enabled);
  }
}

TEST_CASE("an on edge without an end of its own is not made") {
  port::GateTimer timer(board::time_base);
  timer.take({true, {1000, 0}, {}});
  CHECK(timer.poll(1000).write == port::GateTimer::Write::nothing);
  CHECK(timer.missed() == 1);
}

TEST_CASE("an abort before the on edge leaves the gate off for good") {
  for (const std::int64_t ahead : {2, 20, 35, 60}) {  // inside and outside of the reach of the compare
    port::GateTimer timer(board::time_base);
    Hardware hardware;
    hardware.run(170'000);
    timer.take({true, {100 + ahead, 0}, {9000, 0}});
    hardware.poll(timer);
    timer.take({false, {99, 0}});
    for (int i = 0; i < 40; ++i) {
      hardware.poll(timer);
      hardware.run(hardware.now + block_ticks);
    }
    CHECK(hardware.changes.empty());
    CHECK_FALSE(hardware.enabled);
  }
}

TEST_CASE("after a cancel no edge is left, whatever the timer held") {
  for (const std::int64_t ahead : {2, 20, 60}) {
    port::GateTimer timer(board::time_base);
    Hardware hardware;
    hardware.run(170'000);
    timer.take({true, {100 + ahead, 0}, {9000, 0}});
    timer.take({false, {9000, 0}});
    hardware.poll(timer);
    CHECK_FALSE(timer.idle());
    timer.cancel();
    CHECK(timer.idle());
    CHECK(timer.poll(hardware.now + 1).write == port::GateTimer::Write::nothing);
  }
}

// --- the controller with a port that needs time ---

TEST_CASE("with a lead, edges are handed out that much earlier and still meet the angle") {
  const std::int64_t lead = board::lead_samples;
  ControllerConfig config = test::Bench::make_config();
  config.fire.lead_samples = lead;
  test::Bench bench;
  std::vector<std::int16_t> storage(4000 * channel_count);
  Controller controller(config, storage);
  std::vector<std::int16_t> scans(10 * channel_count);
  REQUIRE(controller.fire_control().set_closing_angle(9000) == Refusal::accepted);
  std::vector<std::int64_t> ahead;
  Tick on{};
  double on_current = 0;
  for (std::int64_t end = 10; end < 60'000; end += 10) {
    for (std::int64_t i = 0; i < 10; ++i) {
      const std::int64_t n = end - 10 + i;
      const double v = 16000.0 * std::sin(bench.phase_at(static_cast<double>(n)));
      scans[static_cast<std::size_t>(i) * channel_count + index(Channel::mains_voltage)] =
          static_cast<std::int16_t>(std::lrint(v));
      scans[static_cast<std::size_t>(i) * channel_count + index(Channel::coil_current)] =
          static_cast<std::int16_t>(on_current > 0 && n >= on.sample ? 8000 : 0);
    }
    for (const auto& edge : controller.step({.first_sample = end - 10, .scans = scans})) {
      ahead.push_back(edge.at.sample - end);
      if (edge.on) on = edge.at;
      on_current = edge.on ? 1 : 0;
    }
    if (end == 100) REQUIRE(controller.fire_control().arm() == Refusal::accepted);
    if (end == 30'000) REQUIRE(controller.fire_control().fire() == Refusal::accepted);
  }
  REQUIRE(ahead.size() == 2);
  for (const std::int64_t a : ahead) {
    CHECK(a >= lead);
    CHECK(a < lead + 10);
  }
  const double reached = wrap_turn(bench.phase_at(static_cast<double>(on.sample) + on.fraction / 65536.0));
  CHECK(degrees(reached) == Approx(90.0).margin(0.05));  // the tracker's figure for a clean mains
}
