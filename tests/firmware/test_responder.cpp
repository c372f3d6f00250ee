#include <catch2/catch.hpp>

#include "core/crc32.h"
#include "core/random.h"
#include "tests/firmware/bench_fixture.h"

using namespace powbench;
using powbench::test::Bench;
using Status = firmware::iiod::Connection::Status;

namespace {
std::string with_nul(const std::string& s) {
  return s + std::string(1, '\0');
}
std::string read_answer(const std::string& value) {
  return std::to_string(value.size() + 1) + "\n" + with_nul(value) + "\n";
}
}  // namespace

TEST_CASE("every request gets one answer with Linux error numbers", "[iiod]") {
  Bench b;
  CHECK(b.ask("VERSION\r\n") == "0.24.v0.24  \n");
  CHECK(b.ask("ZPRINT\r\n") == "-22\n");
  CHECK(b.ask("BINARY\r\n") == "-22\n");
  CHECK(b.ask("nonsense\n") == "-22\n");
  CHECK(b.ask("\r\n\n\r\n").empty());
  CHECK(b.ask("timeout 2500\n") == "0\n");
  CHECK(b.connection.timeout_ms() == 2500);
  CHECK(b.ask("TIMEOUT -1\n") == "-22\n");
  CHECK(b.ask("READ iio:device9 state\n") == "-19\n");
  CHECK(b.ask("READ iio:device1 nothing\n") == "-2\n");
  CHECK(b.ask("  READ   iio:device1   state  \r\n") == read_answer("idle"));
  CHECK(b.ask("READ contactor-ctl state\n") == read_answer("idle"));
  CHECK(b.ask("READ iio:device0 INPUT voltage1 label\n") == read_answer("mains_voltage"));
  CHECK(b.ask("READ iio:device0 BUFFER watermark\n") == read_answer("1"));
  CHECK(b.ask("SET iio:device0 BUFFERS_COUNT 4\n") == "0\n");
  CHECK(b.ask("a b c d e f g h\n") == "-22\n");
}

TEST_CASE("GETTRIG without a trigger is a bare 0", "[iiod]") {
  Bench b;
  CHECK(b.ask("GETTRIG iio:device0\n") == "0\n");
  CHECK(b.ask("SETTRIG iio:device0 trigger0\n") == "0\n");
  CHECK(b.ask("GETTRIG iio:device0\n") == "4\nfire\n");
  CHECK(b.ask("SETTRIG iio:device0\n") == "0\n");
  CHECK(b.ask("GETTRIG iio:device0\n") == "0\n");
  CHECK(b.ask("GETTRIG iio:device1\n") == "-2\n");
  CHECK(b.ask("SETTRIG iio:device0 iio:device1\n") == "-19\n");
}

TEST_CASE("WRITE reaches the set-point, and a refused one swallows its payload", "[iiod]") {
  Bench b;
  CHECK(b.ask("WRITE iio:device1 OUTPUT phase0 raw 7\n" + with_nul("9000 t")) == "7\n");
  CHECK(b.fire_control().closing_angle() == 9000);
  CHECK(b.ask("WRITE iio:device1 OUTPUT phase0 raw 8\n" + with_nul("36000 t")) == "-34\n");
  CHECK(b.ask("WRITE iio:device1 OUTPUT phase0 raw 6\n" + with_nul("nan t")) == "-22\n");
  CHECK(b.ask("WRITE iio:device1 state 5\n" + with_nul("idle")) == "-1\n");
  CHECK(b.ask("WRITE iio:device1 none 4\nabcdREAD iio:device1 state\n") == "-2\n" + read_answer("idle"));
  CHECK(b.ask("WRITE iio:device7 hold_time_ms 4\nabcdVERSION\n") == "-19\n0.24.v0.24  \n");
  // longer than any value: consumed, refused, still in step
  CHECK(b.ask("WRITE iio:device1 hold_time_ms 5000\n" + std::string(5000, '7') + "VERSION\n") ==
        "-7\n0.24.v0.24  \n");
  CHECK(b.ask("WRITE iio:device1 hold_time_ms 99999999999\n") == "-22\n");
  CHECK(b.ask("WRITE iio:device1 hold_time_ms 0\n") == "-16\n");
  CHECK(b.fire_control().closing_angle() == 9000);
}

TEST_CASE("READ of all attributes packs them in order, padded to four", "[iiod]") {
  Bench b;
  const std::string answer = b.ask("READ iio:device1 \r\n");
  const std::size_t line = answer.find('\n');
  const auto total = static_cast<std::size_t>(std::stoul(answer.substr(0, line)));
  REQUIRE(answer.size() == line + 1 + total + 1);
  CHECK(answer.back() == '\n');
  std::vector<std::string> values;
  std::size_t at = line + 1;
  for (std::size_t i = 0; i < b.devices.control().attributes.size(); ++i) {
    std::uint32_t n = 0;
    for (int k = 0; k < 4; ++k) n = n << 8 | static_cast<std::uint8_t>(answer[at++]);
    values.push_back(answer.substr(at, n - 1));
    at += (n + 3) / 4 * 4;
  }
  CHECK(at == line + 1 + total);
  CHECK(values[values.size() - 4] == "idle armed firing captured fault");
}

TEST_CASE("WRITE of all attributes follows the same packing", "[iiod]") {
  Bench b;
  std::string packed;
  for (const auto& a : b.devices.control().attributes) {
    const std::string value = a.name == "hold_time_ms" ? std::string("00250 t") + '\0' : std::string{};
    const auto n = value.empty() ? 0xFFFFFFFFU : static_cast<std::uint32_t>(value.size());
    for (int k = 3; k >= 0; --k) packed += static_cast<char>(n >> (8 * k) & 0xFFU);
    packed += value;
  }
  REQUIRE(packed.size() <= 128);
  CHECK(b.ask("WRITE iio:device1  " + std::to_string(packed.size()) + "\n" + packed) ==
        std::to_string(packed.size()) + "\n");
  CHECK(b.fire_control().hold_time_ms() == 250);
}

TEST_CASE("the description is counted exactly and escapes what XML must escape", "[iiod]") {
  Bench b;
  const std::string answer = b.ask("PRINT\r\n");
  const std::size_t line = answer.find('\n');
  const auto n = static_cast<std::size_t>(std::stoul(answer.substr(0, line)));
  REQUIRE(answer.size() == line + 1 + n + 1);
  CHECK(answer.back() == '\n');
  CHECK(answer.find("test &lt;bench&gt; &amp; &quot;co&quot;") != std::string::npos);
  CHECK(answer.find("le:S16/16&gt;&gt;0") != std::string::npos);
  CHECK(answer.find("<!DOCTYPE context") != std::string::npos);
}

TEST_CASE("attribute names stand in alphabetical order and every value is readable and not empty", "[iiod]") {
  Bench b;
  b.run(0.1);
  const auto check = [](const firmware::iiod::Device& d,
                        std::span<const firmware::iiod::Attribute> attributes) {
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      INFO(d.name << " " << attributes[i].name);
      if (i > 0) CHECK(attributes[i - 1].name < attributes[i].name);
      firmware::LongText value;
      CHECK(attributes[i].read(d.self, attributes[i].argument, value) == 0);
      CHECK(!value.view().empty());
      CHECK(!value.overflowed());
    }
  };
  for (const auto* d : b.list) {
    check(*d, d->attributes);
    check(*d, d->buffer_attributes);
    for (const auto& c : d->channels) check(*d, c.attributes);
  }
}

TEST_CASE("one byte at a time gives the same answers", "[iiod]") {
  Bench whole, split;
  const std::string dialogue = "PRINT\r\nREAD iio:device1 state\r\nWRITE iio:device1 hold_time_ms 5\r\n50 t" +
                               std::string(1, '\0') + "READ iio:device1 \nGETTRIG iio:device0\nfoo\n";
  std::string answers;
  for (const char c : dialogue) answers += split.ask(std::string_view(&c, 1));
  CHECK(answers == whole.ask(dialogue));
}

TEST_CASE("garbage never takes the responder out of step", "[iiod]") {
  Bench b;
  CHECK(b.ask(std::string(10'000, 'x') + "\nVERSION\n") == "-22\n0.24.v0.24  \n");
  Random random(5);
  const std::string words[] = {"READ",
                               "WRITE",
                               "OPEN",
                               "READBUF",
                               "CLOSE",
                               "iio:device0",
                               "iio:device1",
                               "INPUT",
                               "BUFFER",
                               "state",
                               "arm",
                               "fire",
                               "0000000f",
                               "64",
                               "-3",
                               "\t",
                               "SETTRIG",
                               "trigger0",
                               "999999999999999999999"};
  for (int i = 0; i < 20'000; ++i) {
    std::string line;
    const auto n = random.below(7);
    for (std::uint64_t k = 0; k < n; ++k) line += words[random.below(std::size(words))] + " ";
    if (random.below(4) == 0) line += static_cast<char>(random.below(256));
    b.ask(line + "\n");
    firmware::iiod::Connection fresh;
    if (b.connection.status() == Status::closed) b.connection = fresh;
    if (b.connection.status() == Status::pending) {
      test::Answers out;
      b.responder.expire(b.connection, firmware::iiod::etimedout, out);
      REQUIRE(out.text == "-110\n");
    }
  }
  // whatever payload a half-sent WRITE may still wait for is at most a million bytes
  b.ask(std::string(1'000'001, '\n'));
  CHECK(b.ask("VERSION\n") == "0.24.v0.24  \n");
  CHECK(b.history.empty());  // and none of it reached the coil: no virtual time has passed
}

TEST_CASE("a record is read back exactly, whole, masked and in pieces", "[iiod]") {
  Bench b;
  b.run(0.2);
  b.ask("WRITE iio:device1 arm 3\n1 t");
  b.run(0.2);
  b.ask("WRITE iio:device1 fire 3\n1 t");
  b.run(0.3);
  REQUIRE(b.fire_control().state() == firmware::State::captured);
  const auto& recorder = b.controller.recorder();

  // whole scans: the CRC is over exactly these bytes
  CHECK(b.ask("OPEN iio:device0 3000 000000ff\n") == "0\n");
  std::string body = b.ask("READBUF iio:device0 48000\n");
  REQUIRE(body.starts_with("48000\n000000ff\n"));
  body = body.substr(15);
  REQUIRE(body.size() == 48000);
  CHECK(crc32({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()}) == recorder.crc());
  CHECK(b.ask("OPEN iio:device0 3000 000000ff\n") == "-16\n");
  CHECK(b.ask("CLOSE iio:device0\n") == "0\n");
  CHECK(b.ask("CLOSE iio:device0\n") == "-9\n");
  CHECK(b.ask("READBUF iio:device0 16\n") == "-9\n");

  // one channel with time stamps: 2 bytes, 6 of padding, 8 of time
  CHECK(b.ask("OPEN iio:device0 16 00000101\n") == "0\n");
  std::string piece = b.ask("READBUF iio:device0 32\n");
  REQUIRE(piece.starts_with("32\n00000101\n"));
  piece = piece.substr(12);
  REQUIRE(piece.size() == 32);
  std::uint64_t first = 0, second = 0;
  for (int k = 7; k >= 0; --k) {
    first = first << 8 | static_cast<std::uint8_t>(piece[static_cast<std::size_t>(8 + k)]);
    second = second << 8 | static_cast<std::uint8_t>(piece[static_cast<std::size_t>(24 + k)]);
  }
  CHECK(first == static_cast<std::uint64_t>(recorder.first_sample()) * 10'000);
  CHECK(second - first == 10'000);
  CHECK(b.ask("CLOSE iio:device0\n") == "0\n");

  // asking for more than there is: the rest stops short, then nothing more comes
  CHECK(b.ask("OPEN iio:device0 4000 00000001\n") == "0\n");
  const std::string rest = b.ask("READBUF iio:device0 8000\n");
  CHECK(rest.starts_with("6000\n00000001\n"));
  CHECK(rest.ends_with("0\n"));
  CHECK(b.ask("READBUF iio:device0 2\n").empty());
  CHECK(b.connection.status() == Status::pending);
  test::Answers out;
  b.responder.expire(b.connection, firmware::iiod::etimedout, out);
  CHECK(out.text == "-110\n");
  CHECK(b.ask("VERSION\n") == "0.24.v0.24  \n");
  // a polled line tells the end of the record from samples that are still to come
  CHECK(b.ask("READBUF iio:device0 2\n").empty());
  out.text.clear();
  b.responder.expire(b.connection, firmware::iiod::eagain, out);
  CHECK(out.text == "0\n");
  CHECK(b.connection.status() == Status::ready);
}

TEST_CASE("a polled READBUF without a record is -EAGAIN", "[iiod]") {
  Bench b;
  CHECK(b.ask("OPEN iio:device0 16 00000001\n") == "0\n");
  CHECK(b.ask("READBUF iio:device0 32\n").empty());
  test::Answers out;
  b.responder.expire(b.connection, firmware::iiod::eagain, out);
  CHECK(out.text == "-11\n");
}

TEST_CASE("a request that stops half-way can be forgotten", "[iiod]") {
  Bench b;
  CHECK(b.ask("WRITE iio:device1 hold_time_ms 400\n50").empty());
  CHECK(b.ask("VERSION\n").empty());  // taken for payload
  b.connection.forget_input();
  CHECK(b.ask("VERSION\n") == "0.24.v0.24  \n");
  CHECK(b.ask("READ iio:device1 sta").empty());
  b.connection.forget_input();
  CHECK(b.ask("VERSION\n") == "0.24.v0.24  \n");
  CHECK(b.ask(std::string(500, 'x')).empty());
  b.connection.forget_input();
  CHECK(b.ask("VERSION\n") == "0.24.v0.24  \n");
}

TEST_CASE("OPEN refuses what the record does not have", "[iiod]") {
  Bench b;
  CHECK(b.ask("OPEN iio:device0 256 00000200\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device0 256 00000000\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device0 256 xyz\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device0 0 00000001\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device0 16 00000001 CYCLIC\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device1 256 00000001\n") == "-22\n");
  CHECK(b.ask("OPEN iio:device5 256 00000001\n") == "-19\n");
}

TEST_CASE("a reader inside an old record is told to reopen, one that waits follows to the new", "[iiod]") {
  Bench b;
  b.run(0.2);
  const auto shoot = [&] {
    REQUIRE(b.fire_control().arm() == firmware::Refusal::accepted);
    b.run(0.2);
    REQUIRE(b.fire_control().fire() == firmware::Refusal::accepted);
    b.run(0.3);
    REQUIRE(b.fire_control().state() == firmware::State::captured);
  };
  CHECK(b.ask("OPEN iio:device0 10 00000001\n") == "0\n");
  CHECK(b.ask("READBUF iio:device0 20\n").empty());
  shoot();
  test::Answers out;
  b.responder.resume(b.connection, out);
  CHECK(out.text.starts_with("20\n00000001\n"));
  shoot();
  CHECK(b.ask("READBUF iio:device0 20\n") == "-9\n");
}
