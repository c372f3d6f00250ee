#include "rigs/exposure.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "rigs/iiod_server.h"
#include "tests/rigs/raw_client.h"

using namespace powbench;
using namespace powbench::rigs;

TEST_CASE("a rig is served to the network only when that is asked for, with a secret", "[link]") {
  for (const char* inside : {"127.0.0.7", "127.255.0.1", "::1"}) CHECK_NOTHROW(check_exposure(inside, {}));
  for (const char* outside : {"0.0.0.0", "192.0.2.7", "::", "2001:db8::1"}) {
    CHECK_THROWS_WITH(check_exposure(outside, {}), Catch::Contains("--open-to-network"));
    CHECK_THROWS_WITH(check_exposure(outside, {true, ""}), Catch::Contains("POWBENCH_RIG_SECRET"));
    CHECK_THROWS_WITH(check_exposure(outside, {true, "short"}), Catch::Contains("8 to 30"));
    CHECK_THROWS_WITH(check_exposure(outside, {true, "with a blank"}), Catch::Contains("8 to 30"));
    CHECK_NOTHROW(check_exposure(outside, {true, "open-sesame"}));
  }
  CHECK_THROWS_AS(check_exposure("somewhere", {true, "open-sesame"}), std::invalid_argument);
}

TEST_CASE("with a secret nobody claims the rig without it, and everybody may look and stop", "[link]") {
  BoardOptions board;
  board.secret = token_prefix({true, "open-sesame"});
  LocalRig server({}, {}, board);
  test::RawClient c(server.address());
  CHECK(c.write("iio:device1 lease", "t 1000") == "-1");
  CHECK(c.write("iio:device1 arm", "1") == "-16");
  CHECK(c.read("iio:device1 state") == "idle");
  CHECK(c.write("iio:device1 lease", "open-sesame.t 1000 anna") == "23");
  CHECK(c.write("iio:device1 arm", "1 open-sesame.t") == "15");
  test::RawClient other(server.address());
  CHECK(other.write("iio:device1 abort", "1") == "1");
  CHECK(c.read("iio:device1 state") == "idle");
}

TEST_CASE("one client too many is told so, and a place that is not used falls free", "[link]") {
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
  CHECK(late.line().find("connections of this rig are taken") != std::string::npos);
  CHECK(late.line() == "(gone)");
  // a request that is never finished costs the connection
  clients.back()->say("READ iio:dev");
  CHECK(clients.back()->line() == "(gone)");
  test::RawClient next(server.address());
  CHECK(next.read("iio:device1 state") == "idle");
}

TEST_CASE("each client has its own time-out, and none may pile up requests", "[link]") {
  LocalRig server({}, {});
  test::RawClient patient(server.address()), hasty(server.address());
  CHECK(patient.ask("TIMEOUT 3600000") == "0");
  CHECK(hasty.ask("TIMEOUT 1") == "0");
  CHECK(patient.ask("OPEN iio:device0 16 00000001") == "0");
  CHECK(hasty.ask("OPEN iio:device0 16 00000001") == "0");
  patient.say("READBUF iio:device0 32\r\n");
  CHECK(hasty.ask("READBUF iio:device0 32") == "-110");
  // the patient one still waits: it is answered when a record is there
  hasty.own();
  hasty.command("iio:device1 arm", "1");
  hasty.command("iio:device1 fire", "1");
  CHECK(patient.line() == "32");
  test::RawClient pusher(server.address());
  CHECK(pusher.ask("OPEN iio:device0 99999 00000001 CYCLIC") == "-22");
  CHECK(pusher.ask("TIMEOUT 0") == "0");
  CHECK(pusher.ask("OPEN iio:device0 99999 00000001") == "0");
  hasty.command("iio:device1 arm", "1");  // from now on there is nothing to read
  pusher.say("READBUF iio:device0 32\r\n" + std::string(1 << 18, '\n'));
  CHECK(pusher.line() == "(gone)");
}
