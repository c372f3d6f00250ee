#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/study/ladder.h"
#include "sim/team.h"

/// Whether the estimate of a rung's step error is true, over random scenes.

namespace powbench::bench {

/// Seeded scenes for the calibration: any angle, 0.85 .. 1.1 of 230 V, coil at -5 .. 60 degC.
std::vector<sim::Case> random_scenes(const sim::Specimen&, int count, std::uint64_t seed);

/// Does the estimate cover the true error? One rung at one tolerance over many scenes.
struct EstimateCoverage {
  std::size_t rung = 0;
  double tolerance = 0;
  std::array<int, 3> happened{};        ///< scenes that have the time
  std::array<int, 3> covered{};         ///< of those, error <= estimate
  std::array<double, 3> worst_error{};  ///< s
  int stopped = 0;                      ///< scenes that a guard stopped: no times
  double cpu = 0;                       ///< s, mean
  double share() const;                 ///< covered of all that happened, three quantities together
};
/// The scenes are shared by the team; the clock is that of a thread.
std::vector<EstimateCoverage> estimator_coverage(std::span<const sim::Rung>, std::span<const sim::Case>,
                                                 const sim::LadderOptions&, const sim::CpuClock&, sim::Team&);

}  // namespace powbench::bench
