#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <numeric>

#include "core/random.h"
#include "firmware/port/common/gate_timer.h"
#include "firmware/port/common/progress.h"
#include "firmware/port/common/scan_queue.h"
#include "firmware/port/common/uart_link.h"
#include "firmware/port/stm32g474/front_end.h"
#include "tests/firmware/bench_fixture.h"

/// What the board port decides and computes, apart from its registers.

using namespace powbench;
using namespace powbench::firmware;
namespace board = powbench::firmware::stm32g474;

// --- blocks from converter buffers ---

TEST_CASE("converter buffers become scans in the record's order") {
  // every converter counts in its own hundred, so that a mixed-up channel or rank shows
  constexpr std::size_t samples = 4;
  std::array<std::array<std::uint16_t, 2 * samples>, board::converters> buffers{};
  std::array<port::ConverterHalf, board::converters> halves;
  for (std::size_t c = 0; c < board::converters; ++c) {
    const std::uint8_t ranks = board::sequences[c].ranks;
    for (std::size_t i = 0; i < samples * ranks; ++i)
      buffers[c][i] = static_cast<std::uint16_t>(1000 * (c + 1) + 100 * (i % ranks) + i / ranks);
    halves[c] = {buffers[c].data(), ranks};
  }
  std::array<std::int16_t, samples * channel_count> scans{};
  port::assemble(halves, board::channel_sources, scans);
  const Block block{.scans = scans};
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(samples); ++i) {
    CHECK(block.at(i, Channel::pvdf_a) == 1000 + i - 32768);
    CHECK(block.at(i, Channel::pvdf_b) == 2000 + i - 32768);
    CHECK(block.at(i, Channel::coil_current) == 2 * (3000 + i) - 32768);
    CHECK(block.at(i, Channel::aux) == 2 * (3100 + i) - 32768);
    CHECK(block.at(i, Channel::coil_voltage) == 2 * (4000 + i) - 32768);
    CHECK(block.at(i, Channel::mains_voltage) == 2 * (4100 + i) - 32768);
    CHECK(block.at(i, Channel::laser) == 5000 + i);
    CHECK(block.at(i, Channel::contact_a) == 5100 + i);
  }
}

TEST_CASE("the converter's range fits the record's numbers") {
  constexpr port::ChannelSource wide{.shift = 0, .bipolar = true}, narrow{.shift = 1, .bipolar = true};
  constexpr port::ChannelSource one_sided{.shift = 1, .bipolar = false};
  // 16 or 8 samples of 12 bits: 65520 and 32760 at most; mid-range is zero
  CHECK(port::to_counts(0, wide) == -32768);
  CHECK(port::to_counts(32768, wide) == 0);
  CHECK(port::to_counts(65520, wide) == 32752);
  CHECK(port::to_counts(16384, narrow) == 0);
  CHECK(port::to_counts(32760, narrow) == 32752);
  CHECK(port::to_counts(0, one_sided) == 0);
  CHECK(port::to_counts(32760, one_sided) == 32760);
}

TEST_CASE("halves are taken in turn and a missed one is noticed") {
  using Due = port::HalfOrder::Due;
  port::HalfOrder order;
  CHECK(order.next(false, false) == Due::nothing);
  CHECK(order.next(true, false) == Due::first);
  CHECK(order.next(false, true) == Due::second);
  CHECK(order.next(true, false) == Due::first);
  CHECK(order.next(true, true) == Due::lost);  // the second half ended, and then the first again
  CHECK(order.next(false, true) == Due::second);
  CHECK(order.next(false, true) == Due::lost);  // the first half's flag never came
  CHECK(order.next(true, false) == Due::first);
}

TEST_CASE("the block queue keeps order, and drops the newest when the reader is behind") {
  port::BlockQueue<2, 4> queue;
  Random random(7);
  std::deque<std::int64_t> model;
  std::int64_t sample = 0;
  std::uint32_t dropped = 0;
  for (int i = 0; i < 10'000; ++i) {
    if (random.below(2) == 0) {
      auto* slot = queue.free_slot();
      CHECK((slot == nullptr) == (model.size() == 4));
      if (slot != nullptr) {
        slot->first_sample = sample;
        slot->scans.fill(static_cast<std::int16_t>(sample % 1000));
        queue.commit();
        model.push_back(sample);
      } else {
        ++dropped;
      }
      sample += 2;
    } else {
      const auto* slot = queue.front();
      REQUIRE((slot == nullptr) == model.empty());
      if (slot == nullptr) continue;
      CHECK(slot->first_sample == model.front());
      CHECK(slot->block().at(1, Channel::aux) == model.front() % 1000);
      queue.release();
      model.pop_front();
    }
  }
  CHECK(queue.dropped() == dropped);
  CHECK(dropped > 100);
}

TEST_CASE("any alarm reaches the controller as an open stop chain") {
  using port::Alarms;
  port::BlockQueue<2, 2> queue;
  for (const Alarms& alarms :
       {Alarms{}, Alarms{.stop_open = true}, Alarms{.supply_low = true}, Alarms{.cut_off = true},
        Alarms{.no_crystal = true}, Alarms{.relay_in = true}}) {
    auto* slot = queue.free_slot();
    REQUIRE(slot != nullptr);
    slot->alarms = alarms;
    queue.commit();
    const auto block = queue.front()->block();
    CHECK(block.emergency_stop == alarms.stop_open);
    CHECK(block.brown_out == alarms.supply_low);
    CHECK(block.comparator_trip == alarms.cut_off);
    CHECK(block.clock_failed == alarms.no_crystal);
    CHECK(block.relay_in == alarms.relay_in);
    queue.release();
  }
  CHECK_FALSE(Alarms{}.any());
  CHECK(Alarms{.cut_off = true}.any());
}

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

// --- serial line ---

TEST_CASE("on a serial line a read without a record is refused at once, and the line goes on") {
  test::Bench bench;
  port::UartLink link(bench.responder);
  test::Answers answers;
  const auto send = [&](std::string_view text) {
    answers.text.clear();
    link.take({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, answers);
    return answers.text;
  };
  CHECK(send("OPEN iio:device0 100 ff\n") == "0\n");
  // everything in one piece: the request that waits does not swallow the one behind it
  CHECK(send("READBUF iio:device0 1600\nTIMEOUT 100\n") == "-11\n0\n");
  CHECK(send("READBUF iio:device0 16") == "");
  CHECK(send("00\n") == "-11\n");
  CHECK(send("EXIT\nCLOSE iio:device0\n") == "-9\n");  // a new connection has no open buffer
  CHECK(send("WRITE iio:device1 hold_time_ms 3\n1") == "");
  link.line_error();
  CHECK(send("TIMEOUT 5\n") == "0\n");  // not taken for the rest of the payload
  CHECK(link.line_errors() == 1);

  bench.run(0.3);
  bench.ask("WRITE iio:device1 arm 3\n1 t");
  bench.run(0.3);
  bench.ask("WRITE iio:device1 fire 3\n1 t");
  CHECK(send("OPEN iio:device0 100 01\nREADBUF iio:device0 200\n") == "0\n-11\n");
  bench.run(0.4);
  const std::string record = send("READBUF iio:device0 200\n");
  CHECK(record.substr(0, 13) == "200\n00000001\n");
  CHECK(record.size() == 13 + 200);
}

TEST_CASE("attribute functions are called with the controller kept still") {
  static int depth = 0, calls = 0;
  test::Bench bench;
  bench.context.lock = [](bool held) {
    depth += held ? 1 : -1;
    calls += held ? 1 : 0;
    CHECK((depth == 0 || depth == 1));
  };
  depth = calls = 0;
  bench.ask("READ iio:device1 state\n");
  CHECK(calls == 1);
  bench.ask("WRITE iio:device1 hold_time_ms 2\n50");
  CHECK(calls == 2);
  bench.ask("READ iio:device1\n");
  CHECK(calls > 10);
  CHECK(depth == 0);
}

TEST_CASE("a circular buffer is read to the end and from the start") {
  std::array<std::uint8_t, 8> ring{};
  std::iota(ring.begin(), ring.end(), std::uint8_t{0});
  port::RingReader reader;
  Random random(5);
  std::size_t total = 0, written = 0;
  for (int i = 0; i < 1000; ++i) {
    written += random.below(8);  // never a whole turn ahead
    for (int piece = 0; piece < 2; ++piece)
      for (const std::uint8_t byte : reader.fresh(ring, written % ring.size()))
        CHECK(byte == total++ % ring.size());
    CHECK(total == written);
  }
}

TEST_CASE("the watchdog is fed only when every part has moved") {
  using port::Progress;
  Progress progress;
  CHECK_FALSE(progress.may_feed());
  progress.moved(Progress::samples);
  progress.moved(Progress::control);
  progress.moved(Progress::main_loop);
  CHECK_FALSE(progress.may_feed());
  progress.moved(Progress::background);
  CHECK(progress.may_feed());
  CHECK_FALSE(progress.may_feed());  // once for each round
}

TEST_CASE("an abort is found among the bytes of a line, and nothing else is one") {
  const auto found = [](std::string_view text) {
    port::AbortScan scan;
    int count = 0;
    for (const char c : text) count += scan.take(static_cast<std::uint8_t>(c)) ? 1 : 0;
    return count;
  };
  CHECK(found("WRITE contactor-ctl abort 1\r\n1") == 1);
  CHECK(found("write iio:device1 abort 2\n1\n") == 1);
  CHECK(found("VERSION\r\nREAD contactor-ctl state\r\nWRITE iio:device1 abort 1\r\n1VERSION\r\n") == 1);
  CHECK(found("WRITE contactor-ctl abort 1\r\n0") == 0);
  CHECK(found("WRITE contactor-ctl arm 1\r\n1") == 0);
  CHECK(found("READ contactor-ctl abort \r\n1") == 0);
  CHECK(found("WRITE contactor-ctl abort 1") == 0);
  // behind the value of another request, which has no line end
  CHECK(found("WRITE contactor-ctl fire 3\r\n1 tWRITE contactor-ctl abort 1\r\n1") == 1);
  CHECK(found("WRITE contactor-ctl fire 50\r\n1 " + std::string(48, 'k') +
              "WRITE contactor-ctl abort 1\r\n1") == 1);
  // a line too long for any request, and one behind it
  CHECK(found(std::string(60, 'x') + " abort 1\n1") == 0);
  CHECK(found(std::string(60, 'x') + "\nWRITE contactor-ctl abort 1\n1") == 1);
}

// --- front end ---

TEST_CASE("the board's configuration agrees with its circuit") {
  constexpr ControllerConfig c = board::controller_config();
  // 2 A are 1.5 V of 3.3 V in 16 bits
  CHECK(2e3 / (1e-12 * static_cast<double>(c.calibration[index(Channel::coil_current)].scale_pico)) ==
        Approx(65536 * 1.5 / 3.3).epsilon(1e-6));
  // 600 V likewise
  CHECK(600e3 / (1e-12 * static_cast<double>(c.calibration[index(Channel::mains_voltage)].scale_pico)) ==
        Approx(65536 * 1.5 / 3.3).epsilon(1e-6));
  // 100 N on the film: 2.1 nC on 3.3 nF
  const double kilopascal = 100.0 / 25e-6 / 1e3;
  const double counts =
      kilopascal / (1e-12 * static_cast<double>(c.calibration[index(Channel::pvdf_a)].scale_pico));
  CHECK(counts / 65536 * 3.3 == Approx(2.1e-9 / 3.3e-9).epsilon(1e-6));
  CHECK(static_cast<double>(c.calibration[index(Channel::pvdf_a)].corner_microhertz) * 1e-6 ==
        Approx(0.48229).epsilon(1e-4));
  // software trips before hardware, and both inside the range
  CHECK(c.interlocks.overcurrent_counts < 1.9 * 0.75 / 3.3 * 65536);
  CHECK(board::comparator_level(board::cut_off_ampere) < 4096);
  CHECK(board::comparator_level(board::cut_off_ampere) + board::comparator_level(-board::cut_off_ampere) ==
        4096);
  // 16 samples of 19 cycles at 42.5 MHz: the first of two inputs is taken 3.58 us before the second
  const auto delay = [&](Channel x) { return c.calibration[index(x)].delay_ns; };
  CHECK(delay(Channel::coil_voltage) - delay(Channel::mains_voltage) ==
        Approx(8 * 19 / 42.5e6 * 1e9).margin(1));
  // the pre-trigger and the record fit the memory that the linker script gives
  CHECK(c.record_length * 16 < 110'000);
  CHECK(c.pretrigger < c.record_length);
}
