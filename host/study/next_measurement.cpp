#include "host/study/next_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/study/closings_in_lanes.h"
#include "sim/study/next_measurement.h"

namespace powbench::host {
namespace {

constexpr int angles = 12;
constexpr double pitch = 15;          // deg
constexpr double window = 0.060;      // s
constexpr double shortest = 20e-6;    // s: a bounce or overtravel of less counts as so long
constexpr double of_velocity = 0.05;  // relative deviation of the model and a laser together
constexpr std::array symbols{"t_ct1", "t_ct_bon", "t_xt1", "t_ot", "v_core"};
constexpr std::size_t bounce = 1;

struct Candidate {
  double theta_deg = 0;
  std::size_t quantity = 0;
  std::size_t column = 0;  ///< among all values of a sample
};

/// Shots whose mean deviates by no more than a tenth of `model` in excess of it: hypot(model, scatter / sqrt(n)).
std::optional<int> enough_shots(double scatter, double model) {
  if (!std::isfinite(scatter) || !(model > 0)) return std::nullopt;
  constexpr double excess = 1.1 * 1.1 - 1;
  return std::max(1, static_cast<int>(std::ceil(std::pow(scatter / model, 2) / excess)));
}

}  // namespace

NextMeasurements next_measurements(const FitJob& job, const FitFile& file, const FitFold& posterior,
                                   sim::Team& team) {
  const auto list = specimens(file, posterior);
  std::vector<Conditions> conditions(angles, job.problem.closings.front().conditions);
  for (int a = 0; a < angles; ++a) conditions[static_cast<std::size_t>(a)].closing_angle = radians(pitch * a);
  std::vector<sim::Attempt> attempts;
  for (const auto& s : list)
    for (const auto& c : conditions) attempts.push_back({&s, &c, window});
  const auto truths =
      sim::tried_closings(attempts, sim::PlantOptions{}.relative_tolerance, team, job.problem.model);

  std::vector<std::vector<double>> logs;  // of every quantity at every angle
  for (std::size_t k = 0; k < list.size(); ++k) {
    std::vector<double> values;
    const double factor = posterior.bounce ? posterior.bounce->factors[k] : 1;
    for (std::size_t a = 0; a < angles; ++a) {
      const sim::ClosingTruth& t = truths[k * angles + a];
      if (!t.touch || !t.core_seat) break;
      for (const double v : {*t.touch, std::max(shortest, factor * (*t.settled - *t.touch)), *t.core_seat,
                             std::max(shortest, *t.core_seat - *t.touch), std::fabs(t.seat_velocity)})
        values.push_back(std::log(v));
    }
    if (values.size() == angles * symbols.size()) logs.push_back(std::move(values));
  }
  if (logs.size() < 2) return {};

  const std::array deviation{job.granted.touch, job.granted.bounce, job.granted.seat,
                             job.granted.overtravel_time, of_velocity};
  const auto known_there = [&](double theta_deg, std::size_t quantity) {
    return std::any_of(job.problem.closings.begin(), job.problem.closings.end(), [&](const auto& m) {
      const std::array<bool, 5> known{m.touch.known(), m.bounce.known(), m.seat.known(),
                                      m.overtravel_time.known(), false};
      return std::fabs(std::remainder(degrees(m.conditions.closing_angle) - theta_deg, 180)) < 0.01 &&
             known[quantity];
    });
  };
  std::vector<Candidate> candidates;
  std::vector<double> u;
  for (std::size_t a = 0; a < angles; ++a)
    for (std::size_t q = 0; q < symbols.size(); ++q) {
      const double theta = pitch * static_cast<double>(a);
      if (!(deviation[q] > 0) || known_there(theta, q)) continue;
      candidates.push_back({theta, q, a * symbols.size() + q});
      u.push_back(deviation[q]);
    }
  // the bounces of all angles stand behind the candidates, to be watched
  std::vector<std::vector<double>> values;
  for (const auto& all : logs) {
    auto& row = values.emplace_back();
    for (const auto& c : candidates) row.push_back(all[c.column]);
    for (std::size_t a = 0; a < angles; ++a) row.push_back(all[a * symbols.size() + bounce]);
  }
  u.insert(u.end(), angles, std::numeric_limits<double>::infinity());
  const auto best = sim::most_informative(values, u, static_cast<std::size_t>(job.next));
  NextMeasurements next;
  next.samples = static_cast<int>(logs.size()), next.of = static_cast<int>(list.size());
  double squares = 0;
  for (std::size_t a = 0; a < angles; ++a) {
    double mean = 0, square = 0;
    for (const auto& row : values) mean += row[candidates.size() + a] / static_cast<double>(values.size());
    for (const auto& row : values) square += std::pow(row[candidates.size() + a] - mean, 2);
    squares += square / static_cast<double>(values.size() - 1);
  }
  next.bounce_spread = std::sqrt(squares / angles);
  const std::array scatter{job.scatter.touch, job.scatter.bounce, job.scatter.seat,
                           job.scatter.overtravel_time, unknown};
  for (const auto& one : best) {
    const Candidate& c = candidates[one.candidate];
    double left = 0;
    for (std::size_t i = candidates.size(); i < u.size(); ++i) left += one.left[i] / angles;
    next.list.push_back({c.theta_deg, symbols[c.quantity], one.bits, one.spread, deviation[c.quantity],
                         enough_shots(scatter[c.quantity], deviation[c.quantity]), std::sqrt(left)});
  }
  return next;
}

std::string next_text(const NextMeasurements& next) {
  if (next.list.empty())
    return "\nwhat to measure next: not known, too few posterior samples close at every angle\n";
  std::string out = fmt::format(
      "\nwhat to measure next, best first, each given those before it; by {} of {} posterior samples, which "
      "close at "
      "every angle\ntheir bounce is spread by {:.0f} %\n"
      "{:>6}  {:<9} {:>6} {:>10} {:>12} {:>6} {:>20}\n",
      next.samples, next.of, 100 * next.bounce_spread, "theta", "quantity", "bits", "spread / %",
      "deviation / %", "shots", "bounce spread then / %");
  for (const auto& n : next.list)
    out += fmt::format("{:>6.1f}  {:<9} {:>6.2f} {:>10.1f} {:>13.2f} {:>6} {:>22.0f}\n", n.theta_deg,
                       n.quantity, n.bits, 100 * n.spread, 100 * n.deviation,
                       n.shots ? std::to_string(*n.shots) : "-", 100 * n.bounce_left);
  return out +
         "bits: expected information about the device; spread: of the posterior there; deviation: of one "
         "measured value about the model's;\nshots: until their scatter adds less than a tenth to it; -: no "
         "repeats tell it\n";
}

}  // namespace powbench::host
