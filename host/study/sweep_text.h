#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/study/sweep.h"

/// Sweeps for people and for programs.

namespace powbench::host {

/// Names of the metrics in the order of their table, separated by blanks.
std::string metric_columns();
/// The metrics of a closing in that order, SI.
std::vector<double> metric_values(const sim::ClosingMetrics&);

/// Quantiles and modes of every metric. `rows`: metric values of each point.
std::string sweep_text(const std::vector<std::vector<double>>& rows);
std::string sweep_json(const sim::Design&, const std::vector<std::vector<double>>& rows, bool with_points);

std::string sensitivity_text(std::span<const sim::Sensitivity>, const sim::MetricInfo&);
std::string sensitivity_json(std::span<const sim::Sensitivity>, const sim::MetricInfo&);

std::string best_angle_text(const sim::BestAngle&, const sim::MetricInfo&);
std::string best_angle_json(const sim::BestAngle&, const sim::MetricInfo&);

}  // namespace powbench::host
