#include <catch2/catch.hpp>
#include <string>

#include "core/random.h"
#include "firmware/bench_devices.h"
#include "firmware/iiod/responder.h"
#include "tests/firmware/shot_watch.h"

using namespace powbench;
using bench::FaultBench;
using test::ShotWatch;

/// Commands in any order, by call and by wire, with causes that come and go and time that passes or not.

namespace {

struct Nowhere final : firmware::iiod::ByteSink {
  void put(std::span<const std::uint8_t>) override {}
};

struct Host {
  FaultBench bench;
  firmware::BenchDevices devices{bench.controller};
  std::array<const firmware::iiod::Device*, 3> list{&devices.daq(), &devices.control(), &devices.trigger()};
  firmware::iiod::Context context{.description = "bench", .attributes = {}, .devices = list};
  firmware::iiod::Responder responder{context};
  firmware::iiod::Connection connection;

  void say(std::string_view text) {
    Nowhere out;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
    responder.feed(connection, {bytes, text.size()}, out);
    if (connection.status() == firmware::iiod::Connection::Status::pending)
      responder.expire(connection, firmware::iiod::eagain, out);
    if (connection.status() == firmware::iiod::Connection::Status::closed) connection = {};
  }
};

/// A whole request that changes something, or a fragment that must change nothing or be completed by the next.
void speak(Host& host, ShotWatch& watch, Random& random) {
  static const std::array<std::string, 19> lines{"WRITE iio:device1 arm 3\n1 t",
                                                 "WRITE iio:device1 arm 3\n0 t",
                                                 "WRITE iio:device1 fire 3\n1 t",
                                                 "WRITE trigger0 trigger_now 3\n1 t",
                                                 "WRITE iio:device1 abort 1\n1",
                                                 "WRITE iio:device1 hold_time_ms 4\n20 t",
                                                 "WRITE iio:device1 hold_time_ms 7\n10001 t",
                                                 "WRITE iio:device1 OUTPUT phase0 raw 6\n9000 t",
                                                 "WRITE iio:device1 OUTPUT phase0 raw 5\nnan t",
                                                 "WRITE iio:device1 fire 3\n2 t",
                                                 "WRITE iio:device1 fi",
                                                 "re 1\n1",
                                                 "1\n",
                                                 "READ iio:device1 state\n",
                                                 "WRITE iio:device1 lease 9\nt 3600000",
                                                 "WRITE iio:device1 lease 5\nt 100",
                                                 "WRITE iio:device1 lease 3\nt 0",
                                                 "WRITE iio:device1 lease 5\nx 100",
                                                 "WRITE iio:device1 fire 3\n1 x"};
  const bool armed = host.bench.fire_control().state() == firmware::State::armed;
  host.say(lines[random.below(lines.size())]);
  if (armed && host.bench.fire_control().state() == firmware::State::firing) watch.fire_accepted(host.bench);
  watch.look(host.bench);
}

void break_something(FaultBench& b, Random& random) {
  auto& causes = b.world.causes;
  switch (random.below(6)) {
    case 0:
    case 1:
    case 2:
      causes = {};
      break;
    case 3:
      causes.mains = random.uniform();
      break;
    case 4:
      (random.below(2) ? causes.drop : causes.overrun) = true;
      break;
    default:
      test::cause(causes, static_cast<int>(random.below(test::cause_count))) = true;
      break;
  }
}

void storm(int commands, std::uint64_t seed) {
  Host host;
  auto& b = host.bench;
  ShotWatch watch;
  Random random(seed);
  b.fire_control().boot({.cause = firmware::ResetCause::pin, .survivor = &b.survivor});
  const auto pass = [&](std::uint64_t blocks) {
    for (; blocks > 0; --blocks) {
      b.step();
      watch.look(b);
    }
  };
  for (int i = 0; i < commands; ++i) {
    if (random.below(2) == 0)
      test::command(b, watch, static_cast<int>(random.below(test::command_count)));
    else
      speak(host, watch, random);
    const auto what = random.below(400);
    if (what < 4) break_something(b, random);
    if (what == 5) b.reset(firmware::ResetCause::pin), watch.look(b);
    if (what == 6) b.crash(), watch.look(b);
    if (what == 7) {
      // now and then a host that knows what it wants, with a storm to follow at any moment of the shot
      b.world.causes = {};
      pass(100);
      b.fire_control().abort();
      watch.look(b);
      pass(1600);
      b.fire_control().abort();
      b.fire_control().arm();
      watch.look(b);
      pass(1200);
      test::command(b, watch, 2);
      pass(random.below(2500));
    } else if (random.below(2) == 0) {
      pass(random.below(8));
    }
  }
  INFO(b.world.ons << " times energised after " << watch.fires() << " accepted fires, longest "
                   << b.world.on_time_most << " samples");
  CHECK(b.world.ons > static_cast<std::uint32_t>(commands / 2000));
  CHECK(b.world.ons <= watch.fires());
  CHECK(b.world.on_time_most <= 100 * FaultBench::rate / 1000);
  WARN(commands << " commands: " << b.world.ons << " times energised after " << watch.fires()
                << " accepted fires, longest " << b.world.on_time_most << " samples");
}

}  // namespace

TEST_CASE("random commands among faults never energise the coil on their own, nor too long", "[fault]") {
  storm(100'000, 11);
}

TEST_CASE("a million random commands among faults never energise the coil on their own, nor too long",
          "[.slow]") {
  storm(1'000'000, 12);
}
