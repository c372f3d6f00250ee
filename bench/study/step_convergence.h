#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/study/ladder.h"

/// Whether the times of a rung converge with its tolerance, over scenes nobody chose.

namespace powbench::bench {

struct StepConvergence {
  static constexpr std::array<double, 6> tolerances{1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11};
  static constexpr double truth = 1e-12;  ///< tolerance
  std::size_t rung = 0;
  int computable = 0;      ///< scenes whose bounces are, as `study_bounces` says
  int not_computable = 0;  ///< scenes of which it says the opposite, or which a guard stopped
  int open = 0;            ///< scenes in which no contact closes
  /// s, at each tolerance, of touch, seat and settled: the median and the largest of the computable scenes.
  std::array<sim::LadderTimes, tolerances.size()> median{}, largest{};
  /// Computable scenes with an error above 1 ns and above ten times that of some coarser tolerance.
  std::array<int, 3> grew{};
};

StepConvergence step_convergence(std::span<const sim::Rung>, std::size_t rung, std::span<const sim::Case>,
                                 double duration, const sim::CpuClock&);

}  // namespace powbench::bench
