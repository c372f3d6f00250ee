#include <catch2/catch.hpp>

#include "tests/firmware/bench_fixture.h"

/// Limits to the sample: what a bound that is off by one, or a factor, would let through.

using namespace powbench;
using namespace powbench::firmware;

namespace {

/// Blocks of ten samples with one channel set, for whoever looks at single samples.
struct Blocks {
  Block next(std::initializer_list<int> high, int value = 20'001) {
    scans.assign(10 * channel_count, 0);
    for (std::size_t i = 0; i < 10; ++i)
      scans[i * channel_count + index(Channel::mains_voltage)] =
          static_cast<std::int16_t>(5000 + first + static_cast<int>(i));
    for (const int at : high)
      scans[static_cast<std::size_t>(at) * channel_count + index(Channel::coil_current)] =
          static_cast<std::int16_t>(value);
    const Block block{.first_sample = first, .scans = scans, .owner_present = true};
    first += 10;
    return block;
  }
  std::vector<std::int16_t> scans;
  int first = 0;
};

}  // namespace

TEST_CASE("two samples beyond the trip level trip, wherever they lie, and one does not", "[fault]") {
  const ControllerConfig config = test::Bench::make_config();
  for (const int sign : {1, -1}) {
    for (int at = 0; at < 10; ++at) {
      Interlocks alone(config.interlocks);
      Blocks blocks;
      alone.check(blocks.next({}), {});
      CHECK(alone.check(blocks.next({at}, sign * 20'001), {}) == Fault::none);
      CHECK(alone.check(blocks.next({}), {}) == Fault::none);
      Interlocks pair(config.interlocks);
      Blocks other;
      pair.check(other.next({}), {});
      if (at < 9) {
        CHECK(pair.check(other.next({at, at + 1}, sign * 20'001), {}) == Fault::coil_overcurrent);
      } else {
        CHECK(pair.check(other.next({9}, sign * 20'001), {}) == Fault::none);
        CHECK(pair.check(other.next({0}, sign * 20'001), {}) == Fault::coil_overcurrent);
      }
    }
  }
  // exactly at the level is not beyond it, and two with a pause between them are not two running
  Interlocks level(config.interlocks);
  Blocks blocks;
  level.check(blocks.next({}), {});
  CHECK(level.check(blocks.next({1, 2, 3, 4}, 20'000), {}) == Fault::none);
  CHECK(level.check(blocks.next({1, 3, 5, 7}), {}) == Fault::none);
}

TEST_CASE("after the off edge nothing is armed until the current has ended", "[fire]") {
  test::Bench b;
  b.run(0.2);
  REQUIRE(b.fire_control().set_hold_time_ms(20) == Refusal::accepted);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  b.run(0.2);
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  while (b.history.size() < 2) b.step();
  b.shorted = true;  // the switch goes on conducting for a while
  b.run(0.010);
  b.fire_control().abort();
  CHECK(b.fire_control().state() == State::idle);
  CHECK(b.fire_control().settling());
  CHECK(b.fire_control().arm() == Refusal::wrong_state);
  CHECK(b.fire_control().last_error().find("before current has ended") != std::string_view::npos);
  b.shorted = false;
  b.run(0.007);
  CHECK_FALSE(b.fire_control().settling());
  CHECK(b.fire_control().arm() == Refusal::accepted);
}

TEST_CASE("a switch that stays closed is a fault 25 ms after the off edge, not sooner and not a block later",
          "[fault]") {
  test::Bench b;
  b.run(0.2);
  REQUIRE(b.fire_control().set_hold_time_ms(50) == Refusal::accepted);
  REQUIRE(b.fire_control().arm() == Refusal::accepted);
  b.run(0.2);
  REQUIRE(b.fire_control().fire() == Refusal::accepted);
  while (b.history.size() < 2) b.step();
  const std::int64_t off = b.history.back().at.sample;
  b.shorted = true;
  while (b.fire_control().fault() == Fault::none && b.next < off + 20'000) b.step();
  CHECK(b.fire_control().fault() == Fault::coil_stuck_on);
  CHECK(b.next - off > 2500);
  CHECK(b.next - off <= 2520);
  CHECK_FALSE(b.fire_control().relay_closed());
}

TEST_CASE("a gap in a record has its first sample and its length, to the sample", "[record]") {
  // record of 100 scans, 40 of them before the edge; blocks of ten; the gap ends `lost` samples behind its start
  for (const std::int64_t begin : {110, 120, 150, 170}) {
    for (const std::int64_t lost : {1, 7, 9}) {
      std::vector<std::int16_t> storage(200 * channel_count), scans(10 * channel_count);
      Recorder r(storage, 100, 40, 10'000);
      r.arm();
      for (std::int64_t first = 0; first < 300; first += 10) {
        if (first == 100) r.trigger({140, 0});  // the record is [100, 200)
        Block block{.first_sample = first, .scans = scans};
        if (first == begin) {
          block.first_sample += lost;
          block.scans = std::span(scans).subspan(static_cast<std::size_t>(lost) * channel_count);
        }
        r.push(block);
        for (int i = 0; i < 8; ++i) r.count_in();
      }
      REQUIRE(r.complete());
      REQUIRE(r.gaps().size() == 1);
      CHECK(r.gaps()[0].first == begin - 100);
      CHECK(r.gaps()[0].count == lost);
      CHECK(r.overruns() == static_cast<std::uint32_t>(lost));
    }
  }
  // a gap across either end counts for the part inside
  for (const bool at_start : {true, false}) {
    std::vector<std::int16_t> storage(200 * channel_count), scans(10 * channel_count);
    Recorder r(storage, 100, 40, 10'000);
    r.arm();
    for (std::int64_t first = 0; first < 300; first += 10) {
      if (first == 120) r.trigger({145, 0});    // [105, 205)
      if (at_start && first == 100) continue;   // 100 .. 109 lost: five inside
      if (!at_start && first == 200) continue;  // 200 .. 209 lost: five inside
      r.push({.first_sample = first, .scans = scans});
      for (int i = 0; i < 8; ++i) r.count_in();
    }
    REQUIRE(r.complete());
    REQUIRE(r.gaps().size() == 1);
    CHECK(r.gaps()[0].first == (at_start ? 0 : 95));
    CHECK(r.gaps()[0].count == 5);
  }
}
