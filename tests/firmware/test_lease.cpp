#include <catch2/catch.hpp>

#include "core/crc32.h"
#include "tests/firmware/bench_fixture.h"

using namespace powbench;
using firmware::Lease;
using firmware::State;
using powbench::test::Bench;

namespace {

/// A bench that nobody owns.
struct FreeBench : Bench {
  FreeBench() { controller.lease().give_back(); }
  std::string write(const std::string& attribute, const std::string& value) {
    return ask("WRITE iio:device1 " + attribute + " " + std::to_string(value.size()) + "\n" + value);
  }
  std::string read(const std::string& what) {
    const std::string answer = ask("READ " + what + "\n");
    const std::size_t line = answer.find('\n');
    return answer.substr(line + 1, answer.find('\0') - line - 1);
  }
  std::string state() { return read("iio:device1 state"); }
};

}  // namespace

TEST_CASE("nothing that leads to energising is taken from anyone but the owner", "[lease]") {
  FreeBench b;
  b.run(0.2);
  const std::array<std::pair<const char*, const char*>, 6> commands{{{"OUTPUT phase0 raw", "9000"},
                                                                     {"hold_time_ms", "50"},
                                                                     {"touch_delay_us", "100"},
                                                                     {"arm", "1"},
                                                                     {"arm", "0"},
                                                                     {"fire", "1"}}};
  for (const auto& [attribute, value] : commands) CHECK(b.write(attribute, value) == "-16\n");
  CHECK(b.read("iio:device1 last_error").find("claim the bench first") != std::string::npos);
  CHECK(b.write("lease", "anna-7 1000 anna") == "16\n");
  CHECK(b.read("iio:device1 lease") == "anna, 1000 ms left");
  CHECK(b.write("lease", "ben-3 1000 ben") == "-16\n");
  CHECK(b.read("iio:device1 last_error") == "refused: the bench belongs to anna, 1000 ms left");
  for (const auto& [attribute, value] : commands) {
    CHECK(b.write(attribute, std::string(value) + " ben-3") == "-16\n");
    CHECK(b.write(attribute, value) == "-16\n");
  }
  CHECK(b.fire_control().closing_angle() == 0);
  CHECK(b.write("OUTPUT phase0 raw", "9000 anna-7") == "11\n");
  CHECK(b.write("arm", "1 anna-7") == "8\n");
  b.run(0.2);
  CHECK(b.write("arm", "1 ben-3") == "-16\n");
  CHECK(b.ask("WRITE trigger0 trigger_now 7\n1 ben-3") == "-16\n");
  CHECK(b.state() == "armed");
  CHECK(b.write("fire", "1 anna-7") == "8\n");
  b.run(0.4);
  CHECK(b.state() == "captured");
  CHECK(b.read("iio:device1 lease").find("anna-7") == std::string::npos);  // the token is never told
}

TEST_CASE("the words of a lease are checked", "[lease]") {
  FreeBench b;
  for (const char* bad : {"t", "t x", "t 1000 a b", "\x01 1000", " 1000"})
    CHECK(b.write("lease", bad) == "-22\n");
  CHECK(b.write("lease", std::string(49, 't') + " 1000") == "-22\n");
  CHECK(b.write("lease", "t 1000 " + std::string(41, 'n')) == "-22\n");
  CHECK(b.write("lease", "t 99") == "-34\n");
  CHECK(b.write("lease", "t 3600001") == "-34\n");
  CHECK(b.write("lease", "t -5") == "-34\n");
  CHECK(b.write("lease", "t 0") == "-16\n");
  CHECK(b.read("iio:device1 lease") == "free");
  CHECK(b.write("lease", "t 100") == "5\n");
  CHECK(b.read("iio:device1 lease") == "unnamed, 100 ms left");
  CHECK(b.write("lease", "t 0") == "3\n");
  CHECK(b.read("iio:device1 lease") == "free");
  b.controller.lease().protect("sesame.");
  CHECK(b.write("lease", "t 100") == "-1\n");
  CHECK(b.write("lease", "sesame 100") == "-1\n");
  CHECK(b.write("lease", "sesame.t 100") == "12\n");
}

TEST_CASE("a stop needs no lease, and does no more than stop", "[lease]") {
  FreeBench b;
  b.run(0.2);
  b.write("lease", "t 60000 anna");
  b.write("hold_time_ms", "200 t");
  SECTION("armed") {
    b.write("arm", "1 t");
    CHECK(b.write("abort", "1") == "1\n");
    CHECK(b.state() == "idle");
    CHECK(b.write("fire", "1 t") == "-11\n");
  }
  SECTION("energised") {
    b.write("arm", "1 t");
    b.run(0.2);
    b.write("fire", "1 t");
    while (!b.gate_level) b.step();
    CHECK(b.write("abort", "1 somebody") == "10\n");
    b.run(0.0003);
    CHECK_FALSE(b.gate_level);
    CHECK(b.read("iio:device1 last_error").find("stopped by") != std::string::npos);
  }
  SECTION("in fault: only the owner acknowledges") {
    b.write("arm", "1 t");
    b.run(0.2);
    b.shorted = true;
    b.current = 30'000;
    b.run(0.1);
    REQUIRE(b.state() == "fault");
    b.shorted = false;
    b.run(0.1);
    CHECK(b.write("abort", "1") == "1\n");
    CHECK(b.state() == "fault");
    CHECK(b.write("abort", "1 t") == "3\n");
    CHECK(b.state() == "idle");
  }
}

TEST_CASE("set-points are latched from arm until the shot is over", "[lease]") {
  FreeBench b;
  b.run(0.2);
  b.write("lease", "t 60000");
  b.write("OUTPUT phase0 raw", "4500 t");
  b.write("arm", "1 t");
  CHECK(b.write("OUTPUT phase0 raw", "9000 t") == "-16\n");
  CHECK(b.write("hold_time_ms", "50 t") == "-16\n");
  CHECK(b.write("touch_delay_us", "50 t") == "-16\n");
  b.run(0.2);
  b.write("fire", "1 t");
  CHECK(b.write("OUTPUT phase0 raw", "9000 t") == "-16\n");
  b.run(0.4);
  REQUIRE(b.state() == "captured");
  CHECK(b.write("OUTPUT phase0 raw", "9000 t") == "6\n");
  // what the shot was stays what it was
  CHECK(b.read("iio:device0 sealed_shot").find(" angle_centideg=4500 ") != std::string::npos);
}

TEST_CASE("an owner that vanishes leaves the coil off and the bench disarmed", "[lease]") {
  FreeBench b;
  b.owner_present = false;  // a board: what the owner says is the only heartbeat
  b.run(0.2);
  b.write("lease", "t 300 anna");
  b.write("hold_time_ms", "1000 t");
  b.write("arm", "1 t");
  SECTION("armed") {
    b.run(0.299);
    CHECK(b.state() == "armed");
    b.run(0.002);
    CHECK(b.state() == "idle");
    CHECK(b.read("iio:device1 last_error").find("lease has ended") != std::string::npos);
    CHECK(b.read("iio:device1 lease") == "free");
    // and the next owner finds it so
    b.write("lease", "x 1000");
    CHECK(b.write("fire", "1 x") == "-11\n");
    b.run(0.5);
    CHECK(b.history.empty());
  }
  SECTION("energised, whatever others say") {
    b.run(0.2);
    b.write("fire", "1 t");
    while (!b.gate_level) b.step();
    const std::int64_t spoke = b.next;
    while (b.gate_level && b.next < spoke + 100'000) {
      b.ask("READ iio:device1 state\n");
      b.write("fire", "1 spectator");
      b.step();
    }
    CHECK(b.read("iio:device1 fault") == "8 host_lost");
    CHECK(b.next - spoke <= 25'020 + 1'000);  // 250 ms and two blocks, from the last word, not from the edge
  }
  SECTION("an owner that speaks keeps the coil on for as long as asked") {
    b.run(0.2);
    b.write("fire", "1 t");
    for (int i = 0; i < 13; ++i) {
      b.run(0.1);
      b.write("lease", "t 300");
    }
    CHECK(b.state() == "captured");
  }
  SECTION("gone before the record is complete: it is completed") {
    b.write("arm", "0 t");
    b.write("hold_time_ms", "10 t");
    b.write("lease", "t 250");
    b.write("arm", "1 t");
    b.run(0.2);
    b.write("fire", "1 t");
    b.run(0.4);
    CHECK(b.read("iio:device1 lease") == "free");
    CHECK(b.state() == "captured");
    CHECK(b.read("iio:device0 sealed_shot").find(" stage=complete ") != std::string::npos);
  }
}

TEST_CASE("a lease given back disarms, and cannot be given back in the middle of a shot", "[lease]") {
  FreeBench b;
  b.run(0.2);
  b.write("lease", "t 60000");
  b.write("arm", "1 t");
  CHECK(b.write("lease", "t 0") == "3\n");
  CHECK(b.state() == "idle");
  b.write("lease", "t 60000");
  b.write("arm", "1 t");
  b.run(0.2);
  b.write("fire", "1 t");
  CHECK(b.write("lease", "t 0") == "-16\n");
  CHECK(b.state() == "firing");
}

TEST_CASE("a sealed shot says what was latched and recorded, under its checksum", "[lease][seal]") {
  FreeBench b;
  const std::array<firmware::iiod::ContextAttribute, 4> identity{
      {{"boot_id", "b 1"}, {"fw_version", "1.2"}, {"hw_model", "a=b%"}, {"hw_serial", "S"}}};
  b.devices.identify(identity);
  b.controller.identify({.commit = "0123456789ab-dirty", .board_id = "B", .image_crc32 = 0x1234abcd});
  CHECK(b.read("iio:device0 sealed_shot") == "none");
  b.run(0.2);
  b.write("lease", "t 60000");
  b.write("hold_time_ms", "20 t");
  b.write("arm", "1 t");
  const std::string armed = b.read("iio:device0 sealed_shot");
  CHECK(
      armed.starts_with("powbench_shot=1 stage=armed boot=b%201 shot=1 model=a%3db%25 serial=S firmware=1.2 "
                        "commit=0123456789ab-dirty board=B image=1234abcd config=" +
                        b.read("iio:device0 config_crc32") +
                        " calibration=none angle_centideg=0 hold_ms=20 touch_us=0 tolerance_mdeg=1000 "
                        "sample_rate=100000 samples=3000 "
                        "seal="));
  b.run(0.2);
  b.write("fire", "1 t");
  b.run(0.4);
  const std::string text = b.read("iio:device0 sealed_shot");
  const std::size_t seal = text.find(" seal=");
  REQUIRE(seal + 14 == text.size());
  const std::uint32_t crc = crc32({reinterpret_cast<const std::uint8_t*>(text.data()), seal});
  firmware::TextOf<64> wanted;
  wanted.put(" seal=").put_hex32(crc);
  CHECK(text.substr(seal) == wanted.view());
  wanted.clear();
  wanted.put(" record_crc=").put_hex32(b.controller.recorder().crc()).put(' ');
  CHECK(text.find(wanted.view()) != std::string::npos);
  CHECK(text.find(" fire_sample=1000 ") != std::string::npos);
  CHECK(text.find(" gaps=none overruns=0 marks=0 ") != std::string::npos);
  // what was known of the phase: it was fired on, so that three times it is within a degree
  const std::size_t place = text.find(" angle_u_mdeg=");
  REQUIRE(place != std::string::npos);
  const int u = std::stoi(text.substr(place + 14));
  CHECK(u >= 1);
  CHECK(u <= 334);
  CHECK(b.read("iio:device1 phase_faults") == "0 none");
  const std::string now_and_ahead = b.read("iio:device1 phase_u_millideg");
  CHECK(std::stoi(now_and_ahead) >= 1);
  CHECK(std::stoi(now_and_ahead.substr(now_and_ahead.find(' '))) <= 334);
  // an abort that gives the record up gives its seal up, one behind it does not
  b.write("abort", "1 t");
  CHECK(b.read("iio:device0 sealed_shot") == text);
  b.write("arm", "1 t");
  CHECK(b.read("iio:device0 sealed_shot").find("shot=2 ") != std::string::npos);
  b.write("abort", "1 t");
  CHECK(b.read("iio:device0 sealed_shot") == "none");
}

TEST_CASE("a seal that does not fit is an error, never a shorter one", "[lease][seal]") {
  FreeBench b;
  const std::string longest(1420, 'x');
  const std::array<firmware::iiod::ContextAttribute, 1> identity{{{"boot_id", longest}}};
  b.devices.identify(identity);
  b.run(0.2);
  b.write("lease", "t 60000");
  b.write("arm", "1 t");
  CHECK(b.ask("READ iio:device0 sealed_shot\n") == "-75\n");
}

TEST_CASE("the bench says beforehand whether it would arm, in the words of the refusal", "[lease]") {
  FreeBench b;
  b.run(0.2);
  CHECK(b.read("iio:device1 ready") == "yes");
  b.write("lease", "t 60000");
  b.step(true);
  CHECK(b.read("iio:device1 last_error") == "no error");
  CHECK(b.read("iio:device1 ready") == "emergency stop is open: close it first");
  CHECK(b.read("iio:device1 last_error") == "no error");  // it was asked, not refused
  CHECK(b.write("arm", "1 t") == "-16\n");
  CHECK(b.read("iio:device1 last_error") == b.read("iio:device1 ready"));
  b.step();
  CHECK(b.write("arm", "1 t") == "3\n");
  CHECK(b.write("fire", "1 t") == "3\n");
  CHECK(b.read("iio:device1 ready") == "cannot arm while firing: wait, or abort");
}
