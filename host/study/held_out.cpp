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

struct Weighted {
  double value, weight;
};

/// The value below which `share` of the weight lies, linear between the middles of the members' weights.
double quantile(const std::vector<Weighted>& sorted, double total, double share) {
  double below = 0;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const double middle = (below + 0.5 * sorted[k].weight) / total;
    if (middle >= share && k == 0) return sorted[0].value;
    if (middle >= share) {
      const double before = (below - 0.5 * sorted[k - 1].weight) / total;
      const double part = (share - before) / (middle - before);
      return sorted[k - 1].value + part * (sorted[k].value - sorted[k - 1].value);
    }
    below += sorted[k].weight;
  }
  return sorted.back().value;
}

Band band(std::vector<Weighted> values, double asked) {
  double total = 0;
  for (const auto& v : values) total += v.weight;
  if (!(total > 0) || 2 * total < asked) return {};
  std::sort(values.begin(), values.end(),
            [](const Weighted& a, const Weighted& b) { return a.value < b.value; });
  return {quantile(values, total, 0.16), quantile(values, total, 0.5), quantile(values, total, 0.84)};
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
  Others bounce;
  for (const auto& c : others) bounce.add(c.bounce.value, c.bounce.u);
  return {p.touch, with_others(p.bounce, bounce), p.settled, p.seat};
}

Prediction predict(std::span<const sim::Specimen> list, const Conditions& conditions,
                   std::span<const double> weights) {
  std::vector<Weighted> touch, bounce, settled, seat;
  double asked = 0;
  for (std::size_t k = 0; k < list.size(); ++k) {
    const double weight = weights.empty() ? 1 : weights[k];
    asked += weight;
    const auto t = sim::simulate(list[k], conditions, duration, 0).truth;
    if (!t.touch || !t.core_seat) continue;
    touch.push_back({*t.touch, 1});
    bounce.push_back({*t.settled - *t.touch, weight});
    settled.push_back({*t.settled, weight});
    seat.push_back({*t.core_seat, 1});
  }
  const auto all = static_cast<double>(list.size());
  return {band(touch, all), band(bounce, asked), band(settled, asked), band(seat, all)};
}

ClosingProvider held_out_provider(const FitFile& file, const Conditions& conditions) {
  return [file, conditions](double theta_deg) {
    PublishedView v;
    for (const auto& fold : file.folds) {
      if (!fold.held_out || std::fabs(std::remainder(*fold.held_out - theta_deg, 360)) > 1e-6) continue;
      Conditions c = conditions;
      c.closing_angle = radians(theta_deg);
      const Prediction p = pooled(predict(specimens(file, fold), c, fold.weights),
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
