#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/compare/compare.h"
#include "sim/study/misfit.h"

/// What is measured, as a problem of identification.

namespace powbench::host {

/// Standard deviations that a model of this kind deserves beside those of the measurement; relative but for the core
/// bounce. Defaults: what one published closing is worth. The paper's two tables print one and the same core time
/// 0.8 ms apart (rms over the angles, 90 deg left out), so that one value is good to 0.6 ms, 3 .. 5 %.
struct ModelDeviation {
  double touch = 0.03;
  double seat = 0.03;
  double bounce = 0.15;
  double core_bounce = 0.6e-3;       ///< s
  double overtravel_time = unknown;  ///< of seat - touch; known: a target beside touch and seat
};

/// The closings of table 2, measured values, 230 V 50 Hz. The core row of 90 deg is impossible as printed and left out.
std::vector<sim::MeasuredClosing> published_closings(const ModelDeviation& = {});

/// Mean touch, bounce, seat and, where asked for, overtravel time of every angle of a campaign. Deviations: that of the
/// mean, with that of the model.
std::vector<sim::MeasuredClosing> campaign_closings(std::span<const AngleGroup>, const Conditions&,
                                                    const ModelDeviation&);

/// Relative standard deviation of single shots about the mean of their angle, pooled over the angles; unknown without
/// repeats.
struct ShotScatter {
  double touch = unknown, bounce = unknown, seat = unknown, overtravel_time = unknown;
};
ShotScatter shot_scatter(std::span<const AngleGroup>);

/// Without the closings at the angles listed (rad, equal to 0.01 deg).
std::vector<sim::MeasuredClosing> without(std::vector<sim::MeasuredClosing>, std::span<const double> angles);

}  // namespace powbench::host
