#include "host/study/held_out.h"

#include <algorithm>
#include <cmath>

#include "host/compare/student.h"
#include "sim/study/closings_in_lanes.h"

namespace powbench::host {
namespace {

constexpr double duration = 0.060;  // s

double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(at);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (at - std::floor(at)) * (sorted[k + 1] - sorted[k]);
}

Band band(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {quantile(values, 0.16), quantile(values, 0.5), quantile(values, 0.84)};
}

/// Quantile of equal parts of normal distributions about `values`, deviation `u` > 0; to u / 1e9.
double spread_quantile(const std::vector<double>& values, double u, double share) {
  const auto below = [&](double x) {
    double sum = 0;
    for (const double v : values) sum += 0.5 * std::erfc((v - x) / (u * std::sqrt(2.0)));
    return sum / static_cast<double>(values.size());
  };
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  double low = *least - 9 * u, high = *most + 9 * u;
  while (high - low > 1e-9 * u) {
    const double middle = 0.5 * (low + high);
    (below(middle) < share ? low : high) = middle;
    if (middle == 0.5 * (low + high)) break;
  }
  return 0.5 * (low + high);
}

/// The median is that of the values: a deviation to both sides does not move what is predicted.
Band measured_band(const std::vector<double>& values, Band b, double u) {
  if (!(u > 0)) return b;
  b.low = std::min(b.median, spread_quantile(values, u, 0.16));
  b.high = std::max(b.median, spread_quantile(values, u, 0.84));
  return b;
}

Band relative_band(const std::vector<double>& values, double relative) {
  const Band b = band(values);
  return measured_band(values, b, relative * b.median);
}

Band sum(const Band& a, const Band& b) {
  const double middle = a.median + b.median;
  return {middle - std::hypot(a.median - a.low, b.median - b.low), middle,
          middle + std::hypot(a.high - a.median, b.high - b.median)};
}

}  // namespace

Prediction predict(std::span<const sim::Specimen> list, const Conditions& conditions,
                   const std::optional<sim::BounceCalibration>& calibration, const OneMeasured& one,
                   const sim::ClosingModel& model) {
  std::vector<double> touch, bounce, settled, seat, overtravel_time;
  std::vector<sim::Attempt> attempts;
  for (const auto& s : list) attempts.push_back({&s, &conditions, duration});
  sim::Team alone(1);
  const auto truths = sim::tried_closings(attempts, sim::PlantOptions{}.relative_tolerance, alone, model);
  for (std::size_t k = 0; k < list.size(); ++k) {
    const sim::ClosingTruth& t = truths[k];
    if (!t.touch || !t.core_seat) continue;
    touch.push_back(*t.touch);
    bounce.push_back((*t.settled - *t.touch) * (calibration ? calibration->factors[k] : 1));
    settled.push_back(*t.settled);
    seat.push_back(*t.core_seat);
    overtravel_time.push_back(*t.core_seat - *t.touch);
  }
  if (touch.empty() || 2 * touch.size() < list.size()) return {};
  Prediction p{relative_band(touch, one.touch), band(bounce), band(settled), relative_band(seat, one.seat),
               measured_band(overtravel_time, band(overtravel_time), one.overtravel_time)};
  if (!calibration) return p;
  const auto pooled = sim::pooled_bounce(p.bounce.median, *calibration, conditions.closing_angle);
  if (std::isfinite(pooled.deviation)) {
    const double law = sim::bounce_core * coverage_factor(sim::bounce_tail, 0.68);
    const double side = std::exp(law * pooled.deviation);
    p.bounce = {pooled.value / side, pooled.value, pooled.value * side};
  }
  p.settled = sum(p.touch, p.bounce);
  return p;
}

ClosingProvider held_out_provider(const FitFile& file, const Conditions& conditions) {
  return [file, conditions](double theta_deg) {
    PublishedView v;
    for (const auto& fold : file.folds) {
      if (!fold.held_out || std::fabs(std::remainder(*fold.held_out - theta_deg, 360)) > 1e-6) continue;
      Conditions c = conditions;
      c.closing_angle = radians(theta_deg);
      const Prediction p = predict(specimens(file, fold), c, fold.bounce);
      v.t_ct1 = p.touch.median;
      v.t_ct_bon = p.bounce.median;
      v.t_ct2 = p.settled.median;
      v.t_xt1 = p.seat.median;
    }
    return v;
  };
}

}  // namespace powbench::host
