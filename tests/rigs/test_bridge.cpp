#include "rigs/bridge/served_port.h"
#include "rigs/registry.h"
#include "rigs/rig_watch.h"
#include "tests/rigs/bridge_desk.h"

using namespace powbench;
using namespace powbench::test;

TEST_CASE("what concerns the connection is answered without the board", "[bridge]") {
  Desk desk;
  RawClient c(desk.bridge.address());
  for (int i = 0; i < 2; ++i) {
    const std::size_t n = std::stoul(c.ask("PRINT"));
    const std::string xml = c.bytes(n + 1);
    CHECK(xml.find("contactor-daq") != std::string::npos);
    CHECK(xml.ends_with("</context>\n"));
  }
  CHECK(c.ask("VERSION") == "0.24.v0.24  ");
  CHECK(c.ask("TIMEOUT 2500") == "0");
  CHECK(c.ask("TIMEOUT soon") == "-22");
  for (const char* unknown : {"ZPRINT", "BINARY", "HELP", "WRITEBUF iio:device0 16", "a b c d e f g"})
    CHECK(c.ask(unknown) == "-22");
  c.say("\r\n\n  \r\nEXIT\r\n");
  CHECK(c.line() == "(gone)");
  const std::string heard = desk.board.heard();
  CHECK(count(heard, "PRINT") == 2);  // until it has come twice alike, then never again
  for (const char* word : {"ZPRINT", "TIMEOUT", "EXIT", "BINARY", "HELP", "WRITEBUF"})
    CHECK(count(heard, word) == 0);
}

TEST_CASE("a board whose port another program holds is stopped through the bridge of that program",
          "[bridge]") {
  std::string port;
  {
    Desk desk;
    port = desk.board.port();
    CHECK(rigs::served_at(port) == desk.bridge.address());
    const std::string uri = "serial:" + port;
    CHECK(rigs::endpoint_to_stop(uri).uri == "ip:" + desk.bridge.address());
    RawClient owner(desk.bridge.address());
    REQUIRE(owner.own() == "14");
    REQUIRE(owner.command("iio:device1 arm", "1") == "3");
    rigs::RigWatch stop(rigs::endpoint_to_stop(uri).uri, std::chrono::seconds(5));
    stop.stop();
    CHECK(stop.status().state == "idle");
    CHECK(owner.command("iio:device1 fire", "1") == "-11");  // no longer armed
  }
  CHECK(rigs::served_at(port).empty());
  const rigs::ServedPort left("/dev/null", "127.0.0.99");  // of a port that nobody holds
  CHECK(rigs::served_at("/dev/null").empty());
  CHECK(rigs::endpoint_to_stop("ip:127.0.0.9").uri == "ip:127.0.0.9");
}

TEST_CASE("every kind of request keeps client, bridge and board in step", "[bridge]") {
  Desk desk(921600);
  RawClient c(desk.bridge.address());
  CHECK(c.read("iio:device1 state") == "idle");
  CHECK(c.read("contactor-ctl state") == "idle");
  CHECK(c.read("iio:device1 OUTPUT phase0 raw_available") == "[0 1 35999]");
  CHECK(c.read("iio:device1 absent") == "-2");
  CHECK(c.read("iio:device9 state") == "-19");
  CHECK(c.own() == "14");
  CHECK(c.command("iio:device1 OUTPUT phase0 raw", "4500") == "6");
  CHECK(c.command("iio:device1 OUTPUT phase0 raw", "36000") == "-34");
  CHECK(c.command("iio:device1 fire", "1") == "-11");
  CHECK(c.ask("WRITE iio:device1 fire many") == "-22");
  CHECK(c.write("iio:device1 fire", std::string(140, '1')) == "-7");
  CHECK(c.write("iio:device1 fire", std::string(100'000, '\n')) == "-7");
  CHECK(c.ask(std::string(10'000, 'x')) == "-22");
  // all attributes at once: lengths, values, padding
  const std::size_t all = std::stoul(c.ask("READ iio:device1 "));
  CHECK(c.bytes(all + 1).find("idle armed firing captured fault") != std::string::npos);
  // no trigger has no body
  CHECK(c.ask("GETTRIG iio:device0") == "0");
  CHECK(c.ask("SETTRIG iio:device0 trigger0") == "0");
  CHECK(c.ask("GETTRIG iio:device0") == "4");
  CHECK(c.line() == "fire");
  CHECK(c.ask("GETTRIG iio:device1") == "-2");
  CHECK(c.ask("SET iio:device0 BUFFERS_COUNT 4") == "0");
  // byte by byte, each in a segment of its own: in between, the bridge serves somebody else
  RawClient other(desk.bridge.address());
  for (const char byte : std::string("READ iio:device1 OUTPUT phase0 raw\r\n")) {
    c.say(std::string(1, byte));
    CHECK(other.ask("VERSION") == "0.24.v0.24  ");
  }
  CHECK(c.line() == "5");
  CHECK(c.bytes(6) == std::string("4500\0\n", 6));
  // several requests in one segment are answered in order
  c.say("READ iio:device1 state\nGETTRIG iio:device0\nVERSION\nREAD iio:device1 gate\n");
  CHECK(c.bytes(33) == std::string("5\nidle\0\n4\nfire\n0.24.v0.24  \n2\n0\0\n", 33).substr(0, 33));
}

TEST_CASE("fire through one client while the READBUF of another waits", "[bridge]") {
  Desk desk;
  RawClient reader(desk.bridge.address());
  CHECK(reader.ask("OPEN iio:device0 4000 000000ff") == "0");
  reader.say("READBUF iio:device0 64000\r\n");
  wait_until("the board has heard of the READBUF",
             [&] { return desk.board.heard().find("READBUF") != std::string::npos; });
  CHECK(reader.silent());
  desk.shoot();
  // the record arrives in pieces, the mask before the first only
  std::size_t owed = 64'000, pieces = 0, largest = 0;
  std::string record;
  while (owed > 0) {
    const std::size_t n = std::stoul(reader.line());
    if (pieces++ == 0) CHECK(reader.line() == "000000ff");
    record += reader.bytes(n);
    largest = std::max(largest, n);
    owed -= n;
  }
  CHECK(largest == 4096);
  CHECK(pieces == 16);
  CHECK(record.size() == 64'000);
  const std::string heard = desk.board.heard();
  for (std::size_t at = heard.find("READBUF"); at != std::string::npos; at = heard.find("READBUF", at + 1))
    CHECK(std::stoul(heard.substr(at + 20)) <= 4096);
  CHECK(reader.ask("CLOSE iio:device0") == "0");
}

TEST_CASE("a record ends short, also where a piece ends", "[bridge]") {
  Desk desk;
  desk.shoot();
  RawClient c(desk.bridge.address());
  c.ask("TIMEOUT 150");
  const auto read = [&](std::size_t n) {  // bytes of one READBUF, and the number that ended it
    std::string line = c.ask("READBUF iio:device0 " + std::to_string(n));
    std::size_t got = 0;
    for (bool first = true; got < n && line.front() != '-' && line != "0"; first = false) {
      if (first) c.line();
      got += c.bytes(std::stoul(line)).size();
      if (got < n) line = c.line();
    }
    return std::to_string(got) + (got < n ? " then " + line : "");
  };
  CHECK(c.ask("OPEN iio:device0 4000 00000001") == "0");
  CHECK(read(6000) == "6000");
  CHECK(read(6000) == "2000 then 0");
  CHECK(read(6000) == "0 then -110");  // nothing more will come, and it is said in time
  CHECK(c.ask("CLOSE iio:device0") == "0");
  CHECK(c.ask("OPEN iio:device0 4000 00000001") == "0");
  CHECK(read(8000 - 4096) == "3904");
  CHECK(read(8192) == "4096 then 0");
  CHECK(c.ask("CLOSE iio:device0") == "0");
  // 24 bytes a scan with the time stamp: pieces are whole scans
  CHECK(c.ask("OPEN iio:device0 1000 000001ff") == "0");
  CHECK(read(24'000) == "24000");
}

TEST_CASE("nothing to read is -110 within the time-out, and the connection stays right", "[bridge]") {
  Desk desk;
  RawClient control(desk.bridge.address()), reader(desk.bridge.address());
  CHECK(control.ask("TIMEOUT 200") == "0");
  CHECK(reader.ask("OPEN iio:device0 16 00000001") == "0");
  CHECK(reader.ask("READBUF iio:device0 32") == "-110");
  CHECK(reader.read("iio:device1 state") == "idle");
  CHECK(control.read("iio:device1 gate") == "0");
}

TEST_CASE("a device has one reader", "[bridge]") {
  Desk desk;
  RawClient first(desk.bridge.address()), second(desk.bridge.address());
  CHECK(first.ask("OPEN iio:device0 16 00000001") == "0");
  CHECK(first.ask("OPEN iio:device0 16 00000001") == "-16");
  CHECK(second.ask("OPEN iio:device0 16 00000001") == "-16");
  CHECK(second.ask("READBUF iio:device0 32") == "-9");
  CHECK(second.ask("CLOSE iio:device0") == "-9");
  CHECK(second.ask("OPEN iio:device0 16 00000200") == "-22");
  CHECK(second.ask("OPEN iio:device1 16 00000001") == "-22");
  CHECK(second.ask("OPEN nothing 16 00000001") == "-19");
}

TEST_CASE("a reader that dies sets its device free, and the next one waits for that", "[bridge]") {
  Desk desk([](rigs::BridgeOptions& o) { o.handover = std::chrono::minutes(10); });
  auto first = std::make_unique<RawClient>(desk.bridge.address());
  RawClient second(desk.bridge.address()), other(desk.bridge.address());
  CHECK(first->ask("OPEN iio:device0 16 00000001") == "0");
  first->say("READBUF iio:device0 32\r\n");
  wait_until("the board has heard of the READBUF",
             [&] { return desk.board.heard().find("READBUF iio:device0 32") != std::string::npos; });
  CHECK(first->silent());
  second.say("OPEN iio:device0 16 00000001\r\n");
  CHECK(other.read("iio:device1 gate") == "0");
  CHECK(second.silent());  // it is given time
  first->hang_up();
  CHECK(second.line() == "0");
  CHECK(second.ask("CLOSE iio:device0") == "0");
  CHECK(count(desk.board.heard(), "CLOSE iio:device0") == 3);  // at the start, of the dead one, of this one
}
