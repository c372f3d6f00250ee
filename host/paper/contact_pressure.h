#pragma once

#include <string>
#include <vector>

#include "sim/models/closing.h"
#include "sim/specimen/specimen.h"

/// Contact pressure of both breaks of the measured pole as the second paper describes it: a train of pulses, then a
/// pulsation with the pull.

namespace powbench::host {

/// One time that a break presses. The last pulse of a train does not end.
struct PressurePulse {
  double begin = 0, end = 0, peak = 0, peak_time = 0;  ///< s, s, N, s
};

struct PressureTrain {
  std::vector<PressurePulse> pulses;
  double settled = 0;  ///< s, begin of the last pulse: pulsation after it is none of them
  double mean = 0;     ///< N, over the last whole period of the mains
  double swing = 0;    ///< N, largest minus smallest there
  double once = 0;     ///< N, amplitude at the mains frequency there: an offset flux that has not died out
  double second = 0;   ///< N, amplitude at twice the mains frequency there

  std::size_t bounces() const { return pulses.empty() ? 0 : pulses.size() - 1; }
  /// s between the begin of pulse k and k + 1; NaN where there is none.
  double interval(std::size_t k) const;
  double peak(std::size_t k) const;  ///< N; NaN likewise
  double largest() const;            ///< N, of all pulses
};

/// Openings shorter than this count as closed: the paper's force is filtered.
inline constexpr double shortest_opening = 0.1e-3;  // s

/// Of break A or B, from samples. A pulse is a stretch of force > 0; pulsation never reaches 0 and is therefore no
/// bounce.
PressureTrain pressure_train(const std::vector<sim::PlantSample>&, bool break_b, double mains_hertz);

inline constexpr double pressure_sample_dt = 10e-6;  // s: pulses on soft pads last half a millisecond

/// The paper's conditions: 220 V, 50 Hz, 17 degC.
Conditions pressure_conditions(double theta_deg);
/// A closing under them.
sim::Trajectory pressure_closing(const sim::Specimen&, double theta_deg, double share_of_volts = 1);

/// The published statements beside two specimens: `level`, both breaks alike and softly padded, against the printed
/// simulation; `tilted`, against the printed measurement. Angles: those of the level and of the tilted train,
/// degrees.
struct PressurePage {
  sim::Specimen level, tilted;
  double level_deg = 0, tilted_deg = 0;
};
std::string pressure_text(const PressurePage&);
std::string pressure_json(const PressurePage&);

}  // namespace powbench::host
