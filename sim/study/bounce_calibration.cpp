#include "sim/study/bounce_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace powbench::sim {
namespace {

constexpr std::size_t fewest = 3;  // closings that a deviation is worth something with

/// Sorts. NaN of none.
double median_of(std::vector<double>& list) {
  if (list.empty()) return BounceCalibration::nan;
  std::sort(list.begin(), list.end());
  const std::size_t half = list.size() / 2;
  return list.size() % 2 ? list[half] : 0.5 * (list[half - 1] + list[half]);
}

struct Squares {
  double sum = 0;
  std::size_t count = 0;
  double root_mean() const {
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : BounceCalibration::nan;
  }
};

/// Each entry against the median of the others; NaN takes no part.
void add_left_out(const std::vector<double>& logs, Squares& squares) {
  std::vector<double> others;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    others.clear();
    for (std::size_t k = 0; k < logs.size(); ++k)
      if (k != i && std::isfinite(logs[k])) others.push_back(logs[k]);
    if (!std::isfinite(logs[i]) || others.size() + 1 < fewest) continue;
    squares.sum += std::pow(logs[i] - median_of(others), 2);
    ++squares.count;
  }
}

std::vector<double> finite(const std::vector<double>& list) {
  std::vector<double> kept;
  for (const double v : list)
    if (std::isfinite(v)) kept.push_back(v);
  return kept;
}

}  // namespace

BounceCalibration calibrate_bounce(std::span<const std::vector<double>> simulated,
                                   std::span<const double> measured) {
  BounceCalibration c;
  Squares draws, plain;
  std::vector<double> logs(measured.size());
  for (const auto& draw : simulated) {
    for (std::size_t i = 0; i < logs.size(); ++i) logs[i] = std::log(measured[i] / draw[i]);
    auto known = finite(logs);
    c.factors.push_back(known.empty() ? 1 : std::exp(median_of(known)));
    add_left_out(logs, draws);
  }
  for (std::size_t i = 0; i < logs.size(); ++i) logs[i] = std::log(measured[i]);
  add_left_out(logs, plain);
  auto known = finite(logs);
  if (!known.empty()) c.median = std::exp(median_of(known));
  c.deviation = draws.root_mean();
  c.median_deviation = plain.root_mean();
  return c;
}

PooledBounce pooled_bounce(double own, const BounceCalibration& c) {
  const double v = c.deviation * c.deviation, u = c.median_deviation * c.median_deviation;
  if (!(u + v > 0)) return {own, c.deviation};
  const double w = u / (u + v);
  return {std::exp(w * std::log(own) + (1 - w) * std::log(c.median)), std::sqrt(w * v)};
}

}  // namespace powbench::sim
