#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <thread>

#include "rigs/iiod_server.h"
#include "rigs/registry.h"
#include "rigs/rig.h"
#include "rigs/sensors.h"
#include "rigs/sim_world.h"
#include "tests/rigs/raw_client.h"

using namespace powbench;
using namespace powbench::rigs;
using namespace std::chrono_literals;

TEST_CASE("an energised coil is switched off when its last client hangs up", "[rig][fault]") {
  LocalRig server({}, {});
  // The heartbeat counts in virtual time, which passes as fast as it can be computed: a client that looks too
  // early is a new heartbeat. Then look later.
  std::string state, fault;
  for (auto pause = 500ms; pause < 20s; pause *= 2) {
    {
      test::RawClient client(server.address());
      CHECK(client.write("iio:device1 abort", "1") == "1");
      CHECK(client.write("iio:device1 hold_time_ms", "10000") == "5");
      CHECK(client.write("iio:device1 arm", "1") == "1");
      CHECK(client.write("iio:device1 OUTPUT phase0 raw", "9000") == "4");
      CHECK(client.write("iio:device1 fire", "1") == "1");
    }
    std::this_thread::sleep_for(pause);
    test::RawClient client(server.address());
    state = client.read("iio:device1 state");
    fault = client.read("iio:device1 fault");
    if (state == "fault") {
      CHECK(fault.find("host_lost") != std::string::npos);
      CHECK(client.read("iio:device1 last_error").find("silent for 250 ms") != std::string::npos);
      CHECK(client.write("iio:device1 fire", "1").starts_with("-"));  // latched
      CHECK(client.write("iio:device1 abort", "1") == "1");
      CHECK(client.read("iio:device1 state") == "idle");
      CHECK(client.write("iio:device1 arm", "1") == "1");
      return;
    }
    REQUIRE(state == "firing");  // not captured: 10 s are far more than the heartbeat allows
  }
  FAIL("the coil stays on without a client: state " << state << ", fault " << fault);
}

TEST_CASE("a client that stays holds the coil for all of the time asked for", "[rig][fault]") {
  LocalRig server({}, {});
  test::RawClient client(server.address());
  client.write("iio:device1 hold_time_ms", "1000");  // four times the heartbeat's time
  client.write("iio:device1 arm", "1");
  client.write("iio:device1 fire", "1");
  std::string state;
  for (int i = 0; i < 1000 && (state = client.read("iio:device1 state")) == "firing"; ++i)
    std::this_thread::sleep_for(5ms);
  CHECK(state == "captured");
}

TEST_CASE("no two starts of a simulated rig have the same boot_id", "[rig]") {
  std::set<std::string> seen;
  for (int i = 0; i < 3; ++i) seen.insert(open("sim:", {}, {})->info().boot_id);
  CHECK(seen.size() == 3);
  for (const std::string& id : seen) CHECK(id.size() == 16);
  // with an identity of its own a board keeps it
  LocalRig server({}, {}, {BoardOptions::Kind::native, false, "start-7"});
  CHECK(open("ip:" + server.address(), {}, {})->info().boot_id == "start-7");
}

namespace {

/// Longest time without coil current in the last record while the gate was on, samples.
int longest_silence(SimWorld& world, std::int32_t no_current) {
  const auto& recorder = world.board().native()->controller().recorder();
  int run = 0, longest = 0;
  for (std::int64_t i = recorder.fire_sample(); i < recorder.fire_sample() + 9900; ++i) {
    std::uint8_t scan[2 * channel_count];
    recorder.copy(static_cast<std::uint64_t>(i), 1, (1U << channel_count) - 1, scan);
    const std::size_t at = 2 * index(Channel::coil_current);
    const auto value = static_cast<std::int16_t>(scan[at] | scan[at + 1] << 8);
    run = std::abs(value) > no_current ? 0 : run + 1;
    longest = std::max(longest, run);
  }
  return longest;
}

}  // namespace

TEST_CASE("the coil's current is never away for a fifth of the time that makes a fault", "[rig][fault]") {
  const SimRigConfig config;
  const auto scales = channel_scales(config.sensors, config.sample_rate);
  const double scale = scales[index(Channel::coil_current)].si_per_count;
  const auto no_current = static_cast<std::int32_t>(std::lrint(0.006 / scale));
  int longest = 0;
  for (const std::int64_t volts : {195, 253})
    for (const std::int64_t hertz : {50, 60}) {
      SimWorld world(config, {});
      const auto ask = [&](const std::string& request) {
        world.board().feed(0, {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});
        world.notice_commands();
      };
      for (int degrees = 0; degrees < 360; degrees += 30) {
        world.board().publish(
            {.supply_millivolts = 1000 * volts, .mains_millihertz = 1000 * hertz, .seed = degrees + 1}, {});
        const std::string angle = std::to_string(100 * degrees);
        ask("WRITE iio:device1 arm 1\r\n1");
        ask("WRITE iio:device1 OUTPUT phase0 raw " + std::to_string(angle.size()) + "\r\n" + angle);
        ask("WRITE iio:device1 fire 1\r\n1");
        while (world.busy()) world.run(0.010);
        REQUIRE(world.board().native()->controller().recorder().complete());
        longest = std::max(longest, longest_silence(world, no_current));
      }
    }
  CHECK(longest > 10);  // an alternating current passes through zero
  CHECK(longest < 96);  // of 480
}
