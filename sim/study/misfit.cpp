#include "sim/study/misfit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/study/closings_in_lanes.h"
#include "sim/study/steady.h"

namespace powbench::sim {
namespace {

constexpr double never = 40;  // deviations: a closing that does not close, or an integration that fails

/// Residual whose square is v^2 up to two deviations and grows linearly beyond.
double tempered(double v) {
  const double a = std::fabs(v);
  return a <= 2 ? v : std::copysign(std::sqrt(4 * a - 4), v);
}

}  // namespace

Plausible catalogue_ranges() {
  Plausible p;
  p.inrush = PlausibleRange{70, 150, 10};
  p.holding = PlausibleRange{5, 20, 2};
  p.overtravel = PlausibleRange{0.25, 0.8, 0.02};
  p.contact_force = PlausibleRange{1.5, 5, 0.3};
  p.base_travel = PlausibleRange{0, 2e-3, 0.2e-3};
  p.pick_up = true;
  p.calm = true;
  return p;
}

Derived derived(const Specimen& s, double rated_volts) {
  Mains mains;
  mains.volts = rated_volts;
  const double overtravel = s.core.travel - s.bridges.gap;
  const SteadyCurrents steady = steady_currents(s, mains);
  return {mains.volts * steady.open, mains.volts * steady.closed, overtravel / s.bridges.gap,
          0.5 * (s.bridges.preload + s.bridges.rate * overtravel),
          100 / (s.base.mass * std::pow(2 * pi * s.base.hertz, 2))};
}

Misfit::Misfit(FitProblem problem) : problem_(std::move(problem)) {
  for (const auto& m : problem_.closings)
    if (m.overtravel_time.known()) per_closing_ = 5;
}

double Misfit::closing_residuals(const ClosingTruth& t, const MeasuredClosing& m,
                                 ClosingResiduals& out) const {
  out.fill(0.0);
  const bool closed = t.touch && t.core_seat;
  const auto residual = [](const Measured& measured, double model) {
    return (model - measured.value) / measured.u;
  };
  if (m.touch.known()) out[0] = closed ? residual(m.touch, *t.touch) : never;
  if (m.bounce.known()) out[1] = closed ? residual(m.bounce, *t.settled - *t.touch) : never;
  if (m.seat.known()) out[2] = closed ? residual(m.seat, *t.core_seat) : never;
  if (m.core_bounce.known())
    out[3] = closed ? residual(m.core_bounce, *t.core_settled - *t.core_seat) : never;
  if (m.overtravel_time.known())
    out[4] = closed ? residual(m.overtravel_time, *t.core_seat - *t.touch) : never;
  if (problem_.robust) {
    out[1] = tempered(out[1]);
    out[3] = tempered(out[3]);
  }
  return out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3] + out[4] * out[4];
}

double Misfit::closing_distance(const ClosingTruth& t, const MeasuredClosing& m, Means& means) const {
  if (!t.touch || !t.core_seat) return never * never;
  double sum = 0;
  const auto add = [&](std::size_t q, double measured, double u, double model) {
    if (!std::isfinite(measured)) return;
    const double d = std::fabs(model - measured) / u;
    sum += d;
    means.sum[q] += d;
    ++means.count[q];
  };
  const double u_settled = std::isfinite(m.settled.u) ? m.settled.u : std::hypot(m.touch.u, m.bounce.u);
  add(0, m.touch.value, m.touch.u, *t.touch);
  add(1, m.bounce.value, m.bounce.u, *t.settled - *t.touch);
  add(2, m.touch.value + m.bounce.value, u_settled, *t.settled);
  add(3, m.seat.value, m.seat.u, *t.core_seat);
  add(4, m.core_bounce.value, m.core_bounce.u, *t.core_settled - *t.core_seat);
  add(5, m.overtravel_time.value, m.overtravel_time.u, *t.core_seat - *t.touch);
  return sum;
}

double Misfit::Means::excess() const {
  constexpr double wanted = 2, weight = 100;
  double total = 0;
  for (std::size_t q = 0; q < sum.size(); ++q)
    if (count[q] > 0) total += weight * std::max(0.0, sum[q] / (wanted * count[q]) - 1);
  return total;
}

void Misfit::range_residuals(const Specimen& s, std::vector<double>& out) const {
  const Plausible& p = problem_.plausible;
  const bool any = p.inrush || p.holding || p.overtravel || p.contact_force || p.base_travel || p.held_load;
  if (!any) return;
  const Derived d = derived(s, p.rated_volts);
  const auto add = [&](const std::optional<PlausibleRange>& range, double value) {
    if (range) out.push_back(range->outside(value));
  };
  add(p.inrush, d.inrush);
  add(p.holding, d.holding);
  add(p.overtravel, d.overtravel);
  add(p.contact_force, d.contact_force);
  add(p.base_travel, d.base_travel);
  if (p.held_load) {
    Mains mains;
    mains.volts = p.rated_volts;
    add(p.held_load, closed_load(s) / least_pull(s, mains));
  }
}

std::vector<std::vector<double>> Misfit::bounces(std::span<const std::vector<double>> points,
                                                 double tolerance, Team& team) const {
  std::vector<Specimen> specimens;
  for (const auto& point : points) specimens.push_back(specimen(point));
  std::vector<Attempt> attempts;
  for (const auto& s : specimens)
    for (const auto& m : problem_.closings) attempts.push_back({&s, &m.conditions, problem_.duration});
  const auto truths = tried_closings(attempts, tolerance, team, problem_.model);
  std::vector<std::vector<double>> lists(points.size());
  for (std::size_t k = 0; k < truths.size(); ++k) {
    const ClosingTruth& t = truths[k];
    const bool closed = t.touch && t.core_seat;
    lists[k / problem_.closings.size()].push_back(closed ? *t.settled - *t.touch
                                                         : std::numeric_limits<double>::quiet_NaN());
  }
  return lists;
}

std::vector<double> Misfit::residuals(const Specimen& s, std::span<const double> point,
                                      std::span<const ClosingTruth> truths) const {
  std::vector<double> out;
  for (std::size_t k = 0; k < truths.size(); ++k) {
    ClosingResiduals r;
    closing_residuals(truths[k], problem_.closings[k], r);
    out.insert(out.end(), r.begin(), r.begin() + static_cast<std::ptrdiff_t>(per_closing_));
  }
  range_residuals(s, out);
  for (std::size_t i = 0; i < point.size(); ++i) {
    const double u = point[i];
    const double low = problem_.edge - u;
    const double high = u - (1 - problem_.edge);
    if (problem_.edge > 0) out.push_back(std::max({low, high, 0.0}) / problem_.edge);
    if (problem_.prior_deviation > 0) out.push_back((u - middle(i)) / problem_.prior_deviation);
  }
  return out;
}

std::vector<double> Misfit::residuals(std::span<const double> point, double tolerance) const {
  Team alone(1);
  const std::vector<PointOf> one{{0, {point.begin(), point.end()}}};
  return residuals_of(std::span(this, 1), one, tolerance, alone).front();
}

std::vector<std::vector<double>> Misfit::residuals(std::span<const std::vector<double>> points,
                                                   double tolerance, Team& team) const {
  std::vector<PointOf> list;
  for (const auto& point : points) list.push_back({0, point});
  return residuals_of(std::span(this, 1), list, tolerance, team);
}

std::vector<std::vector<double>> residuals_of(std::span<const Misfit> problems,
                                              std::span<const PointOf> points, double tolerance, Team& team) {
  std::vector<Specimen> specimens;
  for (const auto& p : points) specimens.push_back(problems[p.problem].specimen(p.point));
  std::vector<Attempt> attempts;
  std::vector<std::size_t> first;  // of each point
  for (std::size_t k = 0; k < points.size(); ++k) {
    const FitProblem& problem = problems[points[k].problem].problem();
    first.push_back(attempts.size());
    for (const auto& m : problem.closings)
      attempts.push_back({&specimens[k], &m.conditions, problem.duration});
  }
  const auto truths = tried_closings(attempts, tolerance, team, problems.front().problem().model);
  std::vector<std::vector<double>> all(points.size());
  for_each_index(team, static_cast<int>(points.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const Misfit& m = problems[points[k].problem];
    all[k] = m.residuals(specimens[k], points[k].point,
                         std::span(truths).subspan(first[k], m.problem().closings.size()));
  });
  return all;
}

Misfit Misfit::motion() const {
  constexpr double room = 1.35;  // for candidates that are late
  FitProblem smooth = problem_;
  double last = 0;
  for (auto& m : smooth.closings) {
    for (const auto* q : {&m.touch, &m.seat})
      if (q->known()) last = std::max(last, q->value);
    m.bounce = m.core_bounce = {};
  }
  // 0.72 = 0.85^2: not let go at the lowest closing voltage either
  if (smooth.plausible.calm) smooth.plausible.held_load = PlausibleRange{0, 0.72, 0.05};
  smooth.plausible.calm = smooth.absolute = false;
  if (last > 0) smooth.duration = std::min(smooth.duration, room * last);
  return Misfit(std::move(smooth));
}

Misfit Misfit::perturbed(std::span<const double> shifts, std::span<const double> prior_shifts) const {
  FitProblem moved = problem_;
  std::size_t k = 0;
  for (auto& m : moved.closings)
    for (auto* q : {&m.touch, &m.bounce, &m.seat, &m.core_bounce, &m.overtravel_time}) {
      if (!q->known()) continue;
      q->value += shifts[k % shifts.size()] * q->u;
      ++k;
    }
  if (!prior_shifts.empty()) {
    moved.prior_middle.clear();
    for (std::size_t i = 0; i < prior_shifts.size(); ++i)
      moved.prior_middle.push_back(middle(i) + problem_.prior_deviation * prior_shifts[i]);
  }
  return Misfit(std::move(moved));
}

}  // namespace powbench::sim
