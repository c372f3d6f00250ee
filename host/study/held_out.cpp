#include "host/study/held_out.h"

#include <algorithm>
#include <cmath>

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

Band sum(const Band& a, const Band& b) {
  const double middle = a.median + b.median;
  return {middle - std::hypot(a.median - a.low, b.median - b.low), middle,
          middle + std::hypot(a.high - a.median, b.high - b.median)};
}

}  // namespace

Prediction predict(std::span<const sim::Specimen> list, const Conditions& conditions,
                   const std::optional<sim::BounceCalibration>& calibration) {
  std::vector<double> touch, bounce, settled, seat;
  std::vector<sim::Attempt> attempts;
  for (const auto& s : list) attempts.push_back({&s, &conditions, duration});
  sim::Team alone(1);
  const auto truths = sim::tried_closings(attempts, sim::PlantOptions{}.relative_tolerance, alone);
  for (std::size_t k = 0; k < list.size(); ++k) {
    const sim::ClosingTruth& t = truths[k];
    if (!t.touch || !t.core_seat) continue;
    touch.push_back(*t.touch);
    bounce.push_back((*t.settled - *t.touch) * (calibration ? calibration->factors[k] : 1));
    settled.push_back(*t.settled);
    seat.push_back(*t.core_seat);
  }
  if (touch.empty() || 2 * touch.size() < list.size()) return {};
  Prediction p{band(touch), band(bounce), band(settled), band(seat)};
  if (!calibration) return p;
  const auto pooled = sim::pooled_bounce(p.bounce.median, *calibration, conditions.closing_angle);
  if (std::isfinite(pooled.deviation)) {
    const double side = std::exp(pooled.deviation);
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
