#include "dsp/filter/force.h"

#include <algorithm>
#include <cmath>

#include "core/events.h"
#include "dsp/filter/event_filter.h"
#include "dsp/filter/zero_level.h"
#include "dsp/signal/mains.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

std::vector<int> orders_up_to(int highest) {
  std::vector<int> orders;
  for (int k = 1; k <= highest; ++k) orders.push_back(k);
  return orders;
}

/// Hum over the pre-trigger. The frequency is fitted only when the fundamental is clear of the noise.
std::optional<HarmonicFit> fit_hum(const Signal& s, double quiet_end, const ExtractOptions& o,
                                   std::optional<double> hertz) {
  const auto orders = orders_up_to(o.hum_harmonics);
  auto fit =
      fit_harmonics(s, s.t0, quiet_end, orders, hertz.value_or(o.mains_hertz), false, o.min_hum_periods);
  if (!fit || hertz || orders.empty()) return fit;
  if (fit->amplitude(0) < 10 * std::sqrt(fit->covariance[fit->parameters + 1])) return fit;
  auto free = fit_harmonics(s, s.t0, quiet_end, orders, o.mains_hertz, true, o.min_hum_periods);
  return free ? free : fit;
}

std::span<const double> before(const Signal& s, double t) {
  return {s.value.data(), s.index_at(t)};
}

/// Median of the last `window` s. A record that ends soon after the contact closed is open for most of that: the
/// window is halved, to an eighth at most, until its median stands clear of zero; where none does, it is the first.
double tail_median(const Signal& s, double t_end, double window, double noise) {
  constexpr double clear = 6;
  double whole = 0;
  for (int part = 1; part <= 8; part *= 2) {
    const std::size_t i1 = s.index_at(std::max(t_end - window / part, 0.0)), i2 = s.index_at(t_end);
    if (i2 <= i1) break;
    const double level = median(std::span(s.value).subspan(i1, i2 - i1));
    if (part == 1) whole = level;
    if (std::abs(level) > clear * noise) return level;
  }
  return whole;
}

/// White noise of one sample. Where it is no larger than a count, the median deviation says nothing (most samples are
/// equal) and the plain standard deviation of all values within four counts is taken.
double noise_of(std::span<const double> quiet, double count) {
  const double robust = robust_sigma(quiet), floor = count / std::sqrt(12.0);
  if (robust > 1.5 * count) return robust;
  const double middle = quiet.empty() ? 0.0 : median(quiet);
  double squares = 0, n = 0;
  for (const double v : quiet)
    if (std::abs(v - middle) < 4.5 * count) squares += (v - middle) * (v - middle), n += 1;
  return std::max({robust, floor, n > 0 ? std::sqrt(squares / n) : 0.0});
}

/// Without the straight line through the means of its first and last third: a slow drift of the zero is no noise.
std::vector<double> level(std::span<const double> x) {
  std::vector<double> out(x.begin(), x.end());
  const std::size_t third = x.size() / 3;
  if (third == 0) return out;
  const double first = median(x.first(third)), last = median(x.last(third));
  const double slope = (last - first) / static_cast<double>(x.size() - third);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] -= first + slope * (static_cast<double>(i) - 0.5 * static_cast<double>(third));
  return out;
}

/// End of the time in which nothing touches: switch-on, or before that where the record's time zero is somewhere else
/// and a fifth of the largest excursion is reached earlier.
double quiet_end(const Signal& s, double count) {
  const std::size_t n = s.index_at(0.0), head = std::max<std::size_t>(20, n / 10);
  if (n < 2 * head) return 0.0;
  const auto first = std::span(s.value).first(head);
  const double zero = median(first);
  double largest = 0;
  for (const double v : s.value) largest = std::max(largest, std::abs(v - zero));
  // hum alone stays within four of its own standard deviations
  const double swing = 4 * robust_sigma(std::span(s.value).first(n / 2));
  const double level = std::max({12 * noise_of(first, count), 0.2 * largest, swing});
  for (std::size_t i = 0; i < n; ++i)
    if (std::abs(s.value[i] - zero) > level)
      return std::max(s.time(i) - 0.5e-3, s.t0 + 0.5 * (s.time(i) - s.t0));
  return 0.0;
}

/// The film's sign: the settled force when it stands out, else the larger excursion.
bool looks_inverted(const Signal& s, double noise, double settled, double t_start, double t_end) {
  double high = 0, low = 0;
  for (std::size_t i = s.index_at(t_start); i < s.index_at(t_end); ++i) {
    high = std::max(high, s.value[i]);
    low = std::max(low, -s.value[i]);
  }
  if (std::abs(settled) > 3 * noise && std::abs(settled) > 0.01 * std::max(high, low)) return settled < 0;
  return low > 10 * noise && low > 2 * high;
}

constexpr double pickup_from = 1e-3,
                 pickup_to = 5e-3;  ///< s after switch-on: the coil is on, nothing has touched yet

/// What the film shows of the coil's voltage through stray capacitance: proportional to it, fitted where nothing can
/// have touched yet, subtracted everywhere when it stands out of the noise by 5 standard uncertainties.
void remove_pickup(Signal& s, double noise, const Record& record) {
  const Signal coil = to_signal(record, Channel::coil_voltage);
  if (coil.size() < 20) return;
  const double zero = median(before(coil, 0.0));
  const auto volts = [&](double t) {
    const double where = (t - coil.t0) / coil.dt;
    if (where < 0 || where >= static_cast<double>(coil.size() - 1)) return 0.0;
    const auto i = static_cast<std::size_t>(where);
    const double share = where - static_cast<double>(i);
    return coil.value[i] * (1 - share) + coil.value[i + 1] * share - zero;
  };
  double n = 0, sv = 0, sx = 0, svv = 0, svx = 0, sxx = 0;
  for (std::size_t i = s.index_at(pickup_from); i < s.index_at(pickup_to); ++i) {
    if (s.masked[i]) continue;
    const double v = volts(s.time(i)), x = s.value[i];
    n += 1, sv += v, sx += x, svv += v * v, svx += v * x, sxx += x * x;
  }
  if (n < 100 || !(svv > 0)) return;
  const double gain = svx / svv, left = sxx - gain * svx;
  if (left > 2 * n * noise * noise || gain * gain * svv < 25 * noise * noise) return;
  for (std::size_t i = s.index_at(0.0); i < s.size(); ++i) s.value[i] -= gain * volts(s.time(i));
}

}  // namespace

void undo_droop(std::span<double> y, double corner_hertz, double dt) {
  if (!(corner_hertz > 0)) return;
  const double w = std::tan(pi * corner_hertz * dt);
  double sum = 0;
  for (double& v : y) {
    const double in = v;
    v = (1 + w) * in + 2 * w * sum;
    sum += in;
  }
}

double closing_end(const Record& record, const Signal& s) {
  const double hold = record.conditions.hold_time;
  return std::isfinite(hold) && hold > 0 ? std::min(hold, s.end()) : s.end();
}

namespace {

/// Force of one channel, the other film's share still in it.
Force restore_alone(const Record& record, Channel channel, const ExtractOptions& o,
                    std::optional<double> mains_hertz) {
  Force f;
  f.signal = to_signal(record, channel);
  Signal& s = f.signal;
  if (s.size() < 8) return f;
  const auto [lowest, highest] = std::minmax_element(s.value.begin(), s.value.end());
  if (*lowest == *highest) return f;  // a dead channel shows nothing, not even noise
  f.present = true;
  f.delay = std::abs(record.find(channel)->delay);

  const ChannelRecord& c = *record.find(channel);
  const double count = std::abs(c.scale), t_quiet = quiet_end(s, count);
  const auto hum = fit_hum(s, t_quiet, o, mains_hertz);
  auto quiet = before(s, t_quiet);
  const bool no_pretrigger = quiet.size() < 20;
  if (hum) {
    hum->subtract_from(s);
  } else {
    f.flags |= flag_no_hum_fit;
    // without a pre-trigger the zero is what the record begins with
    const auto head = std::span<const double>(s.value).first(
        std::clamp<std::size_t>(s.size() / 50, 1, static_cast<std::size_t>(1.0 + 0.5e-3 / s.dt)));
    const double zero = median(no_pretrigger ? head : quiet);
    for (double& v : s.value) v -= zero;
  }
  f.noise = noise_of(level(quiet), count);
  if (!hum) {  // hum may be left: white noise from first differences, without a pre-trigger those of the whole record
    const auto of = no_pretrigger ? std::span<const double>(s.value) : quiet;
    std::vector<double> d(of.size() - 1);
    for (std::size_t i = 0; i + 1 < of.size(); ++i) d[i] = (of[i + 1] - of[i]) / std::sqrt(2.0);
    f.noise = noise_of(d, count);
  }
  undo_droop(s.value, c.corner_hertz, s.dt);
  remove_pickup(s, f.noise, record);
  f.wander = follow_zero(s, f.noise, mains_hertz.value_or(o.mains_hertz)).wander;

  const double t_end = closing_end(record, s);
  f.settled = tail_median(s, t_end, o.settled_window, f.noise);
  if (looks_inverted(s, f.noise, f.settled, std::min(t_quiet, 0.0), t_end)) {
    f.flags |= flag_polarity;
    for (double& v : s.value) v = -v;
    f.settled = -f.settled;
  }
  f.settled = std::max(f.settled, 0.0);
  return f;
}

}  // namespace

void unmix(Force& force, const Force& other, double own_share, double other_share) {
  const Signal& from = other.signal;
  Signal& s = force.signal;
  if (own_share == 0 || !force.present || !other.present) return;
  const double whole = 1 / (1 - own_share * other_share);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double at = (s.time(i) - from.t0) / from.dt;
    if (!(at > -1 && at < static_cast<double>(from.size()))) continue;
    const auto k = static_cast<std::size_t>(std::max(at, 0.0));
    const std::size_t next = std::min(k + 1, from.size() - 1);
    const double part = std::clamp(at - static_cast<double>(k), 0.0, 1.0);
    s.value[i] =
        whole * (s.value[i] - own_share * (from.value[k] + part * (from.value[next] - from.value[k])));
    s.masked[i] |= static_cast<std::uint8_t>((from.masked[k] | from.masked[next]) & mask_gap);
  }
  force.noise = whole * std::hypot(force.noise, own_share * other.noise);
  force.settled = std::max(0.0, whole * (force.settled - own_share * other.settled));
}

Force restore_force(const Record& record, Channel channel, const ExtractOptions& o,
                    std::optional<double> mains_hertz) {
  Force f = restore_alone(record, channel, o, mains_hertz);
  const bool is_a = channel == Channel::pvdf_a;
  const double own = is_a ? o.crosstalk_a : o.crosstalk_b, others = is_a ? o.crosstalk_b : o.crosstalk_a;
  if (own != 0 && f.present)
    unmix(f, restore_alone(record, is_a ? Channel::pvdf_b : Channel::pvdf_a, o, mains_hertz), own, others);
  if (f.present && o.filter.judged) apply_filter(f.signal, o.filter);
  return f;
}

}  // namespace powbench::dsp
