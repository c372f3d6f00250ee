#include <catch2/catch.hpp>
#include <numeric>

#include "core/random.h"
#include "firmware/port/common/progress.h"
#include "firmware/port/common/uart_link.h"
#include "tests/firmware/bench_fixture.h"

/// What the board port does with the bytes of a serial line, and when it feeds the watchdog.

using namespace powbench;
using namespace powbench::firmware;

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
