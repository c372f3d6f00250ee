#include "dsp/events/coil.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/phase.h"
#include "dsp/events/switch_off.h"
#include "dsp/events/switch_on.h"
#include "dsp/filter/force.h"
#include "dsp/signal/signal.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double most_unlike =
    0.1;  ///< of the coil voltage's square, that neither rest nor the mains explains
constexpr double most_before = 0.005;  ///< the same of what comes before the step, where it is no noise
constexpr double in_part =
    5;  ///< deviations of noise, by which a sample shows neither rest nor the whole mains
constexpr double step_search = 12e-3;  ///< s after the gate edge in which the coil must start to conduct

/// Sample k from which on the coil carries the mains: least sum of u^2 before k and (u - g m)^2 from k on.
/// Without a mains channel: first sample clear of the noise.
struct Step {
  std::size_t sample = 0;
  double expected = 0;  ///< V: what the coil would show at `sample` when it is on all the time; 0 = not known
  double mean = 0;      ///< s: over all steps by their likelihood, which is wide near a zero of the mains
  double doubt = 0;     ///< s: standard deviation of the same
};

struct Posterior {
  double mean = 0, deviation = 0;  ///< of the index
};

/// By exp(-(sum - lowest) / scale).
Posterior posterior_of(const std::vector<double>& sums, double lowest, double scale) {
  double weight = 0, first = 0, second = 0;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const double w = std::exp(-(sums[k] - lowest) / scale), at = static_cast<double>(k);
    weight += w, first += w * at, second += w * at * at;
  }
  const double mean = first / weight;
  return {mean, std::sqrt(std::max(second / weight - mean * mean, 0.0))};
}

/// The mains without most of its noise: at each sample the parabola through its neighbours within a quarter of a
/// millisecond, at most 50 on either side. `left`: share of the noise's variance that stays. Where more than noise
/// would go, as on notches, it stays as it is.
struct Smoothed {
  std::vector<double> value;  ///< V
  double noise = 0;           ///< V rms, of what was smoothed
  double left = 1;
};
Smoothed smoothed(const std::vector<double>& x, double dt) {
  Smoothed s{x, 0, 1};
  const auto wide = static_cast<std::ptrdiff_t>(0.25e-3 / dt), step = wide / 51 + 1, taps = wide / step;
  const std::ptrdiff_t reach = taps * step;
  const auto n = static_cast<std::ptrdiff_t>(x.size());
  if (taps < 3 || n < 4 * reach) return s;
  std::vector<double> bends;
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    bends.push_back((x[i + 1] - 2 * x[i] + x[i - 1]) / std::sqrt(6.0));
  s.noise = robust_sigma(bends);
  const auto m = static_cast<double>(taps);
  const double norm = (2 * m - 1) * (2 * m + 1) * (2 * m + 3), middle = 3 * (3 * m * m + 3 * m - 1);
  double squares = 0, count = 0;
  for (std::ptrdiff_t i = reach; i < n - reach; ++i) {
    double sum = 0;
    for (std::ptrdiff_t k = -taps; k <= taps; ++k)
      sum += (middle - 15 * static_cast<double>(k * k)) / norm * x[static_cast<std::size_t>(i + k * step)];
    s.value[static_cast<std::size_t>(i)] = sum;
    squares += std::pow(x[static_cast<std::size_t>(i)] - sum, 2), count += 1;
  }
  if (squares > 1.5 * count * s.noise * s.noise) return {x, s.noise, 1};
  s.left = middle / norm;
  return s;
}

std::optional<Step> step_sample(const Signal& coil, const Signal& mains, double noise) {
  const std::size_t i1 = coil.index_at(-1e-3), i2 = coil.index_at(step_search);
  if (i2 < i1 + 4) return std::nullopt;
  if (mains.empty()) {
    for (std::size_t i = i1; i < i2; ++i)
      if (std::abs(coil.value[i]) > 8 * noise) return Step{i, 0.0, coil.time(i), 0.0};
    return std::nullopt;
  }
  std::vector<double> m(i2 - i1);
  double mm = 0, um = 0;
  for (std::size_t i = i1; i < i2; ++i) {
    const double where = (coil.time(i) - mains.t0) / mains.dt;
    const auto j =
        static_cast<std::size_t>(std::clamp(std::floor(where), 0.0, static_cast<double>(mains.size() - 2)));
    const double share = std::clamp(where - static_cast<double>(j), 0.0, 1.0);
    m[i - i1] = mains.value[j] + share * (mains.value[j + 1] - mains.value[j]);
    if (coil.time(i) < 0.5 * step_search) continue;  // gain of the switch from the second half: surely on
    mm += m[i - i1] * m[i - i1];
    um += m[i - i1] * coil.value[i];
  }
  const double gain = mm > 0 ? um / mm : 0.0;
  if (gain < 0.5 || gain > 1.5) return std::nullopt;  // the coil never saw the mains
  const Smoothed calm = smoothed(m, coil.dt);
  m = calm.value;
  // what noise of the mains adds to each e^2 would let a coil that is on pass for one at rest where the mains is small
  const double added = calm.left * gain * gain * calm.noise * calm.noise;
  double sum = 0, lowest = 0, squares = 0;
  std::size_t best = i2;
  std::vector<double> sums(m.size());
  for (std::size_t i = i2; i-- > i1;) {
    const double e = coil.value[i] - gain * m[i - i1], u2 = coil.value[i] * coil.value[i];
    squares += u2;
    sum += e * e - u2 - added;
    sums[i - i1] = sum;
    if (sum < lowest) lowest = sum, best = i;
  }
  if (best == i2 || best == i1) return std::nullopt;
  double rest = 0;
  for (std::size_t i = i1; i < best; ++i) rest += coil.value[i] * coil.value[i];
  const double quiet = 8 * noise * std::sqrt(static_cast<double>(best - i1));
  if (squares + lowest > most_unlike * squares || (rest > quiet * quiet && rest > most_before * squares))
    return std::nullopt;  // rectified, or of another phase
  const Posterior when = posterior_of(sums, lowest, 2 * (noise * noise + added));
  const double mean = coil.time(i1) + when.mean * coil.dt, doubt = when.deviation * coil.dt;
  // A converter that averages shows the step's sample in part; the share decides on which side of it the sum turned.
  const double before = coil.value[best - 1], there = gain * m[best - 1 - i1];
  if (before / there > std::max(0.05, in_part * noise / std::abs(there))) --best;
  return Step{best, gain * m[best - i1], mean, doubt};
}

Measured switch_on_time(const Record& record, const Signal& mains) {
  Signal coil = to_signal(record, Channel::coil_voltage);
  const std::size_t before = coil.index_at(-1e-3);
  if (coil.size() < 20 || before < 10) return {};
  const auto quiet = std::span(coil.value).first(before);
  const double zero = median(quiet);
  const double noise = std::max(robust_sigma(quiet), 1e-9);
  for (double& v : coil.value) v -= zero;
  const auto k = step_sample(coil, mains, noise);
  if (!k) return {};
  const double at = coil.time(k->sample),
               share = k->expected != 0 ? coil.value[k->sample] / k->expected : 1.0;
  // A solid-state switch conducts from the gate edge at time 0 on; that is the answer whenever the samples allow it.
  const double doubt = k->doubt;
  const double least = std::max(0.02, in_part * noise / std::abs(k->expected));
  if (doubt < coil.dt && share > least && share < 1 - least) {
    // The sample is the mean of two or more over its interval, and the coil was on for `share` of them.
    const double middle = at + (0.5 - share) * coil.dt, half = 0.25 * coil.dt;
    const double u = std::hypot(coil.dt * noise / std::abs(k->expected), half / std::sqrt(3.0));
    return {std::abs(middle) <= half ? 0.0 : middle, std::hypot(u, doubt)};
  }
  // Whole: the switch closed somewhere between two samples, and not before the gate edge.
  const double from = std::min(at, k->mean) - coil.dt, reach = 3 * doubt, to = std::max(at, k->mean);
  if (from - reach <= 0 && to + reach >= 0)
    return {0.0, std::hypot(std::max(std::abs(at), 1e-7) / std::sqrt(12.0), doubt)};
  return {doubt < coil.dt ? at - 0.5 * coil.dt : k->mean - 0.5 * coil.dt,
          std::hypot(coil.dt / std::sqrt(12.0), doubt)};
}

Measured peak_current(const Record& record) {
  const Signal s = to_signal(record, Channel::coil_current);
  if (s.size() < 3) return {};
  const std::size_t before = s.index_at(0.0), last = s.index_at(closing_end(record, s));
  const auto quiet = std::span(s.value).first(before);
  const double zero = quiet.empty() ? 0.0 : median(quiet);
  const double noise =
      std::max(robust_sigma(quiet), std::abs(record.find(Channel::coil_current)->scale) / std::sqrt(12.0));
  double peak = 0;
  for (std::size_t i = before; i < last; ++i) peak = std::max(peak, std::abs(s.value[i] - zero));
  return last > before ? Measured{peak, noise} : Measured{};
}

constexpr double inrush =
    25e-3;  ///< s after switch-on that bends the coil's voltage where the source is weak
constexpr double plain_residual = 0.03;  ///< of the amplitude: what a plain sine leaves at most, in rms
constexpr double plain_offset = 0.03;    ///< of the amplitude
constexpr double plain_harmonic = 0.10;  ///< of the amplitude
constexpr double bent = 0.10;            ///< of the amplitude, rms while the inrush flows

/// The mains by the coil's voltage while it is on, and the step at which it comes on.
struct CoilSupply {
  HarmonicFit fit;
  Measured switch_on;
  double u_load = 0;  ///< rad: by as much as the load may turn the phase
};

/// Nothing where the coil's voltage is no plain sine of `min_hum_periods` behind the inrush (rectified, chopped, DC),
/// or does not run on from the step as the same sine.
std::optional<CoilSupply> coil_supply(const Record& record, const ExtractOptions& o) {
  const Measured rough = switch_on_time(record, {});
  if (!rough.known()) return std::nullopt;
  Signal coil = to_signal(record, Channel::coil_voltage);
  const double zero = median(std::span(coil.value).first(coil.index_at(-1e-3)));
  for (double& v : coil.value) v -= zero;
  std::vector<int> orders;
  for (int k = 1; k <= std::max(o.angle_harmonics, 1); k += 2) orders.push_back(k);
  const double off = seen_switch_off(record), from = rough.value + inrush;
  const double to = std::min(closing_end(record, coil), std::isfinite(off) ? off : coil.end()) - 1e-3;
  auto fit = fit_harmonics(coil, from, to, orders, o.mains_hertz, true, o.min_hum_periods);
  if (!fit) return std::nullopt;
  const double amplitude = fit->amplitude(0);
  bool plain = amplitude > 10 * fit->sigma && fit->sigma < plain_residual * amplitude &&
               std::abs(fit->offset) < plain_offset * amplitude &&
               std::abs(fit->hertz - o.mains_hertz) < 0.1 * o.mains_hertz;
  for (std::size_t k = 1; k < orders.size(); ++k)
    plain = plain && fit->amplitude(k) < plain_harmonic * amplitude;
  if (!plain) return std::nullopt;
  CoilSupply found{*fit, {}, 0};
  Signal mains = coil;
  for (std::size_t i = 0; i < mains.size(); ++i) mains.value[i] = fit->value(mains.time(i));
  double squares = 0;
  const std::size_t i1 = coil.index_at(rough.value + 0.5e-3), i2 = coil.index_at(from);
  for (std::size_t i = i1; i < i2; ++i) squares += std::pow(coil.value[i] - mains.value[i], 2);
  if (i2 <= i1 || squares > static_cast<double>(i2 - i1) * bent * bent * amplitude * amplitude)
    return std::nullopt;
  found.switch_on = switch_on_time(record, mains);
  if (!found.switch_on.known()) return std::nullopt;
  // The inrush turns the phase by more than what the closed magnet takes: a bound of what is left in the fit.
  const double first = rough.value + 0.5e-3;
  if (const auto early = fit_harmonics(coil, first, first + 1.05 / fit->hertz, {1}, fit->hertz, false, 1.0))
    found.u_load =
        std::abs(wrap_half_turn(early->phase_at(first).value - fit->phase_at(first).value)) / std::sqrt(3.0);
  return found;
}

/// Odd orders, and the even ones that mains have: what is left out turns the phase.
std::vector<int> supply_orders(const ExtractOptions& o) {
  std::vector<int> orders{1};
  for (int k = 2; k <= o.angle_harmonics; ++k)
    if (k % 2 == 1 || k <= 4) orders.push_back(k);
  return orders;
}

/// V rms: what the fit leaves before switch-on in means over 3 ms, beyond what white noise leaves there. A tone beside
/// the fundamental is there, harmonics that were not fitted are not.
double slow_rest(const Signal& s, const HarmonicFit& fit) {
  Signal rest = s;
  fit.subtract_from(rest);
  const std::size_t n = s.index_at(0.0), block = static_cast<std::size_t>(3e-3 / s.dt);
  if (block < 4 || n < 4 * block) return 0;
  double steps = 0, squares = 0, blocks = 0;
  for (std::size_t i = 1; i < n; ++i)
    steps += (rest.value[i] - rest.value[i - 1]) * (rest.value[i] - rest.value[i - 1]);
  for (std::size_t i = 0; i + block <= n; i += block) {
    double mean = 0;
    for (std::size_t k = i; k < i + block; ++k) mean += rest.value[k] / static_cast<double>(block);
    squares += mean * mean, blocks += 1;
  }
  const double white = steps / 2 / static_cast<double>(n - 1) / static_cast<double>(block);
  return std::sqrt(std::max(squares / blocks - 2 * white, 0.0));
}

/// rad: what the model of a steady mains leaves in the phase at `t`. The newer half of the record sees a mains that
/// moves, or a tone beside it, with a quarter of the error (a parabola's), so the two are three quarters of it apart.
double u_unsteady(const Record& record, const HarmonicFit& fit, double t, const ExtractOptions& o) {
  constexpr double turned =
      3;  // by a tone, over what the fit leaves of it, which takes up most of one close by
  const Signal s = to_signal(record, Channel::mains_voltage);
  const double half = std::max(0.5 * -s.t0, 1.05 / fit.hertz);
  const auto newer = fit_harmonics(s, -half, 0.0, supply_orders(o), fit.hertz, true, 1.0);
  if (!newer) return 0;
  const Measured late = newer->phase_at(t), all = fit.phase_at(t);
  const double apart = wrap_half_turn(late.value - all.value);
  const double excess = apart * apart - late.u * late.u;
  return std::hypot(excess > 0 ? 4.0 / 3.0 * std::sqrt(excess) : 0,
                    turned * slow_rest(s, fit) / fit.amplitude(0));
}

/// Why there is no phase of the supply.
std::string without_supply(const Record& record, const ExtractOptions& o) {
  const Signal s = to_signal(record, Channel::mains_voltage);
  if (s.empty())
    return record.find(Channel::coil_voltage) == nullptr
               ? "no mains-voltage channel"
               : "no mains-voltage channel, and the coil voltage shows no plain sine behind a step";
  std::array<char, 128> text{};
  const double needed = o.min_hum_periods / o.mains_hertz;
  if (-s.t0 < needed)
    std::snprintf(text.data(), text.size(), "%.1f ms of pre-trigger, %.1f needed", std::max(-s.t0, 0.0) * 1e3,
                  needed * 1e3);
  else
    std::snprintf(text.data(), text.size(), "the mains-voltage channel shows no mains near %.0f Hz",
                  o.mains_hertz);
  return text.data();
}

}  // namespace

std::optional<HarmonicFit> supply_fit(const Record& record, const ExtractOptions& o) {
  const Signal s = to_signal(record, Channel::mains_voltage);
  if (s.empty()) return std::nullopt;
  auto fit = fit_harmonics(s, s.t0, 0.0, supply_orders(o), o.mains_hertz, true, o.min_hum_periods);
  if (fit && fit->amplitude(0) < 10 * fit->sigma) return std::nullopt;
  return fit;
}

CoilEvents coil_events(const Record& record, const std::optional<HarmonicFit>& supply,
                       const ExtractOptions& o) {
  CoilEvents e;
  Signal mains = to_signal(record, Channel::mains_voltage);
  if (supply)
    for (double& v : mains.value) v -= supply->offset;  // a zero of the channel is no voltage at the coil
  e.switch_on = switch_on_time(record, mains);
  e.peak_current = peak_current(record);
  if (!std::isnan(contradicted_switch_on(record))) e.flags |= flag_switch_on;
  if (!supply) {
    e.flags |= flag_no_hum_fit;
    const auto by_coil = record.find(Channel::mains_voltage) ? std::nullopt : coil_supply(record, o);
    if (!by_coil) {
      e.no_angle = without_supply(record, o);
      return e;
    }
    const HarmonicFit& fit = by_coil->fit;
    e.switch_on = by_coil->switch_on;
    e.mains_hertz = {fit.hertz, fit.u_hertz};
    e.closing_angle = fit.phase_at(e.switch_on.value);
    e.closing_angle.u =
        std::hypot(std::hypot(e.closing_angle.u, by_coil->u_load), 2 * pi * fit.hertz * e.switch_on.u);
    return e;
  }
  e.mains_hertz = {supply->hertz, supply->u_hertz};
  const double amplitude = supply->amplitude(0);
  e.supply_volts = {amplitude / std::sqrt(2.0), std::sqrt(supply->covariance[supply->parameters + 1] / 2.0)};
  if (!e.switch_on.known()) {
    e.no_angle = !record.find(Channel::coil_voltage) ? "no coil-voltage channel"
                 : switch_on_time(record, {}).known()
                     ? "the coil voltage does not follow the mains voltage: a "
                       "probe is turned round, or it is rectified or of "
                       "another phase"
                     : "the coil voltage shows no switching on";
    return e;
  }
  e.closing_angle = supply->phase_at(e.switch_on.value);
  e.closing_angle.u = std::hypot(std::hypot(e.closing_angle.u, 2 * pi * supply->hertz * e.switch_on.u),
                                 u_unsteady(record, *supply, e.switch_on.value, o));
  return e;
}

}  // namespace powbench::dsp
