#include <catch2/catch.hpp>
#include <cmath>

#include "bench/phase_calibration.h"
#include "tests/effort.h"

/// What the tracker says of its own error, on mains it was not made for. Draws of the tuning seeds: the scoring seeds
/// are kept for bench_phase_calibration.

using namespace powbench::bench;

namespace {

/// Under the sanitizers a quarter of the draws.
FamilyScore score_of(std::string_view family, int draws) {
  if (powbench::effort::every > 1) draws = (draws + 3) / 4;
  FamilyScore sum;
  for (int i = 0; i < draws; ++i) sum.add(judge_case(draw_case(family, Draws::tuning, 100 + i)));
  return sum;
}

double share(std::int64_t part, std::int64_t all) {
  return static_cast<double>(part) / static_cast<double>(all);
}

}  // namespace

TEST_CASE("of all valid estimates 999 in 1000 are within a degree 20 ms later", "[phase]") {
  FamilyScore all;
  for (const std::string_view family : family_names()) {
    const FamilyScore score = score_of(family, 4);
    INFO(family << ": " << score.beyond << " of " << score.valid << " valid estimates beyond a degree");
    // the first milliseconds after a jump are in, and nothing causal can know them
    CHECK(share(score.beyond, score.valid) <= 0.003);
    all.add(score);
  }
  INFO(all.beyond << " of " << all.valid << " valid estimates beyond a degree; " << all.shots_outside
                  << " of " << all.shots << " shots beyond a degree and three deviations, worst "
                  << all.worst_shot);
  CHECK(share(all.beyond, all.valid) <= 0.001);
  CHECK(all.shots_outside == 0);
  CHECK(share(all.valid, all.judged) >= 0.9);
}

TEST_CASE("the stated uncertainty is the size of the error where the mains is noisy or moves", "[phase]") {
  for (const char* family : {"noise 0.5..3 %", "frequency noise", "spikes"}) {
    const FamilyScore score = score_of(family, 10);
    INFO(family << ": error / u " << score.u_now.deviation() << " now, " << score.u_ahead.deviation()
                << " 20 ms ahead; within 1.96 u " << score.u_now.coverage() << ", "
                << score.u_ahead.coverage());
    for (const Calibration* u : {&score.u_now, &score.u_ahead}) {
      CHECK(u->deviation() >= 0.6);
      CHECK(u->deviation() <= 1.25);
      CHECK(u->coverage() >= 0.92);
    }
  }
}

TEST_CASE("what does not move the phase leaves it valid", "[phase]") {
  struct Row {
    const char* name;
    void (*disturb)(MainsCase&);
    double least = 0.95;  ///< share of valid estimates
  };
  const Row rows[] = {
      {"flicker 5 %", [](MainsCase& c) { c.flicker = 0.05, c.flicker_hertz = 8.8; }},
      {"PWM ripple 10 %",
       [](MainsCase& c) {
         c.tones.push_back({3000, 0.10, 0.3});
       }},
      {"notches 90 % of 600 us",
       [](MainsCase& c) { c.notch_depth = 0.9, c.notch_seconds = 600e-6, c.notch_start = 30; }},
      {"ripple control 3 %, keyed",
       [](MainsCase& c) {
         c.tones.push_back({.hertz = 216.67, .share = 0.03, .turns = 0.3, .period = 1, .from = 0, .to = 0.5});
       },
       0.93},  // each of its edges might have been a jump of the phase: 35 ms
      {"subharmonic 3 %", [](MainsCase& c) {
         c.tones.push_back({c.track[0] / 2, 0.03, 0.2});
       }}};
  for (const Row& row : rows) {
    for (const double hertz : {50.0, 60.0}) {
      MainsCase c = plain_case(hertz, 4);
      c.noise = 0.001;
      row.disturb(c);
      const FamilyScore score = judge_case(c);
      INFO(row.name << " at " << hertz << " Hz: worst " << score.now[0].worst << " deg now, "
                    << score.ahead[0].worst << " deg 20 ms ahead");
      CHECK(share(score.valid, score.judged) >= row.least);
      CHECK(score.ahead[0].worst < 1.0);
    }
  }
}

TEST_CASE("a tone beside the fundamental is in the stated uncertainty, and flicker is not", "[phase]") {
  for (const double beat : {-3.0, -1.5, 1.5, 3.0}) {
    for (const double hertz : {50.0, 60.0}) {
      MainsCase c = plain_case(hertz, 4);
      c.noise = 0.001;
      c.tones.push_back({hertz + beat, 0.005, 0.2});
      const FamilyScore score = judge_case(c);
      INFO(beat << " Hz from " << hertz << " Hz: error / u " << score.u_now.deviation() << " now, "
                << score.u_ahead.deviation() << " 20 ms ahead");
      REQUIRE(score.valid > 0);
      CHECK(score.u_now.deviation() <= 1.25);
      CHECK(score.u_ahead.deviation() <= 1.25);
    }
  }
  MainsCase c = plain_case(50, 4);
  c.flicker = 0.01, c.flicker_hertz = 3;
  OurTracker ours;
  CaseSource source(c);
  for (int n = 0; n < 200'000; ++n) ours.push(source.next());
  CHECK(ours.tracker.estimate().deviation(0.0F) < 0.02F / 360);
}

TEST_CASE("a bias that no prediction shows is in the stated uncertainty", "[phase]") {
  for (const char* family : {"commutation notches", "clipped and offset"}) {
    const FamilyScore score = score_of(family, 30);
    INFO(family << ": error / u " << score.u_now.deviation() << " now, within 1.96 u "
                << score.u_now.coverage() << ", valid " << share(score.valid, score.judged));
    CHECK(score.u_now.deviation() <= 1.25);
    CHECK(score.u_now.coverage() >= 0.92);
    CHECK(score.beyond == 0);
    CHECK(share(score.valid, score.judged) >= 0.95);
  }
}
TEST_CASE("a subharmonic is in the stated uncertainty of each mains, not of their mean", "[phase]") {
  for (const double order : {0.5, 1.0 / 3}) {
    for (const double hertz : {47.2, 50.0, 52.1, 60.0}) {
      MainsCase c = plain_case(hertz, 4);
      c.noise = 0.001;
      c.tones.push_back({hertz * order, 0.02, 0.2});
      const FamilyScore score = judge_case(c);
      INFO(order << " of " << hertz << " Hz: error / u " << score.u_now.deviation() << " now, "
                 << score.u_ahead.deviation() << " 20 ms ahead");
      CHECK(score.u_now.deviation() <= 1.25);
      CHECK(score.u_ahead.deviation() <= 1.25);
      CHECK(score.u_now.coverage() >= 0.92);
    }
  }
}

TEST_CASE("steps of the amplitude leave the phase valid", "[phase]") {
  for (const double size : {0.012, 0.04, 0.058}) {
    for (const double hertz : {50.0, 60.0}) {
      MainsCase c = plain_case(hertz, 6);
      c.noise = 0.001;
      c.flicker = size, c.flicker_hertz = 2.7, c.flicker_square = true;
      const FamilyScore score = judge_case(c);
      INFO(size << " at " << hertz << " Hz: valid " << share(score.valid, score.judged) << ", worst "
                << score.valid_ahead.worst << " deg");
      CHECK(share(score.valid, score.judged) >= (size > 0.05 ? 0.70 : 0.90));
      CHECK(score.beyond == 0);
    }
  }
}

TEST_CASE("after the small jump of a capacitor the uncertainty covers what is left of it", "[phase]") {
  const FamilyScore score = score_of("capacitor switching", 12);
  INFO("error / u " << score.fair_now.deviation() << " now, " << score.fair_ahead.deviation()
                    << " 20 ms ahead");
  CHECK(score.fair_now.deviation() <= 1.5);
  CHECK(score.fair_ahead.deviation() <= 1.25);
}

TEST_CASE("a window of a mains that moves is taken back to its middle", "[phase]") {
  MainsCase c = plain_case(50, 4);
  for (std::size_t k = 500; k < c.track.size(); ++k) c.track[k] = 50 + 4e-3 * static_cast<double>(k - 500);
  CaseSource source(c);
  OurTracker ours;
  double sum = 0.0;
  int count = 0;
  for (int n = 0; n < 280'000; ++n) {
    ours.push(source.next());
    if (n < 120'000 || (n + 1) % 100 != 0) continue;
    const double turns = ours.say().turns - source.phase(n / mains_rate);
    sum += 360 * (turns - std::floor(turns + 0.5));
    ++count;
  }
  // half of 4 Hz/s times the variance of the window, 0.1307 cycles^2, is 0.038 deg
  CHECK(std::abs(sum / count) < 0.008);
}

TEST_CASE("the deviation grows with the horizon and the bound decides what is valid", "[phase]") {
  using powbench::firmware::PhaseEstimate;
  PhaseEstimate e;
  e.faults = 0;
  e.variance = 1e-8F;
  e.variance_ahead = 4e-7F;
  CHECK(e.deviation(0.0F) == Approx(1e-4).epsilon(1e-4));
  CHECK(e.deviation(PhaseEstimate::ahead_seconds) == Approx(std::sqrt(4e-7)).epsilon(1e-4));
  float before = 0;
  for (float horizon = 0; horizon < 0.06F; horizon += 0.001F) {
    CHECK(e.deviation(horizon) > before);
    before = e.deviation(horizon);
  }
  // 3 u = 0.0019 turns = 0.68 deg 20 ms ahead
  CHECK(e.valid(0.020F, 0.70F / 360));
  CHECK_FALSE(e.valid(0.020F, 0.65F / 360));
  CHECK_FALSE(e.valid(0.040F, 0.70F / 360));
  e.variance_ahead = NAN;
  CHECK_FALSE(e.valid(0.020F, 1.0F));
}
