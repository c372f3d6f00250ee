#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "firmware/phase_feed.h"

/// Phase tracking on two levels must give what it gives on one.

using namespace powbench;
using firmware::PhaseEstimate;
using firmware::PhaseFault;
using firmware::PhaseFeed;
using firmware::PhaseTracker;

namespace {

/// A mains of 50 Hz with a little noise; blocks of any length.
struct Source {
  std::vector<std::int16_t> scans;
  std::int64_t sample = 0;
  Random random{7};

  firmware::Block block(int samples) {
    scans.assign(static_cast<std::size_t>(samples) * channel_count, 0);
    for (int i = 0; i < samples; ++i) {
      const double v =
          20000 * std::sin(2 * pi * 50.0 * static_cast<double>(sample + i) / 100e3) + 20 * random.normal();
      scans[static_cast<std::size_t>(i) * channel_count + index(Channel::mains_voltage)] =
          static_cast<std::int16_t>(std::lrint(v));
    }
    const firmware::Block block{.first_sample = sample, .scans = scans};
    sample += samples;
    return block;
  }
};

void push(PhaseTracker& tracker, const firmware::Block& block) {
  for (std::int64_t i = 0; i < block.samples(); ++i) tracker.push(block.at(i, Channel::mains_voltage));
}

void check_equal(const PhaseEstimate& a, const PhaseEstimate& b) {
  REQUIRE(a.sample == b.sample);
  REQUIRE(a.phase_turns == b.phase_turns);
  REQUIRE(a.frequency == b.frequency);
  REQUIRE(a.frequency_rate == b.frequency_rate);
  REQUIRE(a.faults == b.faults);
}

}  // namespace

TEST_CASE("the estimate is the same on two levels as on one, bit for bit", "[phase]") {
  Source source;
  PhaseFeed feed{{}};
  PhaseTracker tracker{{}};
  Random random(3);
  for (int n = 0; n < 4000; ++n) {
    const auto block = source.block(1 + static_cast<int>(random.below(25)));
    feed.push(block);
    feed.work();
    push(tracker, block);
    check_equal(feed.estimate(), tracker.estimate());
    if (n == 2500) {
      feed.mark_gap(1234);
      tracker.mark_gap(1234);
      source.sample += 1234;
      REQUIRE_FALSE(feed.estimate().valid());
    }
  }
  CHECK(feed.estimate().valid());
}

TEST_CASE("a gap invalidates the estimate before the lower level has run", "[phase]") {
  Source source;
  PhaseFeed feed{{}};
  for (int n = 0; n < 2000; ++n) feed.push(source.block(10)), feed.work();
  REQUIRE(feed.estimate().valid());
  feed.push(source.block(3));  // summed, not yet a point of the history
  feed.mark_gap(17);
  CHECK((feed.estimate().faults & static_cast<unsigned>(PhaseFault::gap)) != 0);
  const std::int64_t before = feed.estimate().sample;
  source.sample += 17;
  for (int n = 0; n < 2000; ++n) feed.push(source.block(10)), feed.work();
  CHECK(feed.estimate().valid());
  CHECK(feed.estimate().sample == before + 3 + 17 + 20'000);
}

TEST_CASE("a lower level that starves costs history, never the sample index", "[phase]") {
  Source source;
  PhaseFeed feed{{}};
  for (int n = 0; n < 2000; ++n) feed.push(source.block(10)), feed.work();
  const std::int64_t before = feed.estimate().sample;
  for (const int blocks : {20, 31, 32, 33, 100, 1000}) {
    for (int n = 0; n < blocks; ++n) feed.push(source.block(10));
    CHECK(feed.estimate().sample == before);  // grows old, which fire control watches
    feed.work();
    // what did not fit is told as a gap, and never again believed before it is known where it belongs
    for (int n = 0; n < 2000; ++n) feed.push(source.block(10)), feed.work();
    REQUIRE(feed.estimate().valid());
    const double t = static_cast<double>(feed.estimate().sample) / 100e3;
    const double error = std::remainder(static_cast<double>(feed.estimate().phase_turns) - 50.0 * t, 1.0);
    CHECK(360 * std::fabs(error) < 0.1);
    CHECK(source.sample - feed.estimate().sample <= 101);
    feed.reset();
    source = {};
    for (int n = 0; n < 2000; ++n) feed.push(source.block(10)), feed.work();
  }
}
