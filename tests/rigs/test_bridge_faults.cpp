#include "core/phase.h"
#include "rigs/iio_rig.h"
#include "rigs/registry.h"
#include "tests/rigs/bridge_desk.h"

using namespace powbench;
using namespace powbench::rigs;
using namespace powbench::test;
using namespace std::chrono_literals;

namespace {

Conditions at(double angle_deg) {
  Conditions c;
  c.closing_angle = radians(angle_deg);
  c.seed = 11;
  return c;
}

bool same(const Record& a, const Record& b) {
  if (a.crc32 != b.crc32 || a.fire_offset != b.fire_offset || a.channels.size() != b.channels.size())
    return false;
  for (std::size_t c = 0; c < a.channels.size(); ++c)
    if (a.channels[c].raw != b.channels[c].raw) return false;
  return true;
}

std::string serial_uri(const bench::UartBoard& board, const std::string& baud) {
  return "serial:" + board.port() + "," + baud;
}

}  // namespace

namespace {

/// A shot of the whole record through `serial:` beside the same one of `sim:`.
void compare_with_simulated(const std::string& baud, const SimRigConfig& config) {
  const auto reference = rigs::open("sim:", config, {});
  const Shot expected = reference->fire(at(75), 5s);
  REQUIRE(expected.outcome == Outcome::pass);
  bench::UartBoard board(config, {}, std::stod(baud));
  const auto rig = rigs::open(serial_uri(board, baud), {}, {});
  CHECK(rig->info().uri == serial_uri(board, baud));
  const Shot shot = rig->fire(at(75), 30s);
  INFO(shot.reason);
  REQUIRE(shot.outcome == Outcome::pass);
  CHECK(same(shot.record, expected.record));
  CHECK(shot.record.fire_sample == expected.record.fire_sample);
}

}  // namespace

TEST_CASE("a shot through a serial line equals the simulated rig's bit for bit", "[bridge]") {
  compare_with_simulated("921600", short_record());
  compare_with_simulated("2000000", short_record());
}

TEST_CASE("so does one with a record of full length", "[bridge][.slow]") {
  compare_with_simulated("921600", {});
  compare_with_simulated("2000000", {});
}

TEST_CASE("a disturbed byte of the record is noticed, and the record read again", "[bridge]") {
  Desk desk;
  const auto rig = rigs::connect_iio("ip:" + desk.bridge.address());
  desk.board.corrupt_answer("4096\n", 1000);
  const Shot shot = rig->fire(at(75), 10s);
  INFO(shot.reason);
  REQUIRE(shot.outcome == Outcome::pass);
  CHECK(count(desk.board.heard(), "OPEN iio:device0") == 2);
  const auto reference = rigs::open("sim:", short_record(), {});
  CHECK(same(shot.record, reference->fire(at(75), 5s).record));
}

TEST_CASE("an answer that cannot be understood is -110, and the next one is right", "[bridge]") {
  Desk desk;
  RawClient c(desk.bridge.address()), other(desk.bridge.address());
  SECTION("length of a value") {
    desk.board.corrupt_answer("5\nidle", 0);
    CHECK(c.read("iio:device1 state") == "-110");
  }
  SECTION("line end") {
    desk.board.corrupt_answer("5\nidle", 1);
    CHECK(c.read("iio:device1 state") == "-110");
  }
  SECTION("payload length of a request: the board waits for more than will come") {
    desk.board.corrupt_request("WRITE iio:device1 OUTPUT phase0 raw", 1);
    CHECK(c.command("iio:device1 OUTPUT phase0 raw", "4500") == "-110");
  }
  SECTION("mask of a READBUF: the reader has lost its place and must open again") {
    desk.shoot();
    CHECK(c.ask("OPEN iio:device0 100 00000001") == "0");
    desk.board.corrupt_answer("200\n", 5);
    CHECK(c.ask("READBUF iio:device0 200") == "-110");
    CHECK(c.ask("READBUF iio:device0 200") == "-9");
    CHECK(c.ask("CLOSE iio:device0") == "0");
    CHECK(c.ask("OPEN iio:device0 100 00000001") == "0");
    CHECK(c.ask("READBUF iio:device0 200") == "200");
    c.line();
    c.bytes(200);
  }
  CHECK(other.read("iio:device1 gate") == "0");
  CHECK(c.read("iio:device1 state_available") == "idle armed firing captured fault");
}

TEST_CASE("a board that falls silent is -110 for everybody, at once after the first; then it is found again",
          "[bridge]") {
  Desk desk(2e6, 400ms);
  RawClient c(desk.bridge.address());
  CHECK(c.read("iio:device1 state") == "idle");
  desk.board.mute(true);
  CHECK(c.read("iio:device1 state") == "-110");
  CHECK(c.read("iio:device1 state") == "-110");
  CHECK(c.read("iio:device1 gate") == "-110");
  desk.board.mute(false);
  std::string state = "-110";
  wait_until("a board that answers again", [&] { return (state = c.read("iio:device1 state")) != "-110"; });
  CHECK(state == "idle");
  CHECK(c.read("iio:device1 gate") == "0");
}

TEST_CASE("a board that is reset in the middle of an upload closes the connections", "[bridge]") {
  Desk desk;
  desk.shoot();
  RawClient reader(desk.bridge.address()), control(desk.bridge.address());
  const std::size_t n = std::stoul(control.ask("PRINT"));
  CHECK(control.bytes(n + 1).find("boot-1") != std::string::npos);
  CHECK(reader.ask("OPEN iio:device0 4000 000000ff") == "0");
  CHECK(reader.ask("READBUF iio:device0 64000") == "4096");
  desk.board.reset();
  // what had arrived is whole; then -110 or the end, never silence
  std::string line = reader.line();
  for (int i = 0; i < 30 && line != "(gone)" && !line.starts_with("-"); ++i) {
    reader.bytes(line.size() == 8 ? 4096 : std::stoul(line));
    line = reader.line();
  }
  CHECK((line == "(gone)" || line.starts_with("-")));
  if (line != "(gone)") CHECK(reader.line() == "(gone)");
  CHECK(control.line() == "(gone)");
  RawClient again(desk.bridge.address());
  const std::size_t size = std::stoul(again.ask("PRINT"));
  CHECK(again.bytes(size + 1).find("boot-2") != std::string::npos);
  CHECK(again.read("iio:device1 state") == "idle");
  CHECK(again.ask("OPEN iio:device0 16 00000001") == "0");
}

TEST_CASE("a bit that flips in the description is not believed", "[bridge]") {
  const auto described = [](const bench::LineFault& fault) {
    bench::UartBoard board(short_record(), {}, 2e6);
    board.set(fault);
    const rigs::LocalBridge bridge(Desk::options(board.port(), 2e6, 2000ms));
    RawClient c(bridge.address());
    const std::size_t n = std::stoul(c.ask("PRINT"));
    return c.bytes(n + 1);
  };
  const std::string right = described({});
  for (const std::uint64_t byte : {14, 700, 3000, 6000}) {
    INFO(byte);
    CHECK((described({bench::LineFault::Kind::flip, false, byte, 1}) == right));
  }
}

TEST_CASE("a CLOSE that is damaged on the line does not lock the buffer for good", "[bridge]") {
  Desk desk;
  RawClient c(desk.bridge.address());
  REQUIRE(c.ask("OPEN iio:device0 16 00000001") == "0");
  desk.board.corrupt_request("CLOSE iio:devic", 0);  // the board hears of a device it does not have
  c.ask("CLOSE iio:device0");
  CHECK(c.ask("OPEN iio:device0 16 00000001") == "0");
}

TEST_CASE("a rig that was reset while nobody looked is noticed, and found again", "[bridge]") {
  Desk desk(2e6, 150ms);
  const auto rig = rigs::connect_iio("ip:" + desk.bridge.address());
  const std::string before = rig->info().boot_id;
  RawClient onlooker(desk.bridge.address());
  desk.board.reset();
  CHECK(onlooker.line() == "(gone)");        // the bridge has seen another boot_id
  const Shot shot = rig->fire(at(10), 10s);  // nothing was fired before: a new connection, then the shot
  CHECK(shot.outcome == Outcome::pass);
  CHECK(rig->info().boot_id != before);
}

TEST_CASE("a cable that is pulled is one sentence", "[bridge]") {
  auto board = std::make_unique<bench::UartBoard>(short_record(), sim::Specimen{}, 2e6);
  const auto rig = rigs::open(serial_uri(*board, "2000000"), {}, {});
  REQUIRE(rig->fire(at(10), 10s).outcome == Outcome::pass);
  board->unplug();
  const Shot shot = rig->fire(at(10), 10s);
  CHECK(shot.outcome == Outcome::error);
  CHECK(shot.rig_lost);
  CHECK_THAT(shot.reason, Catch::Contains(board->port() + " is gone"));
  CHECK(std::count(shot.reason.begin(), shot.reason.end(), '\n') == 0);
  CHECK_FALSE(rig->reconnect());
  CHECK_FALSE(rig->abort());
}

TEST_CASE("a port without a board, and a port in use, are one sentence each", "[bridge]") {
  bench::UartBoard board(short_record(), {}, 2e6);
  SECTION("silence") {
    board.mute(true);
    auto options = Desk::options(board.port(), 2e6, 2s);
    options.probe = 100ms;
    CHECK_THROWS_WITH(rigs::LocalBridge(options), Catch::Contains("2000000 baud; check"));
  }
  SECTION("in use") {
    rigs::LocalBridge first(Desk::options(board.port(), 2e6, 2s));
    CHECK_THROWS_WITH(rigs::LocalBridge(Desk::options(board.port(), 2e6, 2s)),
                      Catch::Contains("used by another program"));
  }
  SECTION("address taken") {
    rigs::LocalBridge first(Desk::options(board.port(), 2e6, 2s));
    bench::UartBoard second(short_record(), {}, 2e6);
    auto options = Desk::options(second.port(), 2e6, 2s);
    options.address = first.address();
    CHECK_THROWS_WITH(rigs::LocalBridge(options), Catch::Contains("another loopback address"));
  }
}
