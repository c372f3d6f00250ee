#include "host/study/held_out.h"

#include <algorithm>
#include <cmath>

#include "host/study/problem.h"
#include "sim/closing.h"

namespace powbench::host {
namespace {

constexpr double duration = 0.060;  // s

double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(at);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (at - std::floor(at)) * (sorted[k + 1] - sorted[k]);
}

Band band(std::vector<double> values, std::size_t asked) {
  if (values.empty() || 2 * values.size() < asked) return {};
  std::sort(values.begin(), values.end());
  return {quantile(values, 0.16), quantile(values, 0.5), quantile(values, 0.84)};
}

/// What the other angles say of one quantity: values and relative deviations granted.
struct Others {
  std::vector<double> values;
  double deviations = 0;
  void add(double value, double u) {
    if (!std::isfinite(value)) return;
    values.push_back(value);
    deviations += u / value;
  }
};

Band with_others(const Band& b, Others o) {
  const auto n = static_cast<double>(o.values.size());
  if (o.values.size() < 3 || !std::isfinite(b.median)) return b;
  std::sort(o.values.begin(), o.values.end());
  const double m = quantile(o.values, 0.5);
  double mean = 0, spread = 0;
  for (const double x : o.values) mean += x / n;
  for (const double x : o.values) spread += (x - mean) * (x - mean) / (n - 1);
  const double own = std::pow(0.5 * (b.high - b.low), 2) + std::pow(o.deviations / n * b.median, 2);
  if (!(spread + own > 0)) return b;
  const double w = spread / (spread + own);
  return {w * b.low + (1 - w) * m, w * b.median + (1 - w) * m, w * b.high + (1 - w) * m};
}

}  // namespace

Prediction pooled(const Prediction& p, std::span<const sim::MeasuredClosing> others) {
  Others touch, bounce, settled, seat;
  for (const auto& c : others) {
    touch.add(c.touch.value, c.touch.u);
    bounce.add(c.bounce.value, c.bounce.u);
    settled.add(c.touch.value + c.bounce.value, std::hypot(c.touch.u, c.bounce.u));
    seat.add(c.seat.value, c.seat.u);
  }
  return {with_others(p.touch, touch), with_others(p.bounce, bounce), with_others(p.settled, settled),
          with_others(p.seat, seat)};
}

Prediction predict(std::span<const sim::Specimen> list, const Conditions& conditions) {
  std::vector<double> touch, bounce, settled, seat;
  for (const auto& s : list) {
    const auto t = sim::simulate(s, conditions, duration, 0).truth;
    if (!t.touch || !t.core_seat) continue;
    touch.push_back(*t.touch);
    bounce.push_back(*t.settled - *t.touch);
    settled.push_back(*t.settled);
    seat.push_back(*t.core_seat);
  }
  return {band(touch, list.size()), band(bounce, list.size()), band(settled, list.size()),
          band(seat, list.size())};
}

ClosingProvider held_out_provider(const FitFile& file, const Conditions& conditions) {
  return [file, conditions](double theta_deg) {
    PublishedView v;
    for (const auto& fold : file.folds) {
      if (!fold.held_out || std::fabs(std::remainder(*fold.held_out - theta_deg, 360)) > 1e-6) continue;
      Conditions c = conditions;
      c.closing_angle = radians(theta_deg);
      const Prediction p = pooled(predict(specimens(file, fold), c),
                                  without(published_closings(), std::span(&c.closing_angle, 1)));
      v.t_ct1 = p.touch.median;
      v.t_ct_bon = p.bounce.median;
      v.t_ct2 = p.settled.median;
      v.t_xt1 = p.seat.median;
    }
    return v;
  };
}

}  // namespace powbench::host
