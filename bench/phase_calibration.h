#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "bench/phase_families.h"
#include "bench/phase_peers.h"

/// Judges an estimator and its stated uncertainty on the drawn families, beside its peers.

namespace powbench::bench {

inline constexpr double stated_tolerance = 1.0;  ///< deg at the instant of the edge
inline constexpr double after_break = 0.15;      ///< s after a break within which nobody is compared
/// s after a break or the onset of a movement within which no estimate can know of it. A fault is to be noticed in 1
/// .. 6 ms; a window of two cycles hears of a movement at its middle, and not at once.
inline constexpr double unknowable_break = 0.006, unknowable_onset = 0.060;

/// Errors in degrees at one horizon.
struct ErrorSum {
  double worst = 0, square = 0;
  std::int64_t count = 0;

  void add(double error) {
    worst = std::max(worst, std::abs(error));
    square += error * error;
    ++count;
  }
  void add(const ErrorSum& other) {
    worst = std::max(worst, other.worst);
    square += other.square;
    count += other.count;
  }
  double rms() const { return count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0.0; }
};

/// What the stated uncertainty says of the errors of valid estimates.
struct Calibration {
  double square = 0;  ///< of error / u
  std::int64_t count = 0, covered = 0;

  void add(double error, double u) {
    square += error * error / (u * u);
    covered += std::abs(error) <= 1.96 * u ? 1 : 0;
    ++count;
  }
  void add(const Calibration& other) {
    square += other.square;
    count += other.count;
    covered += other.covered;
  }
  double deviation() const { return count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0.0; }
  double coverage() const {
    return count > 0 ? static_cast<double>(covered) / static_cast<double>(count) : 0.0;
  }
};

struct FamilyScore {
  std::string family;
  std::int64_t judged = 0;               ///< estimates
  std::int64_t valid = 0;                ///< valid for an edge 20 ms ahead
  std::int64_t valid_soon = 0;           ///< valid for an edge at once
  std::int64_t beyond = 0;               ///< valid, no break before the edge, and beyond the tolerance there
  std::int64_t surprised = 0;            ///< valid, and a break before the edge put it beyond the tolerance
  ErrorSum now[3], ahead[3];             ///< ours, SOGI, zero crossing; away from breaks
  ErrorSum valid_now, valid_ahead;       ///< ours, valid
  Calibration u_now, u_ahead;            ///< all valid estimates without a break before the edge
  Calibration fair_now, fair_ahead;      ///< ... but those that cannot know of a break or an onset yet
  std::int64_t beyond_later = 0;         ///< of `beyond`: those that could know
  std::int64_t shots_outside_later = 0;  ///< of shots_outside: more than 6 ms after a break
  std::int64_t shots = 0, shots_beyond = 0, shots_outside = 0;  ///< fired; beyond the tolerance; + 3 u
  double worst_shot = 0;                                        ///< deg

  void add(const FamilyScore& other);
};

/// Runs one case. The shots are taken from a stream of their own, at random instants, angles and touch delays.
FamilyScore judge_case(const MainsCase&);

}  // namespace powbench::bench
