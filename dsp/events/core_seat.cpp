#include "dsp/events/core_seat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "dsp/events/laser_clock.h"
#include "dsp/events/laser_dropout.h"
#include "dsp/filter/force.h"
#include "dsp/signal/least_squares.h"
#include "dsp/signal/signal.h"
#include "dsp/signal/statistics.h"
#include "dsp/signal/wide.h"

namespace powbench::dsp {

namespace {

struct Kink {
  Measured at;
  Measured velocity;  ///< just before
  double velocity_after = 0;
  double duration = 0;  ///< s, of the velocity's fall
  bool found = false;
};

constexpr std::size_t fewest = 12;  ///< samples of a kink

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
  if (y.size() < fewest) return {};
  return {linear_least_squares(c, y), y.size()};
}

/// s: how long the laser shows one of its own samples, from the mean run of equal values in [t1, t2] while the core
/// moves; 0 when it is no slower than the record.
double held_for(const Signal& s, double t1, double t2) {
  const std::size_t i1 = s.index_at(t1), i2 = s.index_at(t2);
  std::size_t changes = 0;
  for (std::size_t i = i1; i + 1 < i2; ++i) changes += s.value[i] != s.value[i + 1];
  const double run = static_cast<double>(i2 - i1) / static_cast<double>(changes + 1);
  return i2 > i1 && run > 1.5 ? run * s.dt : 0.0;
}

constexpr double kink_step = 0.2e-6;  ///< s

/// Least residual over the start t_s and the duration of the velocity drop, window fixed so that the sums compare; to
/// `finest`.
Kink fit_kink(const Signal& s, double guess, double before, double after, double noise,
              double finest = kink_step) {
  Kink kink;
  const double span = 0.35 * std::min(before, after), longest_drop = 0.35 * after;
  std::vector<double> time, y, columns;
  for (std::size_t i = s.index_at(guess - before); i < s.size() && s.time(i) <= guess + after; ++i)
    if (!s.masked[i]) time.push_back(s.time(i)), y.push_back(s.value[i]);
  columns.resize(5 * y.size());
  const auto cost = [&](double t, double duration) {  // what kink_model leaves
    const std::size_t n = y.size();
    if (n < fewest) return std::numeric_limits<double>::infinity();
    const double per = 1 / (before + after);
    double* c = columns.data();
    for (std::size_t i = 0; i < n; ++i) {
      const double tau = time[i] - t, behind = std::max(tau - duration, 0.0), u = tau * per, v = behind * per;
      c[i] = 1, c[n + i] = u, c[2 * n + i] = u * u, c[3 * n + i] = lost_distance(tau, duration) * per;
      c[4 * n + i] = v * v;
    }
    return linear_misfit(columns, 5, y);
  };
  double best = guess, length = 0, lowest = cost(guess, 0);
  const auto look = [&](double t, double duration) {
    if (duration < 0 || duration > longest_drop || std::abs(t - guess) > span) return;
    if (const double v = cost(t, duration); v < lowest) lowest = v, best = t, length = duration;
  };
  double step = span / 6;
  for (double t = guess - span; t <= guess + span; t += step)
    for (double duration = 0; duration <= longest_drop; duration += longest_drop / 5) look(t, duration);
  for (; step > finest; step *= 0.5) {
    const double t = best, duration = length;
    for (const double dt : {-step, 0.0, step})
      for (const double dd : {-step, 0.0, step}) look(t + dt, duration + dd);
  }
  const KinkModel m = kink_model(s, best, length, guess - before, guess + after);
  if (!m.samples || !m.ls.converged) return kink;
  const double dof = std::max(static_cast<double>(m.samples) - 7.0, 1.0);
  const double sigma = std::max(std::sqrt(m.ls.chi2 / dof), noise);
  // Half the curvature matrix of the residual over (t_s, duration) is the inverse covariance at unit noise. Where a
  // slow laser holds its values the residual has corners; if they hide the curvature, it is taken across them.
  double variance = span * span;
  for (const double h : {std::max(2e-6, 0.5 * s.dt), std::max(10e-6, 0.5 * s.dt)}) {
    const double d = std::max(length, h), centre = cost(best, d);
    const double tt = (cost(best - h, d) + cost(best + h, d) - 2 * centre) / (2 * h * h);
    const double dd = (cost(best, d - h) + cost(best, d + h) - 2 * centre) / (2 * h * h);
    const double td =
        (cost(best + h, d + h) + cost(best - h, d - h) - cost(best + h, d - h) - cost(best - h, d + h)) /
        (8 * h * h);
    const double det = tt * dd - td * td;
    variance = det > 0 && dd > 0 ? dd / det : (tt > 0 ? 1 / tt : span * span);
    if (sigma * std::sqrt(variance) < 0.8 * span) break;
  }
  // Up to one record sample of uncorrected shift; a slow laser blurs the stop over one of its own, whose start is read
  // early by anything up to that.
  const double coarse =
      std::hypot(s.dt / std::sqrt(12.0), held_for(s, guess - before, best) / std::sqrt(3.0));
  kink.at = {best, std::hypot(std::min(sigma * std::sqrt(variance), span), coarse)};
  kink.velocity = {m.ls.x[1], m.ls.u(1) * sigma};
  kink.velocity_after = m.ls.x[1] + m.ls.x[3];
  kink.duration = length;
  kink.found = kink.at.u < 0.8 * span;
  return kink;
}

/// Velocity lost at once, beside what changes smoothly, all along the travel.
struct Drops {
  std::vector<double> lost, noise;  ///< m/s, one a bin
  double t0 = 0, dt = 0;            ///< s: the middle of the first bin, and a bin
};

/// Velocity at the end of the flight, m/s: slope at the seat of a polynomial through the travel before it alone, for
/// what the core does behind is not that of any model here. The pull rises steeply as the gap closes: of fourth
/// order, and what a fifth would change is part of u, as is the acceleration times u of the time. `held`, s: how long
/// a slow laser shows a value, whose middle is what `s` has. Its delay may have been set from there or from where the
/// value is new: the mean of both is taken, half their distance is u. What is held counts once.
Measured flight_velocity(const Signal& s, const Measured& seat, double held, double window, double noise) {
  constexpr std::size_t order = 4, least = 16;
  std::array<std::vector<double>, order + 2> c;
  std::vector<double> y;
  for (std::size_t i = s.index_at(seat.value - window); i < s.size(); ++i) {
    const double tau = s.time(i) - 0.25 * held - seat.value, x = tau / window;
    if (tau > -std::max(seat.u, s.dt)) break;
    if (s.masked[i]) continue;
    double power = 1;
    for (auto& column : c) column.push_back(power), power *= x;
    y.push_back(s.value[i]);
  }
  if (y.size() < least) return {};
  const LeastSquares fit = linear_least_squares(std::span(c).first(order + 1), y),
                     more = linear_least_squares(c, y);
  if (!fit.converged || !more.converged) return {};
  const double sigma = std::max(std::sqrt(fit.chi2 / static_cast<double>(y.size() - order - 1)), noise) *
                       std::sqrt(std::max(1.0, held / s.dt));
  const double acceleration = 2 * fit.x[2] / (window * window);
  return {fit.x[1] / window, std::hypot(fit.u(1) * sigma / window, (more.x[1] - fit.x[1]) / window,
                                        acceleration * std::hypot(seat.u, 0.25 * held))};
}

struct Drop {
  double at = 0, size = 0;  ///< s, m/s
  bool counts = true;       ///< as large as was asked for
};

constexpr double drop_reach =
    0.5e-3;                         ///< s on either side of a drop in which the rest of the travel is a cubic
constexpr double drop_bin = 10e-6;  ///< s
constexpr double clear_of_noise = 8;  ///< of a drop, over its noise

/// y[k] += sum of weight[i] x[k + i], a stretch of y at a time that stays near the processor.
POWBENCH_WIDE void add_weighted(std::span<double> y, std::span<const double> x,
                                std::span<const double> weight) {
  constexpr std::size_t stretch = 1024;
  for (std::size_t from = 0; from < y.size(); from += stretch) {
    const std::size_t to = std::min(y.size(), from + stretch);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const double w = weight[i], *const at = x.data() + i;
      for (std::size_t k = from; k < to; ++k) y[k] += w * at[k];
    }
  }
}

/// At every bin the coefficient of max(t - t_bin, 0) beside a polynomial of third degree, by least squares over
/// +-drop_reach. The motion of the base bends the travel, but within that reach it is a cubic to a few per cent of a
/// landing. `late`: s, where a slow laser's values are new at uncertain times: within the reach the core seems to
/// gain that time and to lose it again.
Drops velocity_drops(const Signal& s, double noise, double late) {
  Drops d;
  const auto per = static_cast<std::size_t>(std::max(1.0, std::round(drop_bin / s.dt)));
  d.dt = static_cast<double>(per) * s.dt;
  d.t0 = s.time(0) + 0.5 * (d.dt - s.dt);
  std::vector<double> x(s.size() / per);
  for (std::size_t k = 0; k < x.size(); ++k) {
    for (std::size_t i = 0; i < per; ++i) x[k] += s.value[k * per + i];
    x[k] /= static_cast<double>(per);
  }
  // The odd half of max(u, 0) is a straight line; of |u| / 2 what a parabola leaves is the filter.
  const auto reach = static_cast<std::size_t>(std::max(4.0, std::round(drop_reach / d.dt)));
  const double n = static_cast<double>(2 * reach + 1);
  std::vector<double> weight(2 * reach + 1);
  const auto unit = [&](std::size_t k) {
    return (static_cast<double>(k) - static_cast<double>(reach)) / static_cast<double>(reach);
  };
  double u2 = 0, u4 = 0, a0 = 0, a2 = 0;  // sums of u^2, u^4, |u|, |u|^3
  for (std::size_t k = 0; k < weight.size(); ++k) {
    const double u = std::abs(unit(k));
    u2 += u * u, u4 += u * u * u * u, a0 += u, a2 += u * u * u;
  }
  const double det = n * u4 - u2 * u2, c0 = (a0 * u4 - a2 * u2) / det, c2 = (a2 * n - a0 * u2) / det;
  double square = 0;
  for (std::size_t k = 0; k < weight.size(); ++k) {
    weight[k] = 0.5 * (std::abs(unit(k)) - c0 - c2 * unit(k) * unit(k));
    square += weight[k] * weight[k];
  }
  double gain = 0;
  for (double& w : weight) w /= -square * static_cast<double>(reach) * d.dt, gain += w * w;
  d.lost.assign(x.size(), 0.0);
  if (x.size() > 2 * reach) add_weighted(std::span(d.lost).subspan(reach, x.size() - 2 * reach), x, weight);
  noise *= std::sqrt(gain);
  const auto quiet = static_cast<std::size_t>(std::max(0.0, -d.t0 / d.dt));
  if (quiet > 3 * reach)
    noise = std::max(noise, robust_sigma(std::span(d.lost).subspan(reach, quiet - 2 * reach)));
  d.noise.assign(x.size(), noise);
  if (late > 0)
    for (std::size_t k = reach; k + reach < x.size(); ++k) {
      const double speed = (x[k + reach] - x[k - reach]) / (2 * static_cast<double>(reach) * d.dt);
      d.noise[k] = std::hypot(noise, speed * late * std::sqrt(12.0) / drop_reach);
    }
  return d;
}

/// Largest within half the reach on either side, and above `share` of what `least` and the noise ask for; in time
/// order.
std::vector<Drop> tops(const Drops& d, double t1, double t2, double least, double share = 1) {
  std::vector<Drop> out;
  const auto reach = static_cast<std::size_t>(0.5 * drop_reach / d.dt);
  const auto index = [&](double t) {
    const double k = std::ceil((t - d.t0) / d.dt);
    return static_cast<std::size_t>(std::clamp(k, 0.0, static_cast<double>(d.lost.size())));
  };
  for (std::size_t k = index(t1); k < index(t2); ++k) {
    const double asked = std::max(least, clear_of_noise * d.noise[k]);
    if (d.lost[k] < share * asked) continue;
    const std::size_t a = k > reach ? k - reach : 0, b = std::min(d.lost.size(), k + reach + 1);
    const auto top = std::max_element(d.lost.begin() + static_cast<std::ptrdiff_t>(a),
                                      d.lost.begin() + static_cast<std::ptrdiff_t>(b));
    if (top - d.lost.begin() == static_cast<std::ptrdiff_t>(k))
      out.push_back({d.t0 + static_cast<double>(k) * d.dt, d.lost[k], d.lost[k] >= asked});
  }
  return out;
}

constexpr double first_share = 0.5;  ///< of the largest drop: the first one above it is the seat

/// Later landings. A blow of the contacts moves the static core off and the core after it, which takes velocity from
/// the core's travel before and behind the blow, up to a fifth of what the impact took. Between `doubt_share` of what
/// counts and what counts nobody can say which it was.
constexpr double doubt_share = 0.65;
constexpr double crowded = 100e-6;  ///< s: how far a blow beside it can move the time of a landing

void later_landings(CoreEvents& e, Signal s, const Kink& seat, double first, double noise, double late,
                    double t_end, const ExtractOptions& o) {
  for (std::size_t i = 0; i < s.size(); ++i)  // the impact's own drop taken out
    s.value[i] +=
        (seat.velocity.value - seat.velocity_after) * lost_distance(s.time(i) - seat.at.value, seat.duration);
  const Drops d = velocity_drops(s, noise, late);
  double doubted = 0;
  for (const Drop& drop : tops(d, seat.at.value + o.seat_window, t_end, o.seat_share * first, doubt_share)) {
    if (!drop.counts) {
      doubted = drop.at;
      continue;
    }
    const Kink again = fit_kink(s, drop.at, 0.7 * o.seat_window, 0.7 * o.seat_window, noise);
    e.settled = again.found ? again.at : Measured{drop.at, crowded};
    e.settled.u = std::hypot(e.settled.u, crowded / std::sqrt(3.0));
  }
  if (doubted <= e.settled.value) return;
  e.settled.u = std::hypot(e.settled.u, std::sqrt(0.5) * (doubted - e.settled.value));
  e.flags |= flag_resolution;
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
  // The converter's sample is a mean over its interval: the blow fell inside it. One that rises slowly was there
  // earlier by about the time it takes for as much again.
  std::size_t twice = i;
  while (twice < i2 && std::abs(s.value[twice] - zero) < 2 * level) ++twice;
  return {s.time(i), std::hypot(s.dt / std::sqrt(12.0), s.time(twice) - s.time(i))};
}

/// What a laser shows at the ends of a dropout is no landing, and one may be hidden in it.
void admit_dropout(CoreEvents& e, const Dropout& d, const ExtractOptions& o) {
  if (e.seat.known() && d.to + o.seat_window < e.seat.value) return;
  e.flags |= flag_gap;
  if (!e.seat.known() || d.from - o.seat_window < e.seat.value) {
    e.seat = e.settled = e.bounce_time = e.impact_velocity = {};
    return;
  }
  if (e.settled.known() && d.to > e.settled.value) {
    e.settled.u = std::hypot(e.settled.u, (d.to - e.settled.value) / std::sqrt(3.0));
    e.bounce_time.u = std::hypot(e.settled.u, e.seat.u);
  }
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
  const std::size_t tail = std::max<std::size_t>(10, static_cast<std::size_t>(o.settled_window / s.dt));
  const auto end =
      std::span(s.value).subspan(last - std::min(tail, last - before), std::min(tail, last - before));
  const double closed = median(end), root = std::sqrt(static_cast<double>(end.size()));
  const double travel = closed - open;
  e.travel = {travel, std::hypot(noise / std::sqrt(static_cast<double>(before)),
                                 robust_sigma(end) / root + noise / root)};
  if (std::abs(travel) < 50 * noise) return e;  // it did not move

  // The base may stand a millimetre off when the core lands, but not by two thirds of the travel.
  std::size_t under_way = before;
  while (under_way < last && s.value[under_way] - open < travel / 3) ++under_way;
  if (under_way >= last || travel < 0) return e;
  const auto dropouts =
      laser_dropouts(s, {before, last, open, travel, noise}, record.find(Channel::laser)->scale);
  const Unheld own = unheld(s, 0.5 * s.time(under_way), s.time(last));
  const auto drops = tops(velocity_drops(own.signal, noise, own.late), s.time(under_way), t_end, 0.0);
  if (drops.empty()) return e;
  const double largest =
      std::max_element(drops.begin(), drops.end(), [](auto& a, auto& b) { return a.size < b.size; })->size;
  const Drop first = *std::find_if(drops.begin(), drops.end(),
                                   [&](const Drop& drop) { return drop.size >= first_share * largest; });
  const double window = o.seat_window;  // centred on what a first look finds
  const Kink near = fit_kink(s, first.at, window, window, noise, drop_bin);
  const Kink seat = fit_kink(s, near.velocity.known() ? near.at.value : first.at, window, window, noise);
  if (!seat.velocity.known()) return e;
  e.seat = e.settled = seat.at;
  if (const Measured impact = impact_time(record, e.seat); impact.known()) e.seat = e.settled = impact;
  constexpr double flight = 3;  // windows: what the polynomial follows
  e.impact_velocity =
      flight_velocity(own.signal, {e.seat.value, std::hypot(e.seat.u, own.late)},
                      held_for(s, e.seat.value - flight * window, e.seat.value), flight * window, noise);
  if (e.impact_velocity.value < -3 * e.impact_velocity.u) {  // it lands nowhere while it goes back
    e.seat = e.settled = e.impact_velocity = {};
    return e;
  }
  later_landings(e, own.signal, seat, first.size, noise, own.late, t_end, o);
  // another landing within the resolution would not have been told apart
  e.settled.u = std::hypot(e.settled.u, core_resolution(o) / std::sqrt(3.0));
  e.bounce_time = {e.settled.value - e.seat.value, std::hypot(e.settled.u, e.seat.u)};
  const std::uint8_t mask = s.mask_within(e.seat.value - o.seat_window, e.seat.value + o.seat_window);
  if (mask & mask_gap) e.flags |= flag_gap;
  for (const Dropout& d : dropouts) admit_dropout(e, d, o);
  if (mask & mask_clipped) e.flags |= flag_clipped;
  return e;
}

}  // namespace powbench::dsp
