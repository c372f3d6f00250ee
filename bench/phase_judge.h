#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bench/phase_scenarios.h"

/// Runs a phase estimator against a scenario and keeps its worst errors.

namespace powbench::bench {

/// What any estimator says once a millisecond, at its newest sample.
struct PhaseSay {
  double turns = 0;
  double hertz = 0;
  double rate = 0;         ///< Hz/s
  bool valid = false;      ///< for an edge 20 ms ahead
  bool valid_now = false;  ///< for an edge at once
};

struct SteadyErrors {
  double now = 0;          ///< deg, worst
  double ahead = 0;        ///< deg, worst, 20 ms ahead
  double hertz = 0;        ///< Hz, worst
  double valid_share = 0;  ///< of the judged estimates
};

struct EventErrors {
  double noticed = 0;       ///< s from the event to the first invalid estimate; huge = never
  double worst_before = 0;  ///< deg, largest error of a valid estimate from the event until it is noticed
  double worst_after = 0;   ///< deg, largest error of a valid estimate after that
  double settled = 0;       ///< s from the end of the event until every estimate is valid and within 1 deg
};

inline double degrees_between(double a, double b) {
  const double turns = a - b;
  return std::abs(turns - std::floor(turns + 0.5)) * 360.0;
}

inline constexpr double look_ahead = 0.020;  ///< s
inline constexpr std::int64_t samples_per_say = 100;

/// Estimator: void push(std::int16_t), PhaseSay say() const.
template <class Estimator>
SteadyErrors judge_steady(const MainsScenario& scenario, double hertz, double start_turns,
                          Estimator& estimator, double seconds = 2.2) {
  MainsSource source(scenario, hertz, start_turns, 17 + static_cast<std::uint64_t>(hertz));
  SteadyErrors worst;
  std::int64_t judged = 0;
  std::int64_t valid = 0;
  const auto samples = static_cast<std::int64_t>(seconds * mains_rate);
  for (std::int64_t n = 0; n < samples; ++n) {
    estimator.push(source.next());
    const double t = static_cast<double>(n) / mains_rate;
    if ((n + 1) % samples_per_say != 0 || t < judged_from) continue;
    const PhaseSay say = estimator.say();
    ++judged;
    valid += say.valid ? 1 : 0;
    worst.now = std::max(worst.now, degrees_between(say.turns, source.phase(t)));
    const double predicted = say.turns + say.hertz * look_ahead + 0.5 * say.rate * look_ahead * look_ahead;
    worst.ahead = std::max(worst.ahead, degrees_between(predicted, source.phase(t + look_ahead)));
    worst.hertz = std::max(worst.hertz, std::abs(say.hertz - source.hertz_at(t)));
  }
  worst.valid_share = static_cast<double>(valid) / static_cast<double>(judged);
  return worst;
}

/// `ends`: when the event is over (s): event_start for a jump or a step, event_end for a dip.
template <class Estimator>
EventErrors judge_event(const MainsScenario& scenario, double hertz, double start_turns, double ends,
                        Estimator& estimator) {
  MainsSource source(scenario, hertz, start_turns, 29 + static_cast<std::uint64_t>(hertz));
  EventErrors result;
  result.noticed = 1e9;
  const auto samples = static_cast<std::int64_t>((ends + 0.5) * mains_rate);
  for (std::int64_t n = 0; n < samples; ++n) {
    estimator.push(source.next());
    const double t = static_cast<double>(n) / mains_rate;
    if ((n + 1) % samples_per_say != 0 || t < event_start) continue;
    const PhaseSay say = estimator.say();
    const double error = degrees_between(say.turns, source.phase(t));
    if (!say.valid_now) result.noticed = std::min(result.noticed, t - event_start);
    if (say.valid_now) {
      double& worst = result.noticed < 1e9 ? result.worst_after : result.worst_before;
      worst = std::max(worst, error);
    }
    if (t >= ends && (!say.valid_now || error > 1.0)) result.settled = t - ends;
  }
  return result;
}

}  // namespace powbench::bench
