#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/study/metrics.h"
#include "sim/team.h"

/// Many closings: sweeps, sensitivities, the best closing angle.

namespace powbench::sim {

/// Simulates points of a design. A result depends on its point alone, and is handed over with its place in `points` as
/// soon as it is known: one at a time, on any thread of the team, roughly in order. Nothing more is begun once `go_on`
/// says no; what is begun is ended.
void stream_points(const Design&, const Case& base, std::span<const std::int64_t> points,
                   const MetricOptions&, Team&,
                   const std::function<void(std::size_t place, const ClosingMetrics&)>& sink,
                   const std::function<bool()>& go_on);

/// d metric / d variable by a central difference. NaN where a side does not close.
struct Sensitivity {
  double angle = 0;                      ///< rad
  std::string name;                      ///< variable
  double step = 0;                       ///< half width, in the unit of the name
  double low = 0, centre = 0, high = 0;  ///< of the metric at - step, 0, + step; SI
};
struct SensitivityStep {
  std::string name;
  double step = 0;  ///< in the unit of the name; relative when `relative`
  bool relative = false;
};
/// Mains 1 %, coil 10 K, angle 1 deg, friction 10 %, core mass 1 %, contact gap 1 %.
std::vector<SensitivityStep> usual_steps();
std::vector<Sensitivity> sensitivities(const Case& base, std::span<const double> angles,
                                       std::span<const SensitivityStep>, const MetricInfo&,
                                       const MetricOptions&, Team&);

/// The closing angle with the smallest mean of a metric over draws of a device with tolerances; the same draws serve
/// every angle. Means are of the devices that close; an angle at which fewer close is not the best. Where none closes
/// at any angle there is no best: `closed` is 0 everywhere.
struct BestAngle {
  std::vector<double> angles;           ///< rad, over half a mains period
  std::size_t draws = 0;                ///< devices
  std::vector<std::size_t> closed;      ///< of them at each angle
  std::vector<double> mean;             ///< of the metric at each; SI; NaN where none closes
  std::vector<double> deviation;        ///< of single closings
  std::vector<double> low, high;        ///< 95 % of the mean, bootstrap over draws
  std::vector<std::size_t> mode_count;  ///< at each angle
  std::size_t best = 0;
  double confidence = 0;       ///< share of bootstraps whose best angle lies within `near` of the best
  double near = 0;             ///< rad
  double first = 0, last = 0;  ///< rad: angles that 95 % of the bootstraps choose from, about the best
  double random_mean = 0;      ///< over all angles: closing at random
  double gain = 0;             ///< 1 - mean[best] / random_mean
  double gain_low = 0, gain_high = 0;  ///< 95 %
};
struct BestAngleOptions {
  int angles = 90;
  int draws = 60;
  int bootstraps = 1000;
  double near = 0.0873;  ///< rad, 5 deg
  std::uint64_t seed = 1;
};
BestAngle best_angle(const Case& base, const std::vector<Axis>& tolerances, const MetricInfo&,
                     const MetricOptions&, const BestAngleOptions&, Team&,
                     const std::function<bool(std::int64_t done, std::int64_t of)>& go_on = {});

}  // namespace powbench::sim
