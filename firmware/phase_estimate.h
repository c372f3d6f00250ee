#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/phase.h"

/// What is known of the mains, and the instants that follow from it.

namespace powbench::firmware {

/// Why an estimate must not be fired on. One bit each.
enum class PhaseFault : std::uint16_t {
  none = 0,
  warming_up = 1U << 0,     ///< history shorter than the estimator's memory
  amplitude = 1U << 1,      ///< outside 0.7 .. 1.2 of nominal
  frequency = 1U << 2,      ///< outside 45 .. 65 Hz
  residual = 1U << 3,       ///< signal minus fitted fundamental above 15 % rms
  cross_check = 1U << 4,    ///< second estimator differs by more than 3 deg
  third_opinion = 1U << 5,  ///< zero crossing differs by more than 5 deg
  gap = 1U << 6,            ///< samples were lost inside the memory
  disturbed = 1U << 7,      ///< the waveform is not the one of a cycle ago
};

inline constexpr std::array<std::string_view, 8> phase_fault_names{
    "warming_up", "amplitude", "frequency", "residual", "cross_check", "third_opinion", "gap", "disturbed"};

/// Turns in thousandths of a degree, rounded up; at most one turn.
inline std::int32_t to_millidegrees(float turns) {
  return turns < 1.0F ? static_cast<std::int32_t>(turns * 360000.0F) + 1 : 360000;
}

/// The mains fundamental v(n) = amplitude sin(phase + 2 pi frequency (n - sample) / rate), referred to sample
/// index `sample`.
struct PhaseEstimate {
  std::int64_t sample = 0;   ///< sample index the phase refers to
  float phase_turns = 0;     ///< [0, 1): 0 = rising zero crossing
  float frequency = 0;       ///< Hz
  float frequency_rate = 0;  ///< Hz/s
  float amplitude = 0;       ///< counts, peak
  std::uint16_t faults = static_cast<std::uint16_t>(PhaseFault::warming_up);

  float variance = 0;        ///< turns^2: square of the standard uncertainty of the phase at `sample` ...
  float variance_ahead = 0;  ///< ... and at `ahead_seconds` after it

  /// Nothing is wrong with the mains, and the bound at `horizon` (s after `sample`) is within `tolerance` (turns).
  bool valid(float horizon, float tolerance) const {
    return faults == 0 && coverage_factor * deviation(horizon) <= tolerance;
  }
  bool valid() const { return valid(ahead_seconds, usual_tolerance); }
  /// Standard uncertainty of the phase `horizon` s after `sample`, turns.
  float deviation(float horizon) const;

  static constexpr float ahead_seconds = 0.020F;
  static constexpr float usual_tolerance = 1.0F / 360;  ///< turns
  static constexpr float coverage_factor = 3.0F;
};

/// Before anything is known.
inline PhaseEstimate no_estimate(float nominal_hertz) {
  PhaseEstimate estimate;
  estimate.sample = -1;
  estimate.frequency = nominal_hertz;
  return estimate;
}

/// The search for the frequency never leaves these, Hz.
inline constexpr float lowest_hertz = 43.0F, highest_hertz = 67.0F;

inline float clamp_hertz(float hertz) {
  if (!(hertz > lowest_hertz)) return lowest_hertz;
  return hertz < highest_hertz ? hertz : highest_hertz;
}

/// An instant of the sample clock: index and part of a sample, [0, 1).
struct PhaseInstant {
  std::int64_t sample;
  float fraction;
};

/// The first instant at or after sample `earliest` at which the fundamental has phase `target` (0 .. 35999).
/// `rate`: samples a second. The frequency rate counts for `rate_horizon` seconds from the estimate; then the
/// frequency stays. Meaningful only while the estimate is valid; never before `earliest` in any case.
PhaseInstant next_instant(const PhaseEstimate&, float rate, CentiDegrees target, std::int64_t earliest);
inline constexpr float rate_horizon = 0.1F;

}  // namespace powbench::firmware
