#include "sim/study/sweep.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "core/random.h"
#include "core/units.h"
#include "sim/study/closings_in_lanes.h"
#include "sim/study/modes.h"

namespace powbench::sim {
namespace {

/// Draws x angles of the metric, row by row.
struct Sample {
  std::size_t draws, angles;
  std::vector<double> values;
  double at(std::size_t draw, std::size_t angle) const { return values[draw * angles + angle]; }
};

/// At each angle, over the draws listed: the mean of those that close, NaN where none does, and how many do.
struct Means {
  std::vector<double> mean;
  std::vector<std::size_t> closed;
};
Means means(const Sample& s, const std::vector<std::size_t>& rows) {
  Means m{std::vector<double>(s.angles, 0.0), std::vector<std::size_t>(s.angles, 0)};
  for (const std::size_t r : rows)
    for (std::size_t a = 0; a < s.angles; ++a)
      if (std::isfinite(s.at(r, a))) m.mean[a] += s.at(r, a), ++m.closed[a];
  for (std::size_t a = 0; a < s.angles; ++a) m.mean[a] /= static_cast<double>(m.closed[a]);
  return m;
}

/// Of those that are numbers.
double mean_of(const std::vector<double>& v) {
  double sum = 0, n = 0;
  for (const double x : v)
    if (std::isfinite(x)) sum += x, n += 1;
  return sum / n;
}

/// The smallest mean of the angles at which most devices close.
std::size_t best_of(const Means& m) {
  std::size_t best = 0;
  for (std::size_t a = 1; a < m.mean.size(); ++a)
    if (m.closed[a] > m.closed[best] || (m.closed[a] == m.closed[best] && m.mean[a] < m.mean[best])) best = a;
  return best;
}

/// Signed distance on the half circle, rad.
double half_turn(double difference) {
  return std::remainder(difference, pi);
}

void bootstrap(const Sample& s, const BestAngleOptions& options, BestAngle& b) {
  Random random(options.seed + 4711);
  std::vector<std::vector<double>> at_angle(s.angles);
  std::vector<double> gains, offsets;
  std::vector<std::size_t> rows(s.draws);
  int near = 0;
  for (int k = 0; k < options.bootstraps; ++k) {
    for (auto& r : rows) r = random.below(s.draws);
    const auto m = means(s, rows);
    for (std::size_t a = 0; a < s.angles; ++a)
      if (m.closed[a] > 0) at_angle[a].push_back(m.mean[a]);
    const std::size_t best = best_of(m);
    const double offset = half_turn(b.angles[best] - b.angles[b.best]);
    offsets.push_back(offset);
    near += std::fabs(offset) <= options.near + 1e-12 ? 1 : 0;
    if (m.closed[b.best] > 0) gains.push_back(1 - m.mean[b.best] / mean_of(m.mean));
  }
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  for (auto& values : at_angle) {
    if (values.empty()) values.push_back(unknown);
    std::sort(values.begin(), values.end());
    b.low.push_back(quantile_of_sorted(values, 0.025));
    b.high.push_back(quantile_of_sorted(values, 0.975));
  }
  if (gains.empty()) gains.push_back(unknown);
  std::sort(gains.begin(), gains.end());
  std::sort(offsets.begin(), offsets.end());
  b.gain_low = quantile_of_sorted(gains, 0.025);
  b.gain_high = quantile_of_sorted(gains, 0.975);
  b.first = b.angles[b.best] + quantile_of_sorted(offsets, 0.025);
  b.last = b.angles[b.best] + quantile_of_sorted(offsets, 0.975);
  b.confidence = static_cast<double>(near) / options.bootstraps;
}

using Sink = std::function<void(std::size_t, const ClosingMetrics&)>;

/// One result for each case that `make` gives; `sink` is called by one thread at a time.
void stream_cases(std::size_t count, const std::function<Case(std::size_t)>& make,
                  const MetricOptions& options, Team& team, const Sink& sink,
                  const std::function<bool()>& go_on) {
  std::atomic<std::size_t> begun{0};
  const auto next = [&]() -> std::optional<std::size_t> {
    if (!go_on()) return std::nullopt;
    const std::size_t i = begun.fetch_add(1);
    return i < count ? std::optional(i) : std::nullopt;
  };
  std::mutex one;
  const auto hand_over = [&](std::size_t i, const ClosingMetrics& m) {
    const std::scoped_lock lock(one);
    sink(i, m);
  };
  team.run([&](int) {
    if (options.sample_dt > 0)
      while (const auto i = next()) hand_over(*i, closing_metrics(make(*i), options));
    else
      closings_in_lanes(
          [&]() -> std::optional<LaneClosing> {
            const auto i = next();
            if (!i) return std::nullopt;
            return LaneClosing{*i, make(*i), options.duration, options.tolerance};
          },
          [&](std::size_t i, const ClosingTruth& t) { hand_over(i, closing_metrics(t)); }, OnFailure::raise);
  });
}

std::vector<ClosingMetrics> run_cases(std::size_t count, const std::function<Case(std::size_t)>& make,
                                      const MetricOptions& options, Team& team) {
  std::vector<ClosingMetrics> results(count);
  stream_cases(
      count, make, options, team, [&](std::size_t i, const ClosingMetrics& m) { results[i] = m; },
      [] { return true; });
  return results;
}

}  // namespace

void stream_points(const Design& design, const Case& base, std::span<const std::int64_t> points,
                   const MetricOptions& options, Team& team,
                   const std::function<void(std::size_t, const ClosingMetrics&)>& sink,
                   const std::function<bool()>& go_on) {
  stream_cases(
      points.size(), [&](std::size_t i) { return design.apply(base, design.point(points[i])); }, options,
      team, sink, go_on);
}

std::vector<SensitivityStep> usual_steps() {
  return {{"supply_volts", 0.01, true},   {"ambient_degC", 10, false}, {"angle_deg", 1, false},
          {"core.friction_N", 0.1, true}, {"core.mass_g", 0.01, true}, {"bridges.gap_mm", 0.01, true}};
}

std::vector<Sensitivity> sensitivities(const Case& base, std::span<const double> angles,
                                       std::span<const SensitivityStep> steps, const MetricInfo& metric,
                                       const MetricOptions& options, Team& team) {
  std::vector<Sensitivity> rows;
  for (const double angle : angles)
    for (const auto& s : steps) {
      Sensitivity row;
      row.angle = angle;
      row.name = s.name;
      row.step = s.relative ? s.step * std::fabs(variable(s.name).get(base)) : s.step;
      rows.push_back(row);
    }
  const auto moved = [&](std::size_t k) {
    const Sensitivity& row = rows[k / 3];
    Case c = base;
    c.conditions.closing_angle = row.angle;
    const Variable v = variable(row.name);
    v.set(c, v.get(c) + (static_cast<int>(k % 3) - 1) * row.step);
    return c;
  };
  const auto all = run_cases(3 * rows.size(), moved, options, team);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    rows[r].low = all[3 * r].*metric.member;
    rows[r].centre = all[3 * r + 1].*metric.member;
    rows[r].high = all[3 * r + 2].*metric.member;
  }
  return rows;
}

BestAngle best_angle(const Case& base, const std::vector<Axis>& tolerances, const MetricInfo& metric,
                     const MetricOptions& metric_options, const BestAngleOptions& options, Team& team,
                     const std::function<bool(std::int64_t, std::int64_t)>& go_on) {
  BestAngle b;
  b.near = options.near;
  const auto angles = static_cast<std::size_t>(options.angles);
  const auto draws = static_cast<std::size_t>(options.draws);
  for (std::size_t a = 0; a < angles; ++a)
    b.angles.push_back(pi * static_cast<double>(a) / static_cast<double>(angles));
  Sample s{draws, angles, std::vector<double>(draws * angles)};
  const Design design(tolerances, Sampling::latin, options.draws, options.seed);
  constexpr std::size_t together = 32;  // draws between two looks at `go_on`
  for (std::size_t first = 0; first < draws; first += together) {
    const std::size_t count = std::min(together, draws - first) * angles;
    const auto closing = [&](std::size_t k) {
      Case c = design.apply(base, design.point(static_cast<std::int64_t>(first + k / angles)));
      c.conditions.closing_angle += b.angles[k % angles] - base.conditions.closing_angle;
      return c;
    };
    const auto results = run_cases(count, closing, metric_options, team);
    for (std::size_t k = 0; k < count; ++k) {
      s.values[first * angles + k] = results[k].*metric.member;
    }
    if (go_on &&
        !go_on(static_cast<std::int64_t>(first * angles + count), static_cast<std::int64_t>(draws * angles)))
      return {};
  }
  std::vector<std::size_t> all(draws);
  for (std::size_t d = 0; d < draws; ++d) all[d] = d;
  const Means m = means(s, all);
  b.mean = m.mean, b.closed = m.closed, b.draws = draws;
  for (std::size_t a = 0; a < angles; ++a) {
    std::vector<double> column;
    double squares = 0;
    for (std::size_t d = 0; d < draws; ++d) {
      if (!std::isfinite(s.at(d, a))) continue;
      column.push_back(s.at(d, a));
      squares += std::pow(s.at(d, a) - b.mean[a], 2);
    }
    b.deviation.push_back(column.size() > 1 ? std::sqrt(squares / static_cast<double>(column.size() - 1))
                                            : 0.0);
    b.mode_count.push_back(column.empty() ? 0 : modes(column).size());
  }
  b.best = best_of(m);
  if (b.closed[b.best] == 0) return b;
  b.random_mean = mean_of(b.mean);
  b.gain = 1 - b.mean[b.best] / b.random_mean;
  bootstrap(s, options, b);
  return b;
}

}  // namespace powbench::sim
