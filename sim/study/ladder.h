#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/models/rung.h"

/// The rungs a closing can be simulated on, and the choice among them: what each costs, how far it is off, and how far
/// it believes to be off.

namespace powbench::sim {

/// Its own settings, or tolerances from `coarsest` down to `finest`, each a tenth of the one before.
std::vector<double> settings_of(const Rung&, double coarsest, double finest);

/// CPU time, s, from anywhere: this folder knows no clock.
using CpuClock = std::function<double()>;

/// Touch, seat and settled of a closing, or errors of them; s. NaN: did not happen.
using LadderTimes = std::array<double, 3>;
inline constexpr std::array<std::string_view, 3> ladder_quantities{"touch", "seat", "settled"};

/// The largest of three errors, s; those that are NaN do not count.
double largest(const LadderTimes&);

struct LadderRun {
  std::size_t rung = 0;  ///< number in the list of rungs
  double tolerance = 0;  ///< or the rung's other setting
  LadderTimes times{};
  std::size_t openings = 0;
  std::int64_t evaluations = 0;
  double cpu = 0;  ///< s
};

/// The cheapest of `repeats` equal runs.
LadderRun run_rung(std::span<const Rung>, std::size_t rung, const Case&, double duration, double tolerance,
                   const CpuClock&, int repeats = 1);

/// |a - b| of each time. NaN where neither has it, infinite where only one has it.
LadderTimes time_error(const LadderRun& a, const LadderRun& b);

/// How far a run is off, judged by the same rung at a tenth of its tolerance, or its next finer setting:
/// `estimator_factor` times the difference, and not less than the rounding of a time, 1e-12 s. Holds where the finer
/// run has at most 0.6 of the error.
LadderTimes error_estimate(const LadderRun&, const LadderRun& finer);
inline constexpr double estimator_factor = 2.5;

/// How far a run is off for its model, s: |run - other| and the step error of the other, for that run does not show
/// its own model either. NaN: not known. Infinite where only one has the time.
LadderTimes model_difference(const LadderRun&, const LadderRun& other,
                             const LadderTimes& step_error_of_other);

struct LadderRow {
  LadderRun run;
  LadderTimes estimate{};   ///< from the same rung at a tenth of the tolerance
  LadderTimes error{};      ///< against the same rung at the truth's tolerance
  bool same_train = false;  ///< as many re-openings as the truth
};
/// How far two rungs are apart at the truth's tolerance: what no refinement of the step removes.
struct ModelDifference {
  std::size_t rung = 0, other = 0;
  LadderTimes difference{};
};
struct Ladder {
  std::vector<LadderRow> rows;  ///< rung by rung, coarse to fine
  std::vector<ModelDifference> models;
};
struct LadderOptions {
  double duration = 0.08;  ///< s simulated
  std::vector<double> tolerances{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
  double truth = 1e-12;  ///< tolerance of what counts as true
  int repeats = 3;       ///< the cheapest counts
};
/// One run of a ladder: a rung at a tolerance or its other setting. Where `cpu` of the result counts, the cheapest of
/// `repeats`.
using LadderCell = std::function<std::optional<LadderRun>(std::size_t rung, double setting, int repeats)>;

/// A rung with settings of its own is run at those, the last of them standing for the truth.
/// Throws std::invalid_argument for a bad case, no rung, or tolerances that do not fall by ten from one to the next.
/// `cell` takes the place of the runs, which do not depend on each other; without all of them there is no ladder.
std::optional<Ladder> run_ladder(std::span<const Rung>, const LadderOptions&, const LadderCell& cell);
Ladder run_ladder(std::span<const Rung>, const Case&, const LadderOptions&, const CpuClock&);

/// What was taken for a wanted accuracy.
struct RungChoice {
  bool met = false;
  LadderRun run;  ///< taken; the one with the smallest estimate where `met` is false
  LadderTimes estimate{};
  double relative = 0;           ///< the largest estimate as a share of the touch time
  double spent = 0;              ///< s CPU, all runs
  std::vector<LadderRow> tried;  ///< with estimates; errors stay zero
};
/// The cheapest rung and tolerance whose estimate is at most `accuracy` times the touch time (the duration where
/// nothing touches) in touch, seat and settled. Every rung is refined, by ten or to its next setting, until it meets
/// the accuracy, costs more than one that has met it, or comes to `finest`. Throws std::invalid_argument for an
/// accuracy outside 1e-10 .. 0.5.
RungChoice choose_rung(std::span<const Rung>, const Case&, double accuracy, double duration, const CpuClock&,
                       double coarsest = 1e-4, double finest = 1e-11);

}  // namespace powbench::sim
