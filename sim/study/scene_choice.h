#pragma once

#include <cstdint>
#include <limits>

#include "sim/models/mechanics.h"
#include "sim/study/ladder.h"

/// Which fields and which mechanics a scene needs. Three errors, three words: the step error, judged by a finer run of
/// the same rung; the model error, that of the fields and that of the mechanics, each the largest distance to a rung
/// above, and together not less than the distance to the highest pair; the input error, by which the stated
/// uncertainties of the inputs move the times. The model error, which contains that of the step, is held against what
/// is wanted; where nothing is compared, the step error is. Where it is too large, the choice climbs along the axis
/// that contributes most. What the highest rung of an axis leaves out is not known, and an unknown is never zero.
/// (docs/decisions/0023-three-errors.md)

namespace powbench::sim {

inline constexpr LadderTimes nan_times{std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN()};

/// Wanted error of touch, seat and settled as a share of the touch time; NaN: not wanted.
using WantedTimes = LadderTimes;

/// The rungs a scene may climb: fields first to last, mechanics first to last. `rung` makes a pair; it is asked only
/// for pairs that are looked at, so that tables are built when they are needed.
struct SceneAxes {
  std::vector<std::string> fields, mechanics;
  std::function<Rung(std::size_t field, std::size_t mechanics)> rung;
  /// The highest fields that the case has, where they are none of `fields`: what those are worth is not known then.
  std::string fields_left_out{};
  /// A measurement of the case, and what the first fields missed it by when it had no part in their identification,
  /// s. NaN: none. The larger of that and of the distance to the measurement is evidence of these fields' error.
  LadderTimes measured{nan_times}, held_out_error{nan_times};
};

/// Whether a wanted accuracy is reached.
enum class Reached : std::uint8_t {
  met,        ///< every error is known, and their sum is within what is wanted
  not_met,    ///< what is known is too large already
  not_known,  ///< what is known is small enough, and something is not known
};
inline constexpr std::array<std::string_view, 3> reached_names{"met", "not met", "not known"};

/// Error of the model along one axis, s: `model_difference`, or a measurement's where that is larger. NaN: there is
/// neither, or the time did not happen.
struct AxisError {
  /// To the rungs above, the largest: the next one may err in the same direction. A choice looks at no further ones
  /// once it is larger than what is wanted.
  LadderTimes above{nan_times};
  /// From the rung below. At the top of the mechanics it stands for the error where it is within what is wanted; of
  /// fields it is no bound: the plane table is on the other side of the circuit than the ends of three dimensions.
  LadderTimes below{nan_times};
};

/// An input (`variable` of sim/study/axis.h) and its standard uncertainty in the unit of its name.
struct InputUncertainty {
  std::string name;
  double u = 0;
};

/// One pair that was looked at.
struct SceneStep {
  std::string name, setting_name;
  LadderRun run;
  LadderTimes step_error{};  ///< s, of the step
  AxisError fields, mechanics;
  /// s, to the highest fields with the highest mechanics: what bending adds with these fields it need not add with
  /// others. NaN: not looked at, or this is that pair.
  LadderTimes to_best{nan_times};
  LadderTimes model_error{};  ///< s, of fields and mechanics together, or `to_best` if larger; NaN: not known
  double share = 0;           ///< largest of the known total errors over what is wanted
  std::array<Reached, 3> by_time{Reached::not_known, Reached::not_known,
                                 Reached::not_known};  ///< where wanted
  Reached reached = Reached::not_known;                ///< of all that are wanted
  std::vector<std::string> unknown;                    ///< what is not known, a clause each
  std::string stopped;                                 ///< why no run came to its end; empty: one did
};

struct SceneChoice {
  Rung rung;                             ///< taken
  double setting = 0;                    ///< its tolerance, step or cell
  std::vector<SceneStep> steps;          ///< what was looked at; the last was taken
  LadderTimes input_error{nan_times};    ///< s, standard, from `inputs`; NaN: not known
  std::vector<InputUncertainty> inputs;  ///< those that were varied
  double spent = 0;                      ///< s CPU, all runs
  Reached reached() const { return steps.back().reached; }
};

/// Standard uncertainty of a time from those of the inputs, s: u^2 = sum (dt/dx u_x)^2 by central differences of one
/// rung. NaN: the time does not happen on both sides of an input, no input is stated, or the rung is a costly one.
LadderTimes input_error(const Rung&, double setting, const Case&, double duration,
                        std::span<const InputUncertainty>, const CpuClock&, double* spent = nullptr);

/// Throws std::invalid_argument for an accuracy outside 1e-9 .. 0.5, or nothing wanted.
SceneChoice choose_scene(const SceneAxes&, const Case&, const WantedTimes&, double duration,
                         std::span<const InputUncertainty>, const CpuClock&);

/// Every pair of the axes, fields first, refined and judged as `choose_scene` does: what each rung is worth. `done` is
/// told how many there are so far. Throws as `choose_scene`.
std::vector<SceneStep> look_at_all(const SceneAxes&, const Case&, const WantedTimes&, double duration,
                                   const CpuClock&, const std::function<void(std::size_t)>& done = {});

}  // namespace powbench::sim
