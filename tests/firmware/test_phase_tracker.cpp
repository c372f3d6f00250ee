#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "bench/phase_judge.h"
#include "bench/phase_peers.h"
#include "core/units.h"
#include "firmware/phase_tracker.h"

using namespace powbench::bench;
using powbench::firmware::PhaseEstimate;
using powbench::firmware::PhaseFault;
using powbench::firmware::PhaseTracker;

namespace {

bool has(const PhaseEstimate& estimate, PhaseFault fault) {
  return (estimate.faults & static_cast<std::uint16_t>(fault)) != 0;
}

/// Pushes `samples` of a source and counts the valid estimates.
int feed(PhaseTracker& tracker, MainsSource& source, int samples) {
  int valid = 0;
  for (int i = 0; i < samples; ++i) {
    tracker.push(source.next());
    valid += tracker.estimate().valid() ? 1 : 0;
  }
  return valid;
}

int feed_constant(PhaseTracker& tracker, std::int16_t value, int samples) {
  int valid = 0;
  for (int i = 0; i < samples; ++i) {
    tracker.push(value);
    valid += tracker.estimate().valid() ? 1 : 0;
  }
  return valid;
}

}  // namespace

TEST_CASE("the first estimate is valid after three to six cycles and refers to the newest sample",
          "[phase]") {
  PhaseTracker tracker{{}};
  CHECK(tracker.sample() == -1);
  CHECK_FALSE(tracker.estimate().valid());
  MainsSource source({}, 50.0, 0.1, 1);
  CHECK(feed(tracker, source, 5500) == 0);
  feed(tracker, source, 6500);
  CHECK(tracker.estimate().valid());
  CHECK(tracker.sample() == 11999);
  CHECK(tracker.estimate().sample == 11999);
  CHECK(tracker.estimate().amplitude == Approx(mains_counts).epsilon(0.002));
  CHECK(tracker.estimate().frequency == Approx(50.0).margin(0.01));
}

TEST_CASE("a supply far from the nominal frequency is found from the cold", "[phase]") {
  for (const double hertz : {45.0, 65.0}) {
    PhaseTracker tracker{{}};
    MainsSource source({}, hertz, 0.1, 1);
    feed(tracker, source, 15000);
    INFO(hertz);
    CHECK(tracker.estimate().valid());
    CHECK(tracker.estimate().frequency == Approx(hertz).margin(0.02));
  }
}

TEST_CASE("a supply outside 45 .. 65 Hz or 0.7 .. 1.2 of nominal is never valid", "[phase]") {
  for (const double hertz : {40.0, 43.5, 44.5, 65.5, 70.0, 100.0}) {
    PhaseTracker tracker{{}};
    MainsSource source({}, hertz, 0.1, 1);
    INFO(hertz << " Hz");
    CHECK(feed(tracker, source, 80000) == 0);
  }
  for (const float nominal : {10000.0F, 16000.0F, 30000.0F}) {
    PhaseTracker tracker{{.nominal_amplitude = nominal}};
    MainsSource source({}, 50.0, 0.1, 1);
    INFO("amplitude " << mains_counts / static_cast<double>(nominal));
    CHECK(feed(tracker, source, 80000) == 0);
    CHECK(has(tracker.estimate(), PhaseFault::amplitude));
  }
}

TEST_CASE("zeros, constants, offsets and saturation are never valid", "[phase]") {
  for (const int value : {0, 1, 5000, 32767, -32768}) {
    PhaseTracker tracker{{}};
    INFO(value);
    CHECK(feed_constant(tracker, static_cast<std::int16_t>(value), 60000) == 0);
  }
  SECTION("an offset that drives half of the wave into saturation") {
    PhaseTracker tracker{{}};
    MainsSource source({.offset = 1.2}, 50.0, 0.1, 1);
    CHECK(feed(tracker, source, 80000) == 0);
  }
  SECTION("a square wave between the rails") {
    PhaseTracker tracker{{}};
    int valid = 0;
    for (int n = 0; n < 80000; ++n) {
      tracker.push((n / 1000) % 2 == 0 ? std::int16_t{32767} : std::int16_t{-32768});
      valid += tracker.estimate().valid() ? 1 : 0;
    }
    CHECK(valid == 0);
  }
  SECTION("noise alone") {
    PhaseTracker tracker{{}};
    Noise noise(4);
    int valid = 0;
    for (int n = 0; n < 80000; ++n) {
      tracker.push(static_cast<std::int16_t>(8000.0 * noise.normal() / 2));
      valid += tracker.estimate().valid() ? 1 : 0;
    }
    CHECK(valid == 0);
  }
}

TEST_CASE("the mains going constant is noticed within 5 ms at any level", "[phase]") {
  for (int start = 0; start < 16; ++start) {
    PhaseTracker tracker{{}};
    MainsSource source({}, 50.0, start / 16.0, 1);
    feed(tracker, source, 30000);
    REQUIRE(tracker.estimate().valid());
    const std::int16_t stuck = source.next();
    INFO("stuck at " << stuck);
    feed_constant(tracker, stuck, 500);
    CHECK_FALSE(tracker.estimate().valid());
    CHECK(feed_constant(tracker, stuck, 50000) == 0);
  }
}

TEST_CASE("a gap invalidates at once, counts its samples, and is forgotten", "[phase]") {
  PhaseTracker tracker{{}};
  MainsSource source({}, 50.0, 0.1, 1);
  feed(tracker, source, 30000);
  REQUIRE(tracker.estimate().valid());
  for (int i = 0; i < 777; ++i) source.next();
  tracker.mark_gap(777);
  CHECK(has(tracker.estimate(), PhaseFault::gap));
  CHECK(tracker.sample() == 30776);
  CHECK(feed(tracker, source, 6000) == 0);
  CHECK(has(tracker.estimate(), PhaseFault::gap));
  feed(tracker, source, 5000);
  CHECK(tracker.estimate().valid());
  const double t = static_cast<double>(tracker.estimate().sample) / mains_rate;
  CHECK(degrees_between(static_cast<double>(tracker.estimate().phase_turns), source.phase(t)) < 0.1);
}

TEST_CASE("the sample index passes 2^31 and 2^32 without a trace", "[phase]") {
  for (const std::int64_t start :
       {(std::int64_t{1} << 31) - 6000, (std::int64_t{1} << 32) - 6000, std::int64_t{1} << 50}) {
    PhaseTracker tracker{{}};
    PhaseTracker plain{{}};
    tracker.mark_gap(start);
    plain.mark_gap(0);
    MainsSource source({.noise = 0.01}, 50.0, 0.1, 1);
    MainsSource again({.noise = 0.01}, 50.0, 0.1, 1);
    feed(tracker, source, 20000);
    feed(plain, again, 20000);
    CHECK(tracker.estimate().sample == plain.estimate().sample + start);
    CHECK(tracker.estimate().phase_turns == plain.estimate().phase_turns);
    const auto here = tracker.next_instant(9000, tracker.sample() + 50);
    const auto there = plain.next_instant(9000, plain.sample() + 50);
    CHECK(here.sample == there.sample + start);
    CHECK(here.fraction == there.fraction);
  }
}

TEST_CASE("the same samples give the same bits, also after a reset", "[phase]") {
  PhaseTracker one{{}};
  PhaseTracker two{{}};
  MainsSource other({.distortion = 0.05}, 57.0, 0.7, 8);
  feed(two, other, 34567);
  two.reset();
  MainsSource a(steady_scenarios().back(), 50.0, 0.1, 1);
  MainsSource b(steady_scenarios().back(), 50.0, 0.1, 1);
  for (int i = 0; i < 50000; ++i) {
    one.push(a.next());
    two.push(b.next());
    REQUIRE(one.estimate().sample == two.estimate().sample);
    REQUIRE(std::memcmp(&one.estimate().phase_turns, &two.estimate().phase_turns, 4 * sizeof(float)) == 0);
    REQUIRE(one.estimate().faults == two.estimate().faults);
  }
}

TEST_CASE("the estimate is the one recorded: the arithmetic has not changed under the compiler", "[phase]") {
  PhaseTracker tracker{{}};
  std::uint64_t hash = 14695981039346656037U;
  // A triangle wave and noise in integers, so that the input does not depend on any library.
  std::uint32_t random = 1;
  for (int n = 0; n < 60000; ++n) {
    const int place = n % 2000;
    const int value = place < 500 ? place : (place < 1500 ? 1000 - place : place - 2000);
    if (n % 10 == 0) random = random * 1664525U + 1013904223U;
    tracker.push(static_cast<std::int16_t>(value * 44 + static_cast<int>((random >> 16U) % 601U)));
    const PhaseEstimate& e = tracker.estimate();
    for (const float x : {e.phase_turns, e.frequency, e.frequency_rate, e.amplitude}) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &x, sizeof bits);
      hash = (hash ^ bits) * 1099511628211U;
    }
    hash = (hash ^ e.faults) * 1099511628211U;
  }
  CHECK(tracker.estimate().valid());
  CHECK(hash == 16204848231129428796U);
}

TEST_CASE("other sample rates give the same phase", "[phase]") {
  for (const double rate : {20000.0, 48000.0, 96000.0, 200000.0}) {
    PhaseTracker tracker{{.sample_rate = static_cast<float>(rate)}};
    const auto phase = [&](double n) { return 0.3 + 51.3 * n / rate; };
    int valid = 0;
    double worst = 0;
    for (int n = 0; n < static_cast<int>(0.5 * rate); ++n) {
      tracker.push(static_cast<std::int16_t>(std::lround(19000 * std::sin(2 * powbench::pi * phase(n)))));
      const PhaseEstimate& e = tracker.estimate();
      if (!e.valid()) continue;
      ++valid;
      worst = std::max(
          worst, degrees_between(static_cast<double>(e.phase_turns), phase(static_cast<double>(e.sample))));
    }
    INFO(rate << " Hz: worst " << worst << " deg");
    CHECK(valid > static_cast<int>(0.35 * rate));
    CHECK(worst < 0.05);
  }
}

TEST_CASE("the next instant is never early and has the phase asked for", "[phase]") {
  for (const double ramp : {0.0, 1.0}) {
    for (const double hertz : {45.0, 50.0, 63.0}) {
      MainsSource source({.ramp = ramp}, hertz, 0.1, 1);
      PhaseTracker tracker{{}};
      feed(tracker, source, 130000);
      REQUIRE(tracker.estimate().valid());
      const std::int64_t now = tracker.sample();
      double worst = 0;
      for (int target = 0; target < 36000; target += 77) {
        for (const int ahead : {-500, 0, 1, 10, 399, 1999, 2500}) {
          const std::int64_t earliest = now + ahead;
          const auto instant = tracker.next_instant(target, earliest);
          REQUIRE(instant.sample >= earliest);
          REQUIRE(instant.fraction >= 0.0F);
          REQUIRE(instant.fraction < 1.0F);
          REQUIRE(instant.sample - earliest <= static_cast<std::int64_t>(1.001 * mains_rate / hertz) + 1);
          const double t =
              (static_cast<double>(instant.sample) + static_cast<double>(instant.fraction)) / mains_rate;
          worst = std::max(worst, degrees_between(source.phase(t), target / 36000.0));
        }
      }
      INFO(hertz << " Hz, " << ramp << " Hz/s: worst " << worst << " deg");
      CHECK(worst < (ramp > 0 ? 0.3 : 0.05));
    }
  }
}

TEST_CASE("the next instant is never early for any state and any distance", "[phase]") {
  PhaseTracker cold{{}};
  PhaseTracker warm{{}};
  MainsSource source(steady_scenarios().back(), 65.0, 0.1, 1);
  feed(warm, source, 30000);
  Noise random(7);
  for (const PhaseTracker* tracker : {&cold, &warm}) {
    for (int i = 0; i < 20000; ++i) {
      const double size = random.uniform() * 45;
      auto earliest = static_cast<std::int64_t>(std::pow(2.0, size));
      if (i % 3 == 0) earliest = -earliest;
      const auto target = static_cast<std::int32_t>(random.uniform() * 36000);
      const auto instant = tracker->next_instant(target, earliest);
      REQUIRE(instant.sample >= earliest);
      REQUIRE(instant.sample <= earliest + 2500);
      REQUIRE(instant.fraction >= 0.0F);
      REQUIRE(instant.fraction < 1.0F);
    }
  }
}

TEST_CASE("a jump of the mains is suspicious within a millisecond, and notches and noise are not",
          "[phase]") {
  for (int start = 0; start < 24; ++start) {
    PhaseTracker tracker{{}};
    MainsSource source({.jump = 30}, 50.0, start / 24.0, 1);
    bool before = false;
    int late = 0;
    for (int n = 0; n < 101000; ++n) {
      const bool jumped = n / mains_rate >= event_start;
      tracker.push(source.next());
      before = before || (n > 50000 && !jumped && tracker.suspicious());
      if (jumped && late < 1000 && !tracker.suspicious()) ++late;
      if (tracker.suspicious() && jumped) break;
    }
    INFO("start " << start << " / 24: " << late << " samples");
    CHECK_FALSE(before);
    CHECK(late <= 110);
  }
  for (const MainsScenario& scenario : steady_scenarios()) {
    PhaseTracker tracker{{}};
    MainsSource source(scenario, 50.0, 0.2, 1);
    feed(tracker, source, 50000);
    int suspicious = 0;
    for (int n = 0; n < 150000; ++n) {
      tracker.push(source.next());
      suspicious += tracker.suspicious() ? 1 : 0;
    }
    INFO(scenario.name);
    CHECK(suspicious == 0);
  }
}
