#include "host/study/problem.h"

#include <algorithm>
#include <cmath>

#include "core/quantities.h"
#include "host/paper/published.h"

namespace powbench::host {
namespace {

Measured published(const char* quantity, double theta_deg, double relative) {
  const PublishedRow* row = find_published(quantity, theta_deg);
  if (row == nullptr || row->excluded) return {};
  const double value = row->measurement * si_per(row->unit);
  return {value, relative * value};
}

/// Mean of one quantity over repeats; unknown without any.
Measured mean(const std::vector<Events>& shots, std::string_view symbol, double relative) {
  double sum = 0;
  double squares = 0;
  double n = 0;
  for (const auto& e : shots) {
    const Measured m = find_quantity(symbol)->of(e);
    if (!m.known()) continue;
    sum += m.value;
    squares += m.value * m.value;
    ++n;
  }
  if (n == 0) return {};
  const double centre = sum / n;
  const double variance = n > 1 ? std::max(0.0, (squares - n * centre * centre) / (n - 1)) : 0.0;
  constexpr double finest = 20e-6;  // s: what extraction resolves
  return {centre, std::sqrt(variance / n + std::pow(relative * centre, 2) + finest * finest)};
}

bool same_within(double a, double b) {
  const double difference = std::remainder(a - b, 2 * pi);
  return std::fabs(difference) < radians(0.01);
}

}  // namespace

std::vector<sim::MeasuredClosing> published_closings(const ModelDeviation& model) {
  std::vector<sim::MeasuredClosing> list;
  for (const auto& row : published_rows()) {
    if (row.table == 0 || row.quantity != "t_ct1") continue;
    sim::MeasuredClosing m;
    m.conditions.closing_angle = radians(row.theta_deg);
    m.touch = published("t_ct1", row.theta_deg, model.touch);
    m.bounce = published("t_ct_bon", row.theta_deg, model.bounce);
    m.seat = published("t_xt1", row.theta_deg, model.seat);
    if (m.seat.known())
      m.core_bounce = {find_published("t_xt_bon", row.theta_deg)->measurement * 1e-3, model.core_bounce};
    const double overtravel_time = m.seat.value - m.touch.value;
    if (std::isfinite(model.overtravel_time) && m.seat.known())
      m.overtravel_time = {overtravel_time, model.overtravel_time * overtravel_time};
    list.push_back(m);
  }
  return list;
}

std::vector<sim::MeasuredClosing> campaign_closings(std::span<const AngleGroup> groups,
                                                    const Conditions& conditions,
                                                    const ModelDeviation& model) {
  std::vector<sim::MeasuredClosing> list;
  for (const auto& group : groups) {
    if (group.measured.empty() || !std::isfinite(group.closing_angle)) continue;
    sim::MeasuredClosing m;
    m.conditions = conditions;
    m.conditions.closing_angle = group.closing_angle;
    m.conditions.polarity = 1;
    m.touch = mean(group.measured, "t_ct1", model.touch);
    m.bounce = mean(group.measured, "t_ct_bon", model.bounce);
    m.seat = mean(group.measured, "t_xt1", model.seat);
    if (std::isfinite(model.overtravel_time))
      m.overtravel_time = mean(group.measured, "t_ot", model.overtravel_time);
    list.push_back(m);
  }
  return list;
}

ShotScatter shot_scatter(std::span<const AngleGroup> groups) {
  const auto pooled = [&](std::string_view symbol) {
    double squares = 0, freedom = 0;
    for (const auto& g : groups) {
      std::vector<double> values;
      for (const auto& e : g.measured)
        if (const Measured m = find_quantity(symbol)->of(e); m.known()) values.push_back(m.value);
      if (values.size() < 2) continue;
      double centre = 0;
      for (const double v : values) centre += v / static_cast<double>(values.size());
      if (!(centre > 0)) continue;
      for (const double v : values) squares += std::pow(v / centre - 1, 2);
      freedom += static_cast<double>(values.size() - 1);
    }
    return freedom > 0 ? std::sqrt(squares / freedom) : unknown;
  };
  return {pooled("t_ct1"), pooled("t_ct_bon"), pooled("t_xt1"), pooled("t_ot")};
}

std::vector<sim::MeasuredClosing> without(std::vector<sim::MeasuredClosing> list,
                                          std::span<const double> angles) {
  std::erase_if(list, [&](const sim::MeasuredClosing& m) {
    return std::any_of(angles.begin(), angles.end(),
                       [&](double a) { return same_within(a, m.conditions.closing_angle); });
  });
  return list;
}

}  // namespace powbench::host
