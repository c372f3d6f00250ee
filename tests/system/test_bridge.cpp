#include <catch2/catch.hpp>
#include <memory>

#include "bench/uart_board.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;

namespace {

rigs::SimRigConfig short_record() {
  rigs::SimRigConfig config;
  config.record_length = 0.060;
  config.pretrigger = 0.020;
  return config;
}

/// A bridge process on the first loopback address that is free; its address is in `address`.
std::unique_ptr<Program> start_bridge(const Folder& folder, const std::string& port, std::string& address) {
  for (int host = 20; host < 100; ++host) {
    address = "127.0.0." + std::to_string(host);
    auto bridge = std::make_unique<Program>(
        folder, std::vector<std::string>{"bridge", port, "--baud", "2000000", "--listen", address});
    wait_until("a bridge that serves or ends",
               [&] { return bridge->err().find("Ctrl-C") != std::string::npos || bridge->poll() != -1000; });
    if (bridge->poll() == -1000) return bridge;
    if (bridge->err().find("cannot serve on") == std::string::npos) {
      FAIL(bridge->err());
    }
  }
  FAIL("no loopback address is free");
  return nullptr;
}

}  // namespace

TEST_CASE("powbench bridge serves a board until it is told to stop, or until it is unplugged", "[system]") {
  Folder folder, other;
  bench::UartBoard board(short_record(), {}, 2e6);
  std::string address;
  const auto bridge = start_bridge(folder, board.port(), address);
  CHECK_THAT(bridge->err(), Contains("SIM-0001") && Contains("2000000 baud") && Contains(address));

  const Finished info = run(other, {"info", "ip:" + address, "--json"});
  CHECK(info.status == 0);
  CHECK_THAT(info.out, Contains("\"serial\": \"SIM-0001\""));
  const Finished second = run(other, {"info", "serial:" + board.port() + ",2000000"});
  CHECK(second.status == 3);
  CHECK_THAT(second.err, Contains("used by another program"));
  const Finished stopped =
      run(other, {"stop", "serial:" + board.port()});  // through the bridge that holds it
  INFO(stopped.err);
  CHECK(stopped.status == 0);
  CHECK_THAT(stopped.out, Contains("coil off, confirmed by the rig"));

  SECTION("stop") {
    bridge->send(SIGINT);
    CHECK(bridge->wait() == 0);
    CHECK_THAT(bridge->err(), Contains("stopped"));
    const Finished direct = run(other, {"info", "serial:" + board.port() + ",2000000"});
    INFO(direct.err);
    CHECK(direct.status == 0);
    CHECK(run(other, {"stop", "serial:" + board.port()}).status == 0);  // nobody holds it
  }
  SECTION("unplug") {
    board.unplug();
    CHECK(bridge->wait() == 3);
    CHECK_THAT(bridge->err(), Contains("powbench: serial port " + board.port() + " is gone"));
  }
}

TEST_CASE("serial rigs that cannot be are one sentence", "[system]") {
  Folder folder;
  const Finished none = run(folder, {"info", "serial:/dev/no-such-port,2000000"});
  CHECK(none.status == 3);
  CHECK_THAT(none.err, Contains("cannot open serial port /dev/no-such-port"));
  CHECK(run(folder, {"info", "serial:/dev/null,2000000"}).status == 3);
  CHECK(run(folder, {"info", "serial:/dev/ttyACM0,fast"}).status == 3);
  CHECK(run(folder, {"bridge"}).status == 2);
  CHECK(run(folder, {"bridge", "/dev/x", "--baud", "5"}).status == 2);
}
