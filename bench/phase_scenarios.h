#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

/// Disturbed mains with a known phase: what the phase tracker is judged on.

namespace powbench::bench {

inline constexpr double mains_rate = 100000.0;   ///< Hz
inline constexpr double mains_counts = 20000.0;  ///< counts, peak of the nominal mains
inline constexpr std::array<double, 4> mains_hertz = {45.0, 50.0, 60.0, 65.0};

/// One disturbance. Fractions are of the fundamental's peak, except `noise`, which is of its rms.
struct MainsScenario {
  std::string_view name = {};
  double must_now = 0,
         must_ahead = 0;  ///< deg, largest error allowed at the estimate and 20 ms ahead; 0 = none stated
  double goal_now = 0, goal_ahead = 0;  ///< deg
  double ramp = 0;                      ///< Hz/s between ramp_start and ramp_end
  double distortion = 0;                ///< total harmonic distortion: orders 3, 5, 7, 11 as 8 : 5 : 3 : 1.5
  double noise = 0;                     ///< rms, white up to 5 kHz (held for ten samples) unless `wide_noise`
  bool wide_noise = false;              ///< white up to 50 kHz
  double offset = 0;
  double notch_depth = 0;    ///< towards zero, six in a cycle
  double notch_start = 45;   ///< deg after each sixth of a cycle from the rising zero crossing
  double notch_width = 1.8;  ///< deg; 100 us at 50 Hz
  double interharmonic = 0;
  double interharmonic_order = 1.5;  ///< of the start frequency
  double jump = 0;                   ///< deg at event_start
  double step = 0;                   ///< Hz at event_start
  double dip = 1;                    ///< amplitude from event_start to event_end
};

inline constexpr double ramp_start = 0.8, ramp_end = 1.8;          ///< s
inline constexpr double event_start = 1.0037, event_end = 1.1071;  ///< s: at no special phase
inline constexpr double judged_from = 0.5;                         ///< s

/// The rows with limits: clean, ramp, distortion, noise, offset, notches, interharmonic, all together.
const std::vector<MainsScenario>& steady_scenarios();
/// Harder rows without limits.
const std::vector<MainsScenario>& harder_scenarios();

/// Small reproducible generator: the same bits everywhere.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  double uniform();  ///< [0, 1)
  double normal();   ///< sum of twelve uniforms less six: variance 1, tails end at 6

 private:
  std::uint64_t state_;
};

/// Samples of a scenario one after the other.
class MainsSource {
 public:
  /// start_turns: phase at sample 0.
  MainsSource(const MainsScenario& scenario, double hertz, double start_turns, std::uint64_t seed);

  /// Next sample: 12 bits in the upper bits of the word, saturating.
  std::int16_t next();
  /// True phase of the fundamental in turns, not wrapped, at time t (s) as far as it is fixed by the
  /// scenario.
  double phase(double t) const;
  double hertz_at(double t) const;

 private:
  double waveform(double t);

  MainsScenario scenario_;
  double hertz_;
  double start_turns_;
  double ramp_;
  Noise noise_;
  double held_noise_ = 0;
  std::int64_t index_ = 0;
};

}  // namespace powbench::bench
