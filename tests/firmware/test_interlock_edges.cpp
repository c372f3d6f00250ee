#include <catch2/catch.hpp>

#include <functional>

#include "bench/fault_bench.h"

/// Each interlock alone, on both sides of its limit: what a wrong sign, bound or factor would let through.

using namespace powbench;
using namespace powbench::firmware;

namespace {

/// A quiet bench, block by block; `set` changes scans, `change` the block.
struct Stream {
  Stream() { reset(); }
  void reset() {
    set = [](std::int64_t, const auto&) {};
    change = [](Block&) {};
  }
  Fault step() {
    scans.assign(10 * channel_count, 0);
    for (std::int64_t k = 0; k < 10; ++k) {
      const auto put = [&](Channel c, std::int64_t v) {
        scans[static_cast<std::size_t>(k) * channel_count + index(c)] = static_cast<std::int16_t>(v);
      };
      put(Channel::mains_voltage, 10'000);
      put(Channel::contact_a, 19'000);
      put(Channel::aux, (first + k) % 1000);
      set(first + k, put);
    }
    Block block{.first_sample = first, .scans = scans, .owner_present = true, .counter = counter++};
    change(block);
    first = block.first_sample + block.samples();
    return interlocks.check(block, gate);
  }
  /// The first fault within so many samples, and the end of the block that found it.
  Fault run(std::int64_t samples) {
    for (const std::int64_t end = first + samples; first < end;)
      if (const Fault found = step(); found != Fault::none) return found;
    return Fault::none;
  }

  InterlockConfig config = bench::FaultBench::make_config().interlocks;
  Interlocks interlocks{config};
  Interlocks::GateView gate{};
  std::vector<std::int16_t> scans;
  std::int64_t first = 0, counter = 0;
  std::function<void(std::int64_t, const std::function<void(Channel, std::int64_t)>&)> set;
  std::function<void(Block&)> change;
};

}  // namespace

TEST_CASE("a sample beyond the trip level and one at it are not two", "[fault][edge]") {
  Stream s;
  s.set = [](std::int64_t n, const auto& put) {
    if (n == 101 || n == 102) put(Channel::coil_current, n == 101 ? 20'001 : 20'000);
  };
  CHECK(s.run(500) == Fault::none);
}

TEST_CASE("current with the gate off: a short one is none, one with pauses is one", "[fault][edge]") {
  Stream s;
  s.set = [](std::int64_t n, const auto& put) {
    if (n >= 5000 && n < 5100) put(Channel::coil_current, 1000);
  };
  CHECK(s.run(10'000) == Fault::none);

  Stream paused;  // away for 10 ms at a time: less than half of the 25 ms
  paused.set = [](std::int64_t n, const auto& put) {
    if (n >= 5000 && (n - 5000) % 1500 < 500) put(Channel::coil_current, 1000);
  };
  CHECK(paused.run(12'000) == Fault::coil_stuck_on);
  CHECK(paused.first > 7500);
  CHECK(paused.first <= 9100);

  Stream apart;  // away for 13 ms: each is a current of its own
  apart.set = [](std::int64_t n, const auto& put) {
    if (n >= 5000 && (n - 5000) % 1800 < 500) put(Channel::coil_current, 1000);
  };
  CHECK(apart.run(12'000) == Fault::none);
}

TEST_CASE("each way of losing samples is noticed by itself", "[fault][edge]") {
  const auto found = [](const std::function<void(Stream&)>& lose) {
    Stream s;
    CHECK(s.run(200) == Fault::none);
    lose(s);
    return s.step();
  };
  CHECK(found([](Stream&) {}) == Fault::none);
  CHECK(found([](Stream& s) { s.change = [](Block& b) { b.first_sample += 3; }; }) == Fault::samples_lost);
  CHECK(found([](Stream& s) { ++s.counter; }) == Fault::samples_lost);
  CHECK(found([](Stream& s) { --s.counter; }) == Fault::samples_lost);
  CHECK(found([](Stream& s) { s.change = [](Block& b) { b.overrun = true; }; }) == Fault::samples_lost);
  CHECK(found([](Stream& s) {  // the same block again
          s.set = [](std::int64_t n, const auto& put) { put(Channel::aux, (n - 10) % 1000); };
        }) == Fault::samples_lost);
  CHECK(found([](Stream& s) {  // one scan, ten times
          s.set = [](std::int64_t, const auto& put) { put(Channel::aux, 777); };
        }) == Fault::samples_lost);
}

TEST_CASE("mains is there at either sign, and missing for 16 ms it is lost", "[fault][edge]") {
  Stream negative;
  negative.set = [](std::int64_t, const auto& put) { put(Channel::mains_voltage, -3201); };
  CHECK(negative.run(5000) == Fault::none);
  Stream at_level;
  at_level.set = [](std::int64_t n, const auto& put) { put(Channel::mains_voltage, n < 1000 ? 3201 : 3200); };
  CHECK(at_level.run(5000) == Fault::mains_lost);
  CHECK(at_level.first == 2600);  // the last one seen is 999, and 1600 are allowed
}

TEST_CASE("laser and contact are implausible behind 5 ms, and only with the gate off", "[fault][edge]") {
  const auto found_at = [](Channel channel, int value, int contact) {
    Stream s;
    s.set = [=](std::int64_t n, const auto& put) {
      if (n < 1000) return;
      put(Channel::contact_a, contact);
      put(channel, value);
    };
    return s.run(3000) == Fault::sensor_implausible ? s.first : -1;
  };
  constexpr int open = 19'000, closed = 0;
  CHECK(found_at(Channel::laser, -1001, open) == 1500);
  CHECK(found_at(Channel::laser, -1000, open) == -1);
  CHECK(found_at(Channel::laser, 20'001, closed) == 1500);
  CHECK(found_at(Channel::laser, 20'000, closed) == -1);
  CHECK(found_at(Channel::laser, 14'001, open) == 1500);  // travelled, and not closed
  CHECK(found_at(Channel::laser, 14'000, open) == -1);
  CHECK(found_at(Channel::laser, 1999, closed) == 1500);  // at rest, and closed
  CHECK(found_at(Channel::laser, 2000, closed) == -1);

  Stream energised;
  energised.gate = {.on = true};
  energised.set = [](std::int64_t, const auto& put) {
    put(Channel::coil_current, 1000);
    put(Channel::laser, 25'000);
  };
  CHECK(energised.run(3000) == Fault::none);
  CHECK((energised.interlocks.marks() & bit(Mark::laser_range)) != 0);
}

TEST_CASE("a contact at the level that proves it open is not open", "[fault][edge]") {
  for (const int above : {0, 1}) {
    Stream s;
    s.set = [=](std::int64_t, const auto& put) {
      put(Channel::contact_a, bench::FaultBench::make_config().interlocks.contact_open_counts + above);
      put(Channel::laser, 8000);
    };
    CHECK(s.run(12'000) == (above ? Fault::none : Fault::contact_welded));
    CHECK(s.interlocks.contact_open(s.first) == (above != 0));
    if (above == 0) CHECK(s.first == 10'010);
  }
}

TEST_CASE("the relay is given 100 ms to follow, either way, and once more after each command",
          "[fault][edge][relay]") {
  for (const bool told : {true, false}) {
    Stream s;
    s.change = [=](Block& b) { b.relay_in = b.first_sample < 20'000 ? told : !told; };
    s.gate = {.relay = told, .relay_since = 0};
    CHECK(s.run(40'000) == (told ? Fault::relay_open : Fault::relay_welded));
    CHECK(s.first == 30'010);
    Stream late;  // told something else at 25000: it has until 35000
    late.change = [&late, told](Block& b) {
      b.relay_in = !told;
      late.gate = b.first_sample < 25'000 ? Interlocks::GateView{.relay = !told}
                                          : Interlocks::GateView{.relay = told, .relay_since = 25'000};
    };
    CHECK(late.run(60'000) == (told ? Fault::relay_open : Fault::relay_welded));
    CHECK(late.first == 35'010);
  }
}

TEST_CASE("samples that come back just behind the end of the hold time are told from lost ones",
          "[fault][edge]") {
  bench::FaultBench b;
  b.run(4000);
  b.fire_control().set_hold_time_ms(40);
  b.arm();
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  while (!b.world.pin) b.step();
  const std::int64_t off = b.world.off_by.sample_at_or_after();
  while (b.world.next < off - 20) b.step();
  b.world.causes.blocks_stop = true;
  while (b.world.next < off + 20) b.step();
  b.world.causes.blocks_stop = false;
  b.step();
  CHECK(b.fire_control().fault() == Fault::on_time_exceeded);
}

TEST_CASE("a bench that was never energised does not settle, whatever its contact says", "[fire][edge]") {
  bench::FaultBench b;
  b.world.causes.contact_stuck = true;
  b.run(200);
  CHECK_FALSE(b.fire_control().settling());
}

TEST_CASE("arm gives the mains its time anew", "[fire][edge]") {
  bench::FaultBench b;
  b.run(4000);
  b.world.causes.mains = 0;
  b.run(10'000);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  const std::int64_t armed = b.world.next;
  b.run(1600);
  CHECK(b.fire_control().fault() == Fault::none);
  b.run(20);
  CHECK(b.fire_control().fault() == Fault::mains_lost);
  CHECK(b.world.next - armed <= 1620);
}

TEST_CASE("a shot is over only when it has been quiet for its time", "[fire][edge]") {
  bench::FaultBench b;
  b.run(4000);
  b.fire_control().set_hold_time_ms(60);
  b.arm();
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  while (b.fire_control().state() == State::firing) b.step();
  REQUIRE(b.fire_control().state() == State::captured);
  CHECK(b.world.next - b.world.pin_off_since > b.controller.config().fire.quiet_samples);
}
