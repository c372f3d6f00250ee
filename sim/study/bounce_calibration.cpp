#include "sim/study/bounce_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "core/units.h"

namespace powbench::sim {
namespace {

constexpr std::size_t fewest = 3;          // closings that a deviation is worth something with
constexpr std::size_t fewest_angles = 12;  // with 6 the line is hardly better on synthetic devices
constexpr double resolution = 20e-6;       // s: what bounces for less does not bounce

double log_of(double bounce) {
  return std::log(bounce > resolution ? bounce : resolution);  // NaN too
}

/// Sorts; not empty.
double median_of(std::vector<double>& list) {
  std::sort(list.begin(), list.end());
  const std::size_t half = list.size() / 2;
  return list.size() % 2 ? list[half] : 0.5 * (list[half - 1] + list[half]);
}

/// Sum of squared distances of each from the median of the others.
double left_out(const std::vector<double>& logs) {
  double sum = 0;
  std::vector<double> others;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    others = logs;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    sum += std::pow(logs[i] - median_of(others), 2);
  }
  return sum;
}

/// Angles that differ by no more than the firmware's resolution are one; half a period is polarity alone.
double folded(double angle) {
  constexpr double step = pi / 18000;
  const double in_period = angle - pi * std::floor(angle / pi);
  const double rounded = step * std::round(in_period / step);
  return rounded >= pi ? 0 : rounded;
}

/// ln of the bounce on the line between the neighbours of `angle`, of period pi; `without`: an angle left out.
double on_line(const std::vector<BounceCalibration::AtAngle>& line, double angle, double without = -1) {
  const BounceCalibration::AtAngle *before = nullptr, *after = nullptr;
  double back = 0, on = 0;
  for (const auto& a : line) {
    if (a.angle == without) continue;
    const double ahead = a.angle - angle - pi * std::floor((a.angle - angle) / pi);
    const double behind = ahead == 0 ? 0 : pi - ahead;
    if (!after || ahead < on) on = ahead, after = &a;
    if (!before || behind < back) back = behind, before = &a;
  }
  const double share = back + on > 0 ? back / (back + on) : 0;
  return (1 - share) * log_of(before->bounce) + share * log_of(after->bounce);
}

void add_line(BounceCalibration& c, std::span<const double> measured, std::span<const double> angles) {
  std::map<double, std::vector<double>> logs;
  for (std::size_t i = 0; i < measured.size(); ++i)
    if (std::isfinite(measured[i])) logs[folded(angles[i])].push_back(log_of(measured[i]));
  if (logs.size() < fewest_angles) return;
  std::vector<BounceCalibration::AtAngle> line;
  for (auto& [angle, list] : logs) line.push_back({angle, std::exp(median_of(list))});
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [angle, list] : logs) {
    const double told = on_line(line, angle, angle);
    for (const double one : list) sum += std::pow(one - told, 2), ++count;
  }
  const double deviation = std::sqrt(sum / static_cast<double>(count));
  if (deviation >= c.median_deviation) return;
  c.line = std::move(line);
  c.line_deviation = deviation;
}

}  // namespace

BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured, std::span<const double> angles) {
  BounceCalibration c;
  c.factors.assign(simulated.size(), 1.0);
  std::vector<double> plain, logs;
  for (const double m : measured)
    if (std::isfinite(m)) plain.push_back(log_of(m));
  if (plain.empty()) return c;
  double sum = 0;
  for (std::size_t k = 0; k < simulated.size(); ++k) {
    logs.clear();
    for (std::size_t i = 0; i < measured.size(); ++i)
      if (std::isfinite(measured[i])) logs.push_back(log_of(measured[i]) - log_of(simulated[k][i]));
    if (logs.size() >= fewest) sum += left_out(logs);
    c.factors[k] = std::exp(median_of(logs));
  }
  if (plain.size() >= fewest) {
    const auto closings = static_cast<double>(plain.size());
    c.deviation = std::sqrt(sum / (closings * static_cast<double>(simulated.size())));
    c.median_deviation = std::sqrt(left_out(plain) / closings);
  }
  c.median = std::exp(median_of(plain));
  if (!angles.empty()) add_line(c, measured, angles);
  return c;
}

PooledBounce without_model(const BounceCalibration& c, double angle) {
  if (c.line.empty()) return {c.median, c.median_deviation};
  return {std::exp(on_line(c.line, folded(angle))), c.line_deviation};
}

double weight_of_samples(const BounceCalibration& c) {
  const double v = std::pow(c.deviation, 2), u = std::pow(without_model(c, 0).deviation, 2);
  return u + v == 0 ? 1 : u / (u + v);
}

PooledBounce pooled_bounce(double own, const BounceCalibration& c, double angle) {
  const double w = weight_of_samples(c);
  if (!std::isfinite(w)) return {own, BounceCalibration::nan};
  return {std::exp(w * log_of(own) + (1 - w) * std::log(without_model(c, angle).value)),
          std::sqrt(w) * c.deviation};
}

}  // namespace powbench::sim
