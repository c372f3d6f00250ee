#include "sim/study/bounce_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace powbench::sim {
namespace {

constexpr std::size_t fewest = 3;     // closings that a deviation is worth something with
constexpr double resolution = 20e-6;  // s: what bounces for less does not bounce

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

}  // namespace

BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured) {
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
  return c;
}

double weight_of_samples(const BounceCalibration& c) {
  const double v = c.deviation * c.deviation, u = c.median_deviation * c.median_deviation;
  return u + v == 0 ? 1 : u / (u + v);
}

PooledBounce pooled_bounce(double own, const BounceCalibration& c) {
  const double w = weight_of_samples(c);
  if (!std::isfinite(w)) return {own, BounceCalibration::nan};
  return {std::exp(w * log_of(own) + (1 - w) * std::log(c.median)), std::sqrt(w) * c.deviation};
}

}  // namespace powbench::sim
