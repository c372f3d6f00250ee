#include <catch2/catch.hpp>

#include "tests/firmware/bench_fixture.h"

/// The zero of the coil's channels: found at rest, taken from every check, refused when it cannot be one.

using namespace powbench;
using namespace powbench::firmware;

namespace {

/// A controller that captures, fed with a constant offset and, on request, an alternating current.
struct Offset {
  static ControllerConfig make_config() {
    ControllerConfig c = test::Bench::make_config();
    c.zero = {.samples = 10'000, .most_counts = 2000, .quiet_counts = 200};
    return c;
  }

  void run(int blocks) {
    for (int b = 0; b < blocks; ++b) {
      std::vector<std::int16_t> scans(10 * channel_count);
      for (int i = 0; i < 10; ++i) {
        auto* scan = &scans[static_cast<std::size_t>(i) * channel_count];
        const double angle = 2 * pi * 50.0 * static_cast<double>(next + i) / 1e5;
        scan[index(Channel::mains_voltage)] = static_cast<std::int16_t>(std::lrint(16000 * std::sin(angle)));
        scan[index(Channel::coil_current)] =
            static_cast<std::int16_t>(offset + std::lrint(amplitude * std::sin(angle)));
        scan[index(Channel::coil_voltage)] = static_cast<std::int16_t>(-offset);
      }
      const Block block{.first_sample = next, .scans = scans, .owner_present = true};
      next += 10;
      controller.step(block);
    }
  }

  std::int64_t next = 0;
  int offset = 0;
  double amplitude = 0.0;
  std::vector<std::int16_t> storage = std::vector<std::int16_t>(4000 * channel_count);
  Controller controller{make_config(), storage};
  FireControl& fire = controller.fire_control();
};

}  // namespace

TEST_CASE("an offset on the current is no current, once its zero has been captured", "[fault]") {
  for (const int offset : {-1999, -100, 0, 99, 101, 1999}) {
    Offset b;
    b.offset = offset;
    b.fire.boot({});
    b.run(999);
    CHECK(b.fire.arm() == Refusal::wrong_state);
    CHECK(b.fire.state() == State::idle);
    b.run(2);
    CHECK(b.controller.zero_state() == ZeroCapture::State::done);
    CHECK(b.controller.config().interlocks.current_zero_counts == offset);
    CHECK(b.controller.config().calibration[index(Channel::coil_voltage)].zero_counts == -offset);
    CHECK(b.fire.arm() == Refusal::accepted);
    b.run(3000);  // and many rounds of the configuration's checksum
    CHECK(b.fire.state() == State::armed);
    // current beyond it is seen: the switch is a short
    b.amplitude = 500;
    b.run(300);
    CHECK(b.fire.fault() == Fault::coil_stuck_on);
  }
}

TEST_CASE("the mean of a capture is rounded to the nearest count", "[fault]") {
  ZeroCapture zero({.samples = 10, .most_counts = 2000, .quiet_counts = 200});
  std::vector<std::int16_t> scans(10 * channel_count);
  for (std::size_t i = 0; i < 10; ++i)
    scans[i * channel_count + index(Channel::coil_current)] = i < 6 ? -4 : -3;
  CHECK(zero.take({.samples = 10, .most_counts = 2000, .quiet_counts = 200}, {.scans = scans}));
  CHECK(zero.current() == -4);
  for (std::size_t i = 0; i < 10; ++i)
    scans[i * channel_count + index(Channel::coil_current)] = i < 4 ? 4 : 3;
  zero.begin({.samples = 10, .most_counts = 2000, .quiet_counts = 200});
  CHECK(zero.take({.samples = 10, .most_counts = 2000, .quiet_counts = 200}, {.scans = scans}));
  CHECK(zero.current() == 3);
}

TEST_CASE("what cannot be a zero is none: too far away, or a current", "[fault]") {
  Offset far;
  far.offset = 2001;
  far.run(1001);
  CHECK(far.controller.zero_state() == ZeroCapture::State::far);
  CHECK(far.fire.arm() == Refusal::wrong_state);
  CHECK(far.fire.last_error().find("offset") == 0);
  // repaired, and captured on command
  far.offset = 50;
  CHECK(far.controller.capture_zero() == Refusal::accepted);
  far.run(1001);
  CHECK(far.fire.arm() == Refusal::accepted);
  CHECK(far.controller.capture_zero() == Refusal::wrong_state);

  Offset flowing;
  flowing.amplitude = 110;
  flowing.fire.boot({});
  flowing.run(1001);
  CHECK(flowing.fire.fault() == Fault::reset_while_energised);
  flowing.fire.abort();
  CHECK(flowing.fire.arm() == Refusal::wrong_state);
  CHECK(flowing.fire.last_error().find("coil current with gate") == 0);
}

TEST_CASE("the zero is captured by wire, for the owner and at rest only", "[fault]") {
  test::Bench b;
  CHECK(b.ask("READ contactor-ctl zero_capture\r\n").find("none") != std::string::npos);
  const auto write = [&](std::string_view name, std::string_view value) {
    return b.ask("WRITE contactor-ctl " + std::string(name) + " " + std::to_string(value.size()) + "\r\n" +
                 std::string(value));
  };
  CHECK(write("zero_capture", "1") == "-16\n");  // nobody's
  REQUIRE(write("lease", "t 60000 test") == "12\n");
  CHECK(write("zero_capture", "1 t") == "3\n");
  CHECK(write("zero_capture", "2 t") == "-22\n");
}
