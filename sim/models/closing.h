#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/conditions.h"
#include "sim/models/plant.h"
#include "sim/models/stages.h"

/// One closing of the plant alone: no rig, no sensors, no firmware. The coil is switched on at t = 0 exactly.

namespace powbench::sim {

/// One interval in which the measured pole was open again during the closing, s.
struct Opening {
  double release = 0;
  double touch = 0;
};

/// What happened, from the located events. Times in s after switch-on. The measured pole is closed when both
/// its breaks are. Only what happens before the coil is switched off again counts as closing.
struct ClosingTruth {
  std::optional<double> touch;         ///< first touch of the measured pole (t_ct1)
  std::optional<double> settled;       ///< its last touch (t_ct2)
  std::optional<double> touch_a;       ///< first touch of break A
  std::optional<double> touch_b;       ///< first touch of break B
  std::vector<Opening> openings;       ///< of the measured pole, between `touch` and `settled`
  std::optional<double> core_seat;     ///< first arrival of the core at its stop (t_xt1)
  std::optional<double> core_settled;  ///< last arrival (t_xt2)
  double touch_velocity = 0;           ///< m/s, bridge against fixed contact at the first touch
  double seat_velocity = 0;            ///< m/s, core against stop at `core_seat`
  std::optional<double> opened;        ///< release of the measured pole after the coil was switched off
  double calm =
      0;  ///< s the pole had been closed without a break when the coil was switched off; 0: open then
  double peak_current = 0;  ///< A, largest magnitude among the samples
};

struct Trajectory {
  std::vector<PlantSample> samples;
  std::vector<PlantEvent> events;
  ClosingTruth truth;
  std::vector<StageTime> stages;  ///< those reached; by the rigid rung only
  std::int64_t evaluations = 0;   ///< of the right-hand side
  std::int64_t field_states =
      0;  ///< states of the magnet in the steps taken, where fields of their own were given
  std::int64_t field_beyond = 0;  ///< of these, extrapolated: outside of what the fields were made from
  double energy_residual = 0;
  double supplied = 0;  ///< J, by the mains; 0 without a ledger
};

/// The pole, closed at `end` in s, had been closed for as long before and opened again, or nearly so (1.5 times): its
/// last touch is not where it settles.
bool chatters(const ClosingTruth&, double end);

/// Mains and options a plant needs for these conditions: volts, hertz and phase are theirs, the rest is the bench's.
Mains closing_mains(const Conditions&, const Mains& bench = {});
PlantOptions closing_options(const Conditions&,
                             double relative_tolerance = PlantOptions{}.relative_tolerance);

/// The plant that `simulate` advances, its coil commanded on at t = 0. Throws as `simulate` does.
Plant closing_plant(const Specimen&, const Conditions&, double relative_tolerance, const Supply& bench);

/// Simulates `duration` s from the command at t = 0, with which an ideal switch closes; the command goes off at
/// conditions.hold_time. Samples at k * sample_dt, k = 1, 2, ...; sample_dt = 0: none. `bench`: source impedance,
/// harmonics, dips and switch. Throws std::invalid_argument for a bad specimen, bad conditions or a bad supply.
Trajectory simulate(const Specimen&, const Conditions&, double duration, double sample_dt,
                    double relative_tolerance = PlantOptions{}.relative_tolerance, const Supply& bench = {});

/// The truth of a specimen that a search tries: empty, as if nothing closed, where the specimen is not usable or the
/// integration fails.
ClosingTruth tried_closing(const Specimen&, const Conditions&, double duration,
                           double relative_tolerance = PlantOptions{}.relative_tolerance);

/// Another model in the place of the plant, by its name: the truth of a specimen that a search tries, as
/// `tried_closing` gives it. Called from several threads.
struct ClosingModel {
  std::string name;
  std::function<ClosingTruth(const Specimen&, const Conditions&, double duration, double relative_tolerance)>
      run;
};

/// The truth in a list of events; `off` is the time the coil was switched off, s.
ClosingTruth closing_truth(std::span<const PlantEvent> events, double off);

}  // namespace powbench::sim
