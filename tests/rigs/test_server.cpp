#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "rigs/iiod_server.h"
#include "rigs/registry.h"
#include "rigs/rig.h"
#include "rigs/sensors.h"
#include "rigs/sim_world.h"
#include "tests/rigs/raw_client.h"
#include "tests/waiting.h"

using namespace powbench;
using namespace powbench::rigs;

TEST_CASE("an energised coil is switched off when its last client hangs up", "[rig][fault]") {
  LocalRig server({}, {});
  {
    test::RawClient client(server.address());
    CHECK(client.own() == "14");
    CHECK(client.command("iio:device1 hold_time_ms", "10000") == "7");
    CHECK(client.command("iio:device1 OUTPUT phase0 raw", "9000") == "6");
    CHECK(client.command("iio:device1 arm", "1") == "3");
    CHECK(client.command("iio:device1 fire", "1") == "3");
  }
  // 10 s of holding are far more than the heartbeat allows; a client that only looks is none
  test::RawClient client(server.address());
  test::wait_until("the end of the shot", [&] { return client.read("iio:device1 state") != "firing"; });
  CHECK(client.read("iio:device1 state") == "fault");
  CHECK(client.read("iio:device1 fault").find("host_lost") != std::string::npos);
  CHECK(client.read("iio:device1 last_error").find("silent for 250 ms") != std::string::npos);
  CHECK(client.own() == "14");
  CHECK(client.command("iio:device1 fire", "1").starts_with("-"));  // latched
  CHECK(client.command("iio:device1 abort", "1") == "3");
  CHECK(client.read("iio:device1 state") == "idle");
  CHECK(client.command("iio:device1 arm", "1") == "3");
}

TEST_CASE("a client that stays holds the coil for all of the time asked for", "[rig][fault]") {
  LocalRig server({}, {});
  test::RawClient client(server.address());
  client.own();
  client.command("iio:device1 hold_time_ms", "1000");  // four times the heartbeat's time
  client.command("iio:device1 arm", "1");
  client.command("iio:device1 fire", "1");
  std::string state;
  test::wait_until("the end of the shot",
                   [&] { return (state = client.read("iio:device1 state")) != "firing"; });
  CHECK(state == "captured");
}

TEST_CASE("when all places are taken, the client that has been silent makes room, but never the owner",
          "[rig]") {
  BoardOptions board;
  board.idle = std::chrono::milliseconds(0);
  LocalRig server({}, {}, board);
  std::vector<std::unique_ptr<test::RawClient>> clients;
  for (unsigned i = 0; i < firmware::Bench::max_connections; ++i) {
    clients.push_back(std::make_unique<test::RawClient>(server.address()));
    CHECK(clients.back()->read("iio:device1 state") == "idle");
  }
  CHECK(clients[0]->own() == "14");
  CHECK(clients[1]->read("iio:device1 state") == "idle");
  test::RawClient late(server.address());
  CHECK(late.write("iio:device1 abort", "1") == "1");
  CHECK(clients[2]->read("iio:device1 state") == "(gone)");  // silent the longest
  CHECK(clients[0]->read("iio:device1 state") == "idle");
  CHECK(clients[1]->read("iio:device1 state") == "idle");
}

TEST_CASE("a stop gets a place among clients that never fall silent, and the owner keeps his", "[rig]") {
  BoardOptions board;
  board.stay = std::chrono::milliseconds(0);
  LocalRig server({}, {}, board);
  std::vector<std::unique_ptr<test::RawClient>> clients;
  for (unsigned i = 0; i < firmware::Bench::max_connections; ++i) {
    clients.push_back(std::make_unique<test::RawClient>(server.address()));
    CHECK(clients.back()->read("iio:device1 state") == "idle");
  }
  clients.back()->own();
  // who sets something is not the owner for that
  CHECK(clients[14]->write("iio:device1 hold_time_ms", "50") == "-16");
  for (auto& client : clients) CHECK(client->read("iio:device1 state") == "idle");
  test::RawClient late(server.address());
  CHECK(late.write("iio:device1 abort", "1") == "1");
  CHECK(clients[14]->read("iio:device1 state") == "(gone)");  // came last but for the owner
  for (unsigned i : {0U, 1U, 13U, 15U}) CHECK(clients[i]->read("iio:device1 state") == "idle");
}

TEST_CASE("clients that speak keep their places", "[rig]") {
  BoardOptions board;
  board.stay = std::chrono::hours(1);
  LocalRig server({}, {}, board);
  std::vector<std::unique_ptr<test::RawClient>> clients;
  for (unsigned i = 0; i < firmware::Bench::max_connections; ++i) {
    clients.push_back(std::make_unique<test::RawClient>(server.address()));
    CHECK(clients.back()->read("iio:device1 state") == "idle");
  }
  test::RawClient late(server.address());
  CHECK(late.line() == "-16");
  CHECK(late.line().find("all connections of this rig are taken") == 0);
  for (auto& client : clients) CHECK(client->read("iio:device1 state") == "idle");
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

/// One channel of the last record at one scan, counts.
std::int32_t recorded(SimWorld& world, std::int64_t scan, Channel channel) {
  std::uint8_t bytes[2 * channel_count];
  const auto& recorder = world.board().native()->controller().recorder();
  recorder.copy(static_cast<std::uint64_t>(scan), 1, (1U << channel_count) - 1, bytes);
  const std::size_t at = 2 * index(channel);
  return static_cast<std::int16_t>(bytes[at] | bytes[at + 1] << 8);
}

void ask(SimWorld& world, const std::string& request) {
  world.board().feed(0, {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});
  world.notice_commands();
}

void shoot(SimWorld& world, int centi_degrees) {
  const std::string angle = std::to_string(centi_degrees) + " t";
  ask(world, "WRITE iio:device1 lease 9\r\nt 3600000");
  ask(world, "WRITE iio:device1 OUTPUT phase0 raw " + std::to_string(angle.size()) + "\r\n" + angle);
  ask(world, "WRITE iio:device1 arm 3\r\n1 t");
  ask(world, "WRITE iio:device1 fire 3\r\n1 t");
  while (world.busy()) world.run(0.010);
  REQUIRE(world.board().native()->controller().recorder().complete());
}

/// Longest time without coil current in the last record while the gate was on, samples.
int longest_silence(SimWorld& world, std::int32_t no_current) {
  const std::int64_t on = world.board().native()->controller().recorder().fire_sample();
  int run = 0, longest = 0;
  for (std::int64_t i = on; i < on + 9900; ++i) {
    run = std::abs(recorded(world, i, Channel::coil_current)) > no_current ? 0 : run + 1;
    longest = std::max(longest, run);
  }
  return longest;
}

}  // namespace

TEST_CASE("the contact can be asked to touch at an angle of the mains", "[rig][fire]") {
  for (const int switched : {10, 75, 130, 200, 290}) {
    // a shot whose coil is switched at an angle tells the closing time that belongs to it ...
    SimWorld world({}, {});
    world.board().publish({.seed = 5}, {});
    shoot(world, 100 * switched);
    const std::int64_t closing_ns = world.truth().touch_ns;
    REQUIRE(closing_ns != firmware::PlantTruth::none);
    // ... with which the contact is asked to touch where it then did, and the coil finds its own angle
    const std::string delay = std::to_string(closing_ns / 1000) + " t";
    ask(world, "WRITE iio:device1 touch_delay_us " + std::to_string(delay.size()) + "\r\n" + delay);
    const int wanted = static_cast<int>((100 * switched + closing_ns * 18 / 10'000) % 36'000);  // 50 Hz
    world.board().publish({.seed = 5}, {});
    shoot(world, wanted);
    REQUIRE(world.truth().touch_ns != firmware::PlantTruth::none);
    // the mains as recorded: the last rising zero crossing ahead of the touch
    const auto& recorder = world.board().native()->controller().recorder();
    const firmware::Tick edge = recorder.edge();
    const double touch = static_cast<double>(edge.sample - recorder.first_sample()) +
                         edge.fraction / 65536.0 + static_cast<double>(world.truth().touch_ns) * 1e-9 * 100e3;
    auto scan = static_cast<std::int64_t>(touch);
    const auto mains = [&](std::int64_t i) { return recorded(world, i, Channel::mains_voltage); };
    while (!(mains(scan) < 0 && mains(scan + 1) >= 0)) --scan;
    const double crossing =
        static_cast<double>(scan) - mains(scan) / static_cast<double>(mains(scan + 1) - mains(scan));
    const double error = std::remainder(360.0 * (touch - crossing) / 2000.0 - wanted / 100.0, 360.0);
    INFO("asked for " << wanted / 100.0 << " deg, " << delay << " us after the edge: error " << error
                      << " deg");
    CHECK(std::fabs(error) < 1.0);
  }
}

TEST_CASE("the coil's current is never away for a fifth of the time that makes a fault", "[rig][fault]") {
  const SimRigConfig config;
  const auto scales = channel_scales(config.sensors, config.sample_rate);
  const double scale = scales[index(Channel::coil_current)].si_per_count;
  const auto no_current = static_cast<std::int32_t>(std::lrint(0.006 / scale));
  int longest = 0;
  for (const std::int64_t volts : {195, 253})
    for (const std::int64_t hertz : {50, 60}) {
      SimWorld world(config, {});
      for (int degrees = 0; degrees < 360; degrees += 30) {
        world.board().publish(
            {.supply_millivolts = 1000 * volts, .mains_millihertz = 1000 * hertz, .seed = degrees + 1}, {});
        shoot(world, 100 * degrees);
        longest = std::max(longest, longest_silence(world, no_current));
      }
    }
  CHECK(longest > 10);  // an alternating current passes through zero
  CHECK(longest < 96);  // of 480
}
