#include "dsp/contacts/crest.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double clear = 6;  // standard deviations of the calm force

/// N: robust standard deviation of what is faster than about 1 kHz between two times: the force less the mean of that
/// 0.2 ms before and after.
double fast_part(const CalmForce& calm, const Signal& force, double from, double to) {
  constexpr double lag = 0.2e-3;  // s: half a period of 2.5 kHz
  const std::size_t k = std::max<std::size_t>(1, static_cast<std::size_t>(lag / force.dt + 0.5));
  std::vector<double> fast;
  for (std::size_t i = force.index_at(from); i + k < calm.value.size() && force.time(i) < to; ++i)
    if (i >= k) fast.push_back(calm.value[i] - 0.5 * (calm.value[i - k] + calm.value[i + k]));
  return fast.size() < 20 ? 0.0 : robust_sigma(fast);
}

/// N: amplitude of the vibration that may stand beside an edge at t, from what swings below zero within a few
/// milliseconds, and from the contact at rest. What is seen later may have begun before the edge.
double amplitude_near(const VibratingFilm& film, const Signal& force, const CalmForce& left, double t) {
  constexpr double before = 1.5e-3, as_it_came = 0.5e-3, after = 4e-3;  // s
  const double swings = std::max(swing_below(left, force, t - before, t + after),
                                 swing_below(film.calm, film.unaided, t - as_it_came, t + after));
  return film.last - t < after ? std::max(swings, film.at_rest) : swings;
}

/// The force beside an edge, sample by sample: inwards from 0 on, outwards below.
struct Walk {
  const std::vector<double>& value;
  std::ptrdiff_t at;
  int side;
  bool holds(std::ptrdiff_t k) const {
    const std::ptrdiff_t i = at + side * k;
    return i >= 0 && i < static_cast<std::ptrdiff_t>(value.size());
  }
  double operator()(std::ptrdiff_t k) const { return value[static_cast<std::size_t>(at + side * k)]; }
};

std::ptrdiff_t samples(double seconds, double dt) {
  return static_cast<std::ptrdiff_t>(std::lround(seconds / dt));
}

/// s inwards to the last dip behind a crest before the force rises beyond twice the amplitude; 0 without one.
double last_dip(const Walk& in, double dt, const FoundEdge& edge, double amplitude, double noise) {
  constexpr double outside = 20e-6;                // s: a crest that begins at the edge
  const double depth = edge.side > 0 ? 0.5 : 0.3;  // of the crest
  double crest = 0, lowest = 0;
  std::ptrdiff_t dip = 0;
  bool below = false;
  for (std::ptrdiff_t k = -samples(outside, dt); k <= samples(edge.reach, dt) && in.holds(k); ++k) {
    const double v = in(k);
    if (v > 2 * amplitude) return static_cast<double>(dip) * dt;
    crest = std::max(crest, v);
    const bool now = crest > clear * noise && v < depth * crest;
    if (now && (!below || v < lowest)) lowest = v, dip = k;
    below = now;
  }
  return 0;  // never rises above the vibration: nothing says where it begins
}

/// s inwards of the last sample below a level before the force rises beyond 1.6 times it; NaN where it does not.
double rises_through(const Walk& in, double dt, double reach, double level) {
  constexpr double outside = 20e-6, beyond = 1.6;  // s; of the level
  double at = std::numeric_limits<double>::quiet_NaN();
  for (std::ptrdiff_t k = -samples(outside, dt); k < samples(reach, dt) && in.holds(k); ++k) {
    if (in(k) < level) at = (static_cast<double>(k) + 0.5) * dt;
    if (in(k) > beyond * level) return at;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Where the rise from two to four amplitudes points: F ~ tau^1.25, between a spring and a round pad. The vibration on
/// the way, over the slope there, and the exponent make it uncertain by one and a half times the rise.
Measured edge_beyond(const Walk& in, double dt, double reach, double amplitude) {
  constexpr double exponent = 1.25, uncertain = 1.5;
  const double low = rises_through(in, dt, reach, 2 * amplitude),
               high = rises_through(in, dt, reach, 4 * amplitude);
  if (!(high > low)) return {};
  return {low - (high - low) / (std::exp2(1 / exponent) - 1), uncertain * (high - low)};
}

/// N: largest swing to either side in open time beside the edge.
double swing_beside(const Walk& in, double dt, double open) {
  constexpr double skip = 20e-6, beside = 0.5e-3;  // s
  double most = 0;
  for (std::ptrdiff_t k = samples(skip, dt); k < samples(std::min(beside, open), dt) && in.holds(-k); ++k)
    most = std::max(most, std::abs(in(-k)));
  return most;
}

/// s outwards to the lowest point of a swing below zero that the force rises out of at the edge; 0 without one.
double from_swing(const Walk& in, double dt, double noise) {
  constexpr double farthest = 0.3e-3, wiggle = 4;  // s; standard deviations
  double lowest = in(0);
  std::ptrdiff_t at = 0;
  for (std::ptrdiff_t k = 0; k < samples(farthest, dt) && in.holds(-k); ++k) {
    if (in(-k) < lowest)
      lowest = in(-k), at = k;
    else if (in(-k) > lowest + wiggle * noise)
      break;
  }
  return lowest < -clear * noise ? static_cast<double>(at) * dt : 0;
}

}  // namespace

double swing_below(const CalmForce& calm, const Signal& force, double from, double to) {
  double lowest = 0;
  for (std::size_t i = force.index_at(from); i < std::min(force.index_at(to), force.size()); ++i)
    lowest = std::min(lowest, calm.value[i]);
  return lowest > -clear * calm.noise ? 0 : -lowest;
}

double time_to(const CalmForce& calm, const Signal& force, double edge, int side, double level) {
  constexpr double farthest_rise = 0.5e-3;  // s
  const auto n = static_cast<std::ptrdiff_t>(force.size());
  const auto at = static_cast<std::ptrdiff_t>(force.index_at(edge));
  const auto reach = static_cast<std::ptrdiff_t>(farthest_rise / force.dt);
  std::ptrdiff_t below = 0;
  for (std::ptrdiff_t k = 0; k <= reach && at + side * k >= 0 && at + side * k < n; ++k) {
    const double v = calm.value[static_cast<std::size_t>(at + side * k)];
    if (v >= 2 * level) break;
    if (v < level) below = k + 1;
  }
  return static_cast<double>(below) * force.dt;
}

double vibration_at_rest(const CalmForce& calm, const Signal& force, double touch, double t_end) {
  constexpr double first = 2.5e-3, between = 5e-3, last = 10e-3;  // s after the touch
  constexpr double stands_out = 4, most_growth = 4;
  const double of_noise = std::sqrt(1.5) * calm.noise;
  if (touch + last > std::min(t_end, force.end())) return 0;
  const double early = fast_part(calm, force, touch + first, touch + between),
               late = fast_part(calm, force, touch + between, touch + last);
  if (!(late > stands_out * of_noise)) return 0;
  return std::sqrt(2.0) * early * std::clamp(early / late, 1.0, most_growth);
}

Measured EdgeInVibration::of(const Measured& found, int side) const {
  constexpr double uncertain = 20e-6;  // s
  const double moved = std::hypot(hidden / std::sqrt(3.0), passed / 3);
  const Measured own{found.value + side * passed, passed > 0 ? moved : std::hypot(found.u, moved)};
  if (!(moved > 0) || !(own.u > uncertain) || !beyond.known()) return own;
  const double apart = found.value + side * beyond.value - own.value;
  const double all = own.u * own.u + beyond.u * beyond.u, share = own.u * own.u / all;
  const double u = own.u * beyond.u / std::sqrt(all);
  return {own.value + share * apart, std::hypot(u, 0.5 * apart * std::sqrt(share * (1 - share)))};
}

EdgeInVibration look_at_edge(const VibratingFilm& film, const Signal& force, const CalmForce& left,
                             const FoundEdge& edge) {
  constexpr double least_passed = 15e-6;  // s
  EdgeInVibration out;
  const double amplitude = amplitude_near(film, force, left, edge.time);
  if (!(amplitude > 0)) return out;
  const Walk in{left.value, static_cast<std::ptrdiff_t>(force.index_at(edge.time)), edge.side};
  const double passed = last_dip(in, force.dt, edge, amplitude, left.noise);
  if (passed >= least_passed) {
    out.passed = passed;
    out.hidden = time_to(left, force, edge.time + edge.side * passed, edge.side, amplitude);
  } else if (swing_beside(in, force.dt, edge.open) > clear * left.noise) {
    out.hidden =
        std::max(time_to(left, force, edge.time, edge.side, amplitude), from_swing(in, force.dt, left.noise));
  }
  if (edge.side > 0 && (out.hidden > 0 || out.passed > 0))
    out.beyond = edge_beyond(in, force.dt, edge.reach, amplitude);
  return out;
}

}  // namespace powbench::dsp
