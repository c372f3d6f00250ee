#pragma once

#include "sim/study/rungs.h"

/// Which fields and which mechanics a scene needs. Two kinds of error: of the step, judged by a finer run of the same rung;
/// and of the model, judged by the next rung of fields and the next rung of mechanics. Their sum is held against what is
/// wanted; where it is too large, the choice climbs along the axis that contributes most.

namespace powbench::sim {

/// Wanted error of touch, seat and settled as a share of the touch time; NaN: not wanted.
using WantedTimes = LadderTimes;

/// The rungs a scene may climb: fields first to last, mechanics first to last. `rung` makes a pair; it is asked only for
/// pairs that are looked at, so that tables are built when they are needed.
struct SceneAxes {
  std::vector<std::string> fields, mechanics;
  std::function<Rung(std::size_t field, std::size_t mechanics)> rung;
};

/// One pair that was looked at.
struct SceneStep {
  std::string name, setting_name;
  LadderRun run;
  LadderTimes step_error{};       ///< s, of the step
  LadderTimes field_error{};      ///< s, to the next rung of fields; NaN: none to compare with
  LadderTimes mechanics_error{};  ///< s, to the next rung of mechanics; NaN: likewise
  double share = 0;               ///< largest sum of the three over what is wanted; <= 1: good enough
};

struct SceneChoice {
  bool met = false;
  Rung rung;                     ///< taken
  double setting = 0;            ///< its tolerance, step or cell
  std::vector<SceneStep> steps;  ///< what was looked at; the last was taken
  LadderTimes
      twin{};  ///< s by which 0.1 % more mains moves the times: no error below it means anything on a bench
  double spent = 0;  ///< s CPU, all runs
};

/// Throws std::invalid_argument for an accuracy outside 1e-9 .. 0.5, or nothing wanted.
SceneChoice choose_scene(const SceneAxes&, const Case&, const WantedTimes&, double duration, const CpuClock&);

}  // namespace powbench::sim
