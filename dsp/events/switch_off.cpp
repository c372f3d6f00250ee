#include "dsp/events/switch_off.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "dsp/signal/mains.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double same_level = 0.03;    // of the largest swing: both rests are one level
constexpr double quiet = 0.01;         // of the largest swing, beside the noise before switch-on: rests
constexpr double active = 0.02;        // of the largest swing: does not rest yet
constexpr double reach = 25e-3;        // s: a period of 40 Hz; the peaks of what goes on return within it
constexpr double stays = 0.9;          // of the largest within `reach`: still goes on
constexpr double pauses = 0.3;         // of the largest within `reach`: between two peaks of a pulsation
constexpr double faded = 0.1;          // of that: a pulsation is over
constexpr double least_rest = 3e-3;    // s
constexpr double half_period = 11e-3;  // s, and a little more
constexpr double settling =
    30e-3;                       // s before the last activity that no sine is fitted to: what a coil induces
constexpr double departs = 0.2;  // of the amplitude
constexpr double departs_for = 0.3e-3;  // s

/// Distance of each sample from the level of the end, a single stray sample taken out.
struct Swing {
  std::vector<double> from_rest;
  double largest = 0, noise = 0;
  std::size_t last = 0;  ///< the last sample that does not rest
};

double spread(std::span<const double> v, double about) {
  double sum = 0;
  for (const double x : v) sum += (x - about) * (x - about);
  return std::sqrt(sum / static_cast<double>(v.size()));
}

/// Nothing where it does not rest at both ends on one level.
bool rests_at_both_ends(const Signal& s, Swing& out) {
  const std::size_t n = s.size(), end = std::max<std::size_t>(8, n / 100);
  if (n < 200) return false;
  const std::span<const double> v(s.value);
  const double rest = median(v.last(end)), before = median(v.first(end));
  out.from_rest.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double a = std::abs(v[i > 0 ? i - 1 : i] - rest), b = std::abs(v[i] - rest),
                 c = std::abs(v[i + 1 < n ? i + 1 : i] - rest);
    out.from_rest[i] = std::max(std::min(a, b), std::min(std::max(a, b), c));
    out.largest = std::max(out.largest, out.from_rest[i]);
  }
  out.noise = robust_sigma(v.first(end));
  if (!(out.largest > 20 * out.noise)) return false;
  if (std::abs(before - rest) > same_level * out.largest + 3 * out.noise) return false;
  if (spread(v.first(end), before) > quiet * out.largest + 3 * out.noise) return false;
  const double threshold = std::max(active * out.largest, 6 * out.noise);
  for (std::size_t i = 0; i < n; ++i)
    if (out.from_rest[i] > threshold) out.last = i;
  const std::size_t behind = n - 1 - out.last;
  if (behind < 8) return false;
  return spread(v.last(behind / 2), rest) <= quiet * out.largest + 3 * out.noise;
}

/// Where a sine of mains frequency breaks off; NaN where there is none.
double sine_left_at(const Signal& s, const Swing& swing) {
  const double t_last = s.time(swing.last), to = t_last - settling;
  std::size_t first = 0;
  while (swing.from_rest[first] < 0.2 * swing.largest) ++first;
  const double from = std::max(s.time(first) + 2e-3, to - 0.1);
  std::optional<HarmonicFit> fit;
  for (const double hertz : {50.0, 60.0}) {
    auto next = fit_harmonics(s, from, to, {1}, hertz, true, 1.5);
    if (next && (!fit || next->sigma < fit->sigma)) fit = std::move(next);
  }
  if (!fit || !(fit->hertz > 40 && fit->hertz < 70)) return unknown;
  const double amplitude = fit->amplitude(0);
  if (amplitude < 0.5 * swing.largest || fit->sigma > 0.1 * amplitude ||
      std::abs(fit->offset) > 0.1 * amplitude)
    return unknown;
  const auto needed = static_cast<std::size_t>(std::ceil(departs_for / s.dt));
  std::size_t run = 0;
  for (std::size_t i = s.index_at(to); i < s.size(); ++i) {
    run = std::abs(s.value[i] - fit->value(s.time(i))) > departs * amplitude ? run + 1 : 0;
    if (run > needed) return s.time(i - run + 1);
  }
  return unknown;
}

/// The last sample that is nearly as large as what was within `reach` before it.
double level_left_at(const Signal& s, const Swing& swing) {
  const auto window = static_cast<std::size_t>(reach / s.dt);
  const std::vector<double>& x = swing.from_rest;
  std::deque<std::size_t> peaks;  // of the window, falling
  std::size_t off = 0;
  double largest = 0;
  for (std::size_t i = 0; i <= swing.last; ++i) {
    while (!peaks.empty() && x[peaks.back()] <= x[i]) peaks.pop_back();
    peaks.push_back(i);
    if (peaks.front() + window < i) peaks.pop_front();
    if (x[i] >= stays * x[peaks.front()]) off = i, largest = x[peaks.front()];
  }
  double least = largest;
  for (std::size_t i = off > window ? off - window : 0; i < off; ++i) least = std::min(least, x[i]);
  double rest = least_rest;
  if (least <
      pauses *
          largest) {  // it may have begun within the window: then the pause is its rest, and this is no loss
    rest = half_period;
    while (off + 1 < x.size() && x[off] > faded * largest) ++off;
  }
  return s.time(s.size() - 1) - s.time(off) < rest ? unknown : s.time(off);
}

}  // namespace

double left_at(const Signal& s) {
  Swing swing;
  if (!rests_at_both_ends(s, swing)) return unknown;
  const double sine = sine_left_at(s, swing);
  if (std::isfinite(sine)) return s.end() - sine < least_rest ? unknown : sine;
  return level_left_at(s, swing);
}

double seen_switch_off(const Record& record) {
  for (const Channel c : {Channel::coil_voltage, Channel::coil_current}) {
    if (record.find(c) == nullptr) continue;
    const double off = left_at(to_signal(record, c));
    return off > 0 ? off : unknown;
  }
  return unknown;
}

SeenReturn seen_return(const Record& record) {
  SeenReturn first;
  for (const Channel c : {Channel::contact_a, Channel::pvdf_a, Channel::pvdf_b, Channel::laser}) {
    if (record.find(c) == nullptr) continue;
    if (const double at = left_at(to_signal(record, c)); at > 0 && !(at >= first.at)) first = {at, c};
  }
  return first;
}

}  // namespace powbench::dsp
