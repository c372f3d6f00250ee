#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/study/fit_text.h"
#include "sim/study/sweep.h"

/// Pictures of studies as SVG files.

namespace powbench::host {

/// Touch and bounce of every point over one variable, the closing angle where it varies, else the first: what is
/// bistable shows as two branches.
std::string sweep_svg(const sim::Design&, const std::vector<std::vector<double>>& rows);

/// How far each variable moves the metric: largest change over all angles to either side, and the median one.
std::string sensitivity_svg(std::span<const sim::Sensitivity>, const sim::MetricInfo&);

/// Mean with its 95 % band over the closing angle, angles with more than one mode shaded, the best one marked.
std::string best_angle_svg(const sim::BestAngle&, const sim::MetricInfo&);

/// Touch, bounce, settled and seat over the closing angle: measured, fitted, and held out with its band.
std::string fit_svg(const std::vector<FitCell>&, const std::string& title);

}  // namespace powbench::host
