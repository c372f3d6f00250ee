#include "bench/phase_scenarios.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {

namespace {

struct Harmonic {
  int order;
  double share;
  double turns;
};
// Shares of 8 : 5 : 3 : 1.5, normalised to a root sum of squares of one; phases fixed and unrelated.
constexpr std::array<Harmonic, 4> harmonics = {
    {{3, 0.80403, 0.11}, {5, 0.50252, 0.37}, {7, 0.30151, 0.73}, {11, 0.15076, 0.52}}};

}  // namespace

const std::vector<MainsScenario>& steady_scenarios() {
  static const std::vector<MainsScenario> rows = {
      {.name = "clean", .must_now = 0.05, .must_ahead = 0.05, .goal_now = 0.05, .goal_ahead = 0.05},
      {.name = "ramp 1 Hz/s",
       .must_now = 0.2,
       .must_ahead = 0.5,
       .goal_now = 0.1,
       .goal_ahead = 0.25,
       .ramp = 1},
      {.name = "THD 10 %",
       .must_now = 0.1,
       .must_ahead = 0.1,
       .goal_now = 0.05,
       .goal_ahead = 0.05,
       .distortion = 0.1},
      {.name = "noise 1 %",
       .must_now = 0.4,
       .must_ahead = 0.6,
       .goal_now = 0.2,
       .goal_ahead = 0.3,
       .noise = 0.01},
      {.name = "offset 5 %",
       .must_now = 0.05,
       .must_ahead = 0.05,
       .goal_now = 0.025,
       .goal_ahead = 0.025,
       .offset = 0.05},
      {.name = "notches 40 %",
       .must_now = 0.3,
       .must_ahead = 0.3,
       .goal_now = 0.15,
       .goal_ahead = 0.15,
       .notch_depth = 0.4},
      {.name = "interharmonic 1 %",
       .must_now = 0.6,
       .must_ahead = 0.9,
       .goal_now = 0.3,
       .goal_ahead = 0.45,
       .interharmonic = 0.01},
      {.name = "all together",
       .must_now = 0.8,
       .must_ahead = 1.0,
       .goal_now = 0.4,
       .goal_ahead = 0.5,
       .distortion = 0.1,
       .noise = 0.01,
       .offset = 0.05,
       .notch_depth = 0.4,
       .interharmonic = 0.01},
  };
  return rows;
}

const std::vector<MainsScenario>& harder_scenarios() {
  static const std::vector<MainsScenario> rows = {
      {.name = "all and ramp",
       .ramp = 1,
       .distortion = 0.1,
       .noise = 0.01,
       .offset = 0.05,
       .notch_depth = 0.4,
       .interharmonic = 0.01},
      {.name = "wide notches (3.6 deg at 60)", .notch_depth = 0.4, .notch_start = 60, .notch_width = 3.6},
      {.name = "noise 1 % to 50 kHz", .noise = 0.01, .wide_noise = true},
      {.name = "noise 2 %", .noise = 0.02},
      {.name = "interharmonic 1 % at 0.7 f", .interharmonic = 0.01, .interharmonic_order = 0.7},
      {.name = "interharmonic 1 % at 1.2 f", .interharmonic = 0.01, .interharmonic_order = 1.2},
      {.name = "interharmonic 1 % at 1.3 f", .interharmonic = 0.01, .interharmonic_order = 1.3},
      {.name = "interharmonic 1 % at 1.7 f", .interharmonic = 0.01, .interharmonic_order = 1.7},
      {.name = "interharmonic 1 % at 2.5 f", .interharmonic = 0.01, .interharmonic_order = 2.5},
      {.name = "interharmonic 1 % at 3.5 f", .interharmonic = 0.01, .interharmonic_order = 3.5},
  };
  return rows;
}

double Noise::uniform() {
  // splitmix64
  state_ += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
}

double Noise::normal() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

MainsSource::MainsSource(const MainsScenario& scenario, double hertz, double start_turns, std::uint64_t seed)
    : scenario_(scenario), hertz_(hertz), start_turns_(start_turns), ramp_(scenario.ramp), noise_(seed) {
  if (hertz + ramp_ * (ramp_end - ramp_start) > 65.0) ramp_ = -ramp_;  // stays within 45 .. 65 Hz
}

double MainsSource::hertz_at(double t) const {
  const double ramped = std::clamp(t, ramp_start, ramp_end) - ramp_start;
  return hertz_ + ramp_ * ramped + (t >= event_start ? scenario_.step : 0.0);
}

double MainsSource::phase(double t) const {
  const double ramped = std::clamp(t, ramp_start, ramp_end) - ramp_start;
  double turns = start_turns_ + hertz_ * t + 0.5 * ramp_ * ramped * ramped;
  if (t > ramp_end) turns += ramp_ * (ramp_end - ramp_start) * (t - ramp_end);
  if (t >= event_start) turns += scenario_.jump / 360.0 + scenario_.step * (t - event_start);
  return turns;
}

double MainsSource::waveform(double t) {
  const double turns = phase(t);
  double value = std::sin(2 * pi * turns);
  for (const Harmonic& h : harmonics) {
    value += scenario_.distortion * h.share * std::sin(2 * pi * (h.order * turns + h.turns));
  }
  if (scenario_.notch_depth > 0) {
    const double degrees_in = (turns - std::floor(turns)) * 360.0;
    const double in_sixth = std::fmod(degrees_in - scenario_.notch_start + 360.0, 60.0);
    if (in_sixth < scenario_.notch_width)
      value -= std::copysign(scenario_.notch_depth, std::sin(2 * pi * turns));
  }
  value += scenario_.offset;
  value += scenario_.interharmonic * std::sin(2 * pi * (scenario_.interharmonic_order * hertz_ * t + 0.2));
  if (t >= event_start && t < event_end) value *= scenario_.dip;
  return value;
}

std::int16_t MainsSource::next() {
  double value = waveform(static_cast<double>(index_) / mains_rate);
  if (scenario_.noise > 0) {
    if (scenario_.wide_noise || index_ % 10 == 3)
      held_noise_ = noise_.normal() * scenario_.noise / std::sqrt(2.0);
    value += held_noise_;
  }
  ++index_;
  const double steps = std::round(value * mains_counts / 16.0);
  return static_cast<std::int16_t>(std::clamp(steps, -2048.0, 2047.0) * 16.0);
}

}  // namespace powbench::bench
