#include "dsp/force.h"

#include <algorithm>
#include <cmath>

#include "core/events.h"
#include "dsp/mains.h"
#include "dsp/statistics.h"

namespace powbench::dsp {

namespace {

std::vector<int> orders_up_to(int highest) {
  std::vector<int> orders;
  for (int k = 1; k <= highest; ++k) orders.push_back(k);
  return orders;
}

/// Hum over the pre-trigger. The frequency is fitted only when the fundamental is clear of the noise.
std::optional<HarmonicFit> fit_hum(const Signal& s, const ExtractOptions& o, std::optional<double> hertz) {
  const auto orders = orders_up_to(o.hum_harmonics);
  auto fit = fit_harmonics(s, s.t0, 0.0, orders, hertz.value_or(o.mains_hertz), false, o.min_hum_periods);
  if (!fit || hertz || orders.empty()) return fit;
  if (fit->amplitude(0) < 10 * std::sqrt(fit->covariance[fit->parameters + 1])) return fit;
  auto free = fit_harmonics(s, s.t0, 0.0, orders, o.mains_hertz, true, o.min_hum_periods);
  return free ? free : fit;
}

std::span<const double> before(const Signal& s, double t) {
  return {s.value.data(), s.index_at(t)};
}

double tail_median(const Signal& s, double t_end, double window) {
  const std::size_t i1 = s.index_at(std::max(t_end - window, 0.0)), i2 = s.index_at(t_end);
  return i2 > i1 ? median(std::span(s.value).subspan(i1, i2 - i1)) : 0.0;
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

/// The film's sign: the settled force when it stands out, else the larger excursion.
bool looks_inverted(const Signal& s, double noise, double settled, double t_end) {
  double high = 0, low = 0;
  for (std::size_t i = s.index_at(0.0); i < s.index_at(t_end); ++i) {
    high = std::max(high, s.value[i]);
    low = std::max(low, -s.value[i]);
  }
  if (std::abs(settled) > 3 * noise && std::abs(settled) > 0.01 * std::max(high, low)) return settled < 0;
  return low > 10 * noise && low > 2 * high;
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

Force restore_force(const Record& record, Channel channel, const ExtractOptions& o,
                    std::optional<double> mains_hertz) {
  Force f;
  f.signal = to_signal(record, channel);
  Signal& s = f.signal;
  if (s.size() < 8) return f;
  const auto [lowest, highest] = std::minmax_element(s.value.begin(), s.value.end());
  if (*lowest == *highest) return f;  // a dead channel shows nothing, not even noise
  f.present = true;

  const auto hum = fit_hum(s, o, mains_hertz);
  const auto quiet = before(s, 0.0);
  if (hum) {
    for (std::size_t i = 0; i < s.size(); ++i) s.value[i] -= hum->value(s.time(i));
  } else {
    f.flags |= flag_no_hum_fit;
    const double zero = quiet.empty() ? s.value.front() : median(quiet);
    for (double& v : s.value) v -= zero;
  }
  const ChannelRecord& c = *record.find(channel);
  f.noise = noise_of(quiet, std::abs(c.scale));
  if (quiet.size() < 20) {  // no pre-trigger: white noise from first differences of the whole record
    std::vector<double> d(s.size() - 1);
    for (std::size_t i = 0; i + 1 < s.size(); ++i) d[i] = (s.value[i + 1] - s.value[i]) / std::sqrt(2.0);
    f.noise = noise_of(d, std::abs(c.scale));
  }
  undo_droop(s.value, c.corner_hertz, s.dt);

  const double t_end = closing_end(record, s);
  f.settled = tail_median(s, t_end, o.settled_window);
  if (looks_inverted(s, f.noise, f.settled, t_end)) {
    f.flags |= flag_polarity;
    for (double& v : s.value) v = -v;
    f.settled = -f.settled;
  }
  f.settled = std::max(f.settled, 0.0);
  return f;
}

}  // namespace powbench::dsp
