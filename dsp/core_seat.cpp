#include "dsp/core_seat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dsp/force.h"
#include "dsp/least_squares.h"
#include "dsp/signal.h"
#include "dsp/statistics.h"

namespace powbench::dsp {

namespace {

/// Slope of the least-squares line through the samples of [t1, t2]; 0 when there are fewer than three.
double slope(const Signal& s, double t1, double t2) {
  const std::size_t i1 = s.index_at(t1), i2 = s.index_at(t2);
  if (i2 < i1 + 3) return 0.0;
  const double n = static_cast<double>(i2 - i1), middle = 0.5 * (n - 1);
  double sum = 0;
  for (std::size_t i = i1; i < i2; ++i) sum += (static_cast<double>(i - i1) - middle) * s.value[i];
  return sum / (n * (n * n - 1) / 12.0) / s.dt;
}

struct Kink {
  Measured at;
  Measured velocity;  ///< just before
  double velocity_after = 0;
  bool found = false;
};

struct KinkModel {
  LeastSquares ls;
  std::size_t samples = 0;
};

/// Distance lost to a velocity that falls by 1 m/s, evenly over `duration` from tau = 0 on.
double lost_distance(double tau, double duration) {
  if (tau <= 0) return 0.0;
  return tau < duration ? 0.5 * tau * tau / duration : tau - 0.5 * duration;
}

/// Columns 1, v, a/2 (all the way), velocity step, change of a/2 (after the step), around t_s.
KinkModel kink_model(const Signal& s, double t_s, double duration, double from, double to) {
  std::array<std::vector<double>, 5> c;
  std::vector<double> y;
  for (std::size_t i = s.index_at(from); i < s.size() && s.time(i) <= to; ++i) {
    if (s.masked[i]) continue;
    const double tau = s.time(i) - t_s, after = std::max(tau - duration, 0.0);
    const double row[5] = {1.0, tau, 0.5 * tau * tau, lost_distance(tau, duration), 0.5 * after * after};
    for (std::size_t k = 0; k < 5; ++k) c[k].push_back(row[k]);
    y.push_back(s.value[i]);
  }
  if (y.size() < 12) return {};
  return {linear_least_squares(c, y), y.size()};
}

/// s: how long the laser shows one of its own samples, from the mean run of equal values in [t1, t2] while the core moves;
/// 0 when it is no slower than the record.
double held_for(const Signal& s, double t1, double t2) {
  const std::size_t i1 = s.index_at(t1), i2 = s.index_at(t2);
  std::size_t changes = 0;
  for (std::size_t i = i1; i + 1 < i2; ++i) changes += s.value[i] != s.value[i + 1];
  const double run = static_cast<double>(i2 - i1) / static_cast<double>(changes + 1);
  return i2 > i1 && run > 2 ? run * s.dt : 0.0;
}

/// Least residual over the start t_s and the duration of the velocity drop, window fixed so that the sums compare.
Kink fit_kink(const Signal& s, double guess, double before, double after, double noise) {
  Kink kink;
  const double span = 0.35 * std::min(before, after), longest = 0.35 * after;
  const auto cost = [&](double t, double duration) {
    const KinkModel m = kink_model(s, t, duration, guess - before, guess + after);
    return m.samples ? m.ls.chi2 : std::numeric_limits<double>::infinity();
  };
  double best = guess, length = 0, lowest = cost(guess, 0);
  const auto look = [&](double t, double duration) {
    if (duration < 0 || duration > longest || std::abs(t - guess) > span) return;
    if (const double v = cost(t, duration); v < lowest) lowest = v, best = t, length = duration;
  };
  double step = span / 6;
  for (double t = guess - span; t <= guess + span; t += step)
    for (double duration = 0; duration <= longest; duration += longest / 5) look(t, duration);
  for (; step > 0.2e-6; step *= 0.5) {
    const double t = best, duration = length;
    for (const double dt : {-step, 0.0, step})
      for (const double dd : {-step, 0.0, step}) look(t + dt, duration + dd);
  }
  const KinkModel m = kink_model(s, best, length, guess - before, guess + after);
  if (!m.samples || !m.ls.converged) return kink;
  const double dof = std::max(static_cast<double>(m.samples) - 7.0, 1.0);
  const double sigma = std::max(std::sqrt(m.ls.chi2 / dof), noise);
  // Half the curvature matrix of the residual over (t_s, duration) is the inverse covariance at unit noise.
  const double h = std::max(2e-6, 0.5 * s.dt), d = std::max(length, h);
  const double centre = cost(best, d);
  const double tt = (cost(best - h, d) + cost(best + h, d) - 2 * centre) / (2 * h * h);
  const double dd = (cost(best, d - h) + cost(best, d + h) - 2 * centre) / (2 * h * h);
  const double td =
      (cost(best + h, d + h) + cost(best - h, d - h) - cost(best + h, d - h) - cost(best - h, d + h)) /
      (8 * h * h);
  const double det = tt * dd - td * td;
  const double variance = det > 0 && dd > 0 ? dd / det : (tt > 0 ? 1 / tt : span * span);
  // Up to one record sample of uncorrected shift; a slow laser blurs the stop over one of its own, whose start is read
  // early by anything up to that.
  const double coarse =
      std::hypot(s.dt / std::sqrt(12.0), held_for(s, guess - before, best) / std::sqrt(3.0));
  kink.at = {best, std::hypot(std::min(sigma * std::sqrt(variance), span), coarse)};
  kink.velocity = {m.ls.x[1], m.ls.u(1) * sigma};
  kink.velocity_after = m.ls.x[1] + m.ls.x[3];
  kink.found = kink.at.u < 0.8 * span;
  return kink;
}

struct Drop {
  double at = 0, size = 0;
};

/// Velocity lost across +-`half` around each sample of [t1, t2]; local maxima above `least`, in time order.
std::vector<Drop> velocity_drops(const Signal& s, double t1, double t2, double half, double least) {
  std::vector<double> d;
  const std::size_t i1 = s.index_at(t1), i2 = s.index_at(t2);
  for (std::size_t i = i1; i < i2; ++i) {
    const double t = s.time(i);
    d.push_back(slope(s, t - half, t + 0.5 * s.dt) - slope(s, t - 0.5 * s.dt, t + half));
  }
  std::vector<Drop> out;
  const auto reach = static_cast<std::size_t>(std::max(1.0, half / s.dt));
  for (std::size_t k = 0; k < d.size(); ++k) {
    if (d[k] < least) continue;
    const std::size_t a = k > reach ? k - reach : 0, b = std::min(d.size(), k + reach + 1);
    const auto top = std::max_element(d.begin() + static_cast<std::ptrdiff_t>(a),
                                      d.begin() + static_cast<std::ptrdiff_t>(b));
    if (top - d.begin() == static_cast<std::ptrdiff_t>(k)) out.push_back({s.time(i1 + k), d[k]});
  }
  return out;
}

constexpr double impact_search = 0.3e-3;  ///< s on either side of the laser's seat
constexpr double impact_clear = 15;       ///< largest sample of the impact over the largest before it

/// The impact on the accelerometer: where it first leaves what was there before. Nothing unless it stands
/// far above the 2 ms before, as the blow of a core does.
Measured impact_time(const Record& record, const Measured& seat) {
  Signal s = to_signal(record, Channel::aux);
  const std::size_t i0 = s.index_at(seat.value - impact_search - 2e-3),
                    i1 = s.index_at(seat.value - impact_search), i2 = s.index_at(seat.value + impact_search);
  if (i1 < i0 + 50 || i2 < i1 + 20) return {};
  const double zero = median(std::span(s.value).subspan(i0, i1 - i0));
  double before = 0, top = 0;
  for (std::size_t i = i0; i < i2; ++i) {
    double& largest = i < i1 ? before : top;
    largest = std::max(largest, std::abs(s.value[i] - zero));
  }
  if (!(top > impact_clear * before)) return {};
  const double level = std::max(0.03 * top, 2 * before);
  std::size_t i = i1;
  const auto above = [&](std::size_t k) { return k < i2 && std::abs(s.value[k] - zero) >= level; };
  while (i < i2 && !(above(i) && (above(i + 1) || above(i + 2)))) ++i;
  if (i == i1 || i == i2 || s.mask_within(s.time(i1), s.time(i)) != mask_none) return {};
  // The converter's sample is a mean over its interval: the blow fell inside it. One that rises slowly was there earlier by
  // about the time it takes for as much again.
  std::size_t twice = i;
  while (twice < i2 && std::abs(s.value[twice] - zero) < 2 * level) ++twice;
  return {s.time(i), std::hypot(s.dt / std::sqrt(12.0), s.time(twice) - s.time(i))};
}

}  // namespace

CoreEvents core_events(const Record& record, const ExtractOptions& o) {
  CoreEvents e;
  const Signal s = to_signal(record, Channel::laser);
  if (s.size() < 50) return e;
  e.present = true;
  const double t_end = closing_end(record, s);
  const std::size_t before = s.index_at(0.0), last = s.index_at(t_end);
  if (before < 10 || last < before + 50) return e;
  const auto quiet = std::span(s.value).first(before);
  const double open = median(quiet), quantum = std::abs(record.find(Channel::laser)->scale) / std::sqrt(12.0);
  const double noise = std::max(robust_sigma(quiet), quantum);
  const std::size_t window = std::max<std::size_t>(10, static_cast<std::size_t>(o.settled_window / s.dt));
  const auto end =
      std::span(s.value).subspan(last - std::min(window, last - before), std::min(window, last - before));
  const double closed = median(end), root = std::sqrt(static_cast<double>(end.size()));
  const double travel = closed - open;
  e.travel = {travel, std::hypot(noise / std::sqrt(static_cast<double>(before)),
                                 robust_sigma(end) / root + noise / root)};
  if (std::abs(travel) < 50 * noise) return e;  // it did not move

  // Half the travel is the earliest time the core can land.
  std::size_t half_way = before;
  while (half_way < last && s.value[half_way] - open < 0.5 * travel) ++half_way;
  if (half_way >= last || travel < 0) return e;
  const double half = 0.4 * o.seat_window;
  const double slope_noise = noise / (half * std::sqrt(half / s.dt / 12.0)) * std::sqrt(2.0);
  auto drops = velocity_drops(s, s.time(half_way), t_end - half, half, 8 * slope_noise);
  if (drops.empty()) return e;
  const auto largest =
      std::max_element(drops.begin(), drops.end(), [](auto& a, auto& b) { return a.size < b.size; });
  const Kink seat = fit_kink(s, largest->at, o.seat_window, o.seat_window, noise);
  if (!seat.found) return e;
  e.seat = e.settled = seat.at;
  e.impact_velocity = seat.velocity;
  const double least = std::max(o.seat_share * largest->size, 8 * slope_noise);
  for (const Drop& d : drops) {
    if (d.at < seat.at.value + o.seat_window || d.size < least) continue;
    const Kink again = fit_kink(s, d.at, 0.7 * o.seat_window, 0.7 * o.seat_window, noise);
    if (again.found && again.velocity.value - again.velocity_after > least) e.settled = again.at;
  }
  const bool bounced = e.settled.value > e.seat.value;
  if (const Measured impact = impact_time(record, e.seat); impact.known()) {
    e.seat = impact;
    if (!bounced) e.settled = impact;
  }
  // another landing within the resolution would not have been told apart
  e.settled.u = std::hypot(e.settled.u, core_resolution(o) / std::sqrt(3.0));
  e.bounce_time = {e.settled.value - e.seat.value, std::hypot(e.settled.u, e.seat.u)};
  const std::uint8_t mask = s.mask_within(e.seat.value - o.seat_window, e.seat.value + o.seat_window);
  if (mask & mask_gap) e.flags |= flag_gap;
  if (mask & mask_clipped) e.flags |= flag_clipped;
  return e;
}

}  // namespace powbench::dsp
