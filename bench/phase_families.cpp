#include "bench/phase_families.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/units.h"

namespace powbench::bench {

namespace {

/// Draws of the parameters.
struct Dice {
  Random random;
  double between(double low, double high) { return low + (high - low) * random.uniform(); }
  /// Evenly spread in its logarithm.
  double log_between(double low, double high) { return low * std::pow(high / low, random.uniform()); }
  double either(double a) { return random.uniform() < 0.5 ? a : -a; }
  bool chance(double p) { return random.uniform() < p; }
};

constexpr std::size_t track_points = static_cast<std::size_t>((case_seconds + 0.3) * track_hertz) + 1;

double time_of(std::size_t k) {
  return static_cast<double>(k) / track_hertz;
}

void set_harmonic(MainsCase& c, int order, double share, Dice& d) {
  c.harmonics[static_cast<std::size_t>(order)] = std::polar(share, d.between(0, 2 * pi));
}

/// A supply somewhere between 45 and 65 Hz, two of three near 50 or 60, with a little of everything that is usual.
MainsCase usual(std::string_view family, Dice& d) {
  MainsCase c;
  c.family = family;
  c.start_turns = d.random.uniform();
  c.amplitude = d.between(0.9, 1.08);
  const double where = d.random.uniform();
  const double hertz = where < 0.35   ? 50 + d.between(-0.05, 0.05)
                       : where < 0.70 ? 60 + d.between(-0.05, 0.05)
                                      : d.between(45.5, 64.5);
  c.track.assign(track_points, hertz);
  c.noise = d.log_between(2e-4, 3e-3);
  c.offset = d.either(d.between(0, 0.005));
  const double distortion = d.between(0, 0.04);
  set_harmonic(c, 3, 0.5 * distortion, d);
  set_harmonic(c, 5, 0.7 * distortion, d);
  set_harmonic(c, 7, 0.4 * distortion, d);
  set_harmonic(c, 11, 0.2 * distortion, d);
  return c;
}

/// Keeps the whole track within 45 .. 65 Hz by turning the movement over, else by shifting it.
void move(MainsCase& c, const std::vector<double>& by) {
  const double centre = c.track.front();
  const auto [low, high] = std::minmax_element(by.begin(), by.end());
  double sign = 1, shift = 0;
  if (centre + *high > 64.9 || centre + *low < 45.1) sign = -1;
  const double top = centre + (sign > 0 ? *high : -*low), bottom = centre + (sign > 0 ? *low : -*high);
  if (top > 64.9) shift = 64.9 - top;
  if (bottom < 45.1) shift = 45.1 - bottom;
  for (std::size_t k = 0; k < by.size(); ++k) c.track[k] = centre + shift + sign * by[k];
}

/// White noise through two equal one-pole low-passes, scaled to `rms`.
std::vector<double> slow_noise(Dice& d, double rms, double corner) {
  const double keep = std::exp(-2 * pi * corner / track_hertz);
  std::vector<double> out(track_points);
  double a = 0, b = 0, square = 0;
  for (int k = -3000; k < static_cast<int>(track_points); ++k) {
    a = keep * a + (1 - keep) * d.random.normal();
    b = keep * b + (1 - keep) * a;
    if (k >= 0) out[static_cast<std::size_t>(k)] = b;
  }
  // the variance that white noise leaves behind: the sum of squares of the impulse response p^2 (n + 1) q^n
  double response = 0, p = 1 - keep;
  for (int n = 0; n < 100000; ++n) {
    const double h = p * p * (n + 1) * std::pow(keep, n);
    response += h * h;
    if (n > 10 && h < 1e-12) break;
  }
  square = std::sqrt(response);
  for (double& value : out) value *= rms / square;
  return out;
}

void quiet(MainsCase& c, Dice& d) {
  move(c, slow_noise(d, d.log_between(0.002, 0.02), d.between(0.05, 0.3)));
}

void ramp(MainsCase& c, Dice& d) {
  const double rate = d.either(d.log_between(0.5, 5));
  const double from = d.between(0.7, 1.2), to = from + d.between(0.3, 1.2);
  std::vector<double> by(track_points);
  for (std::size_t k = 0; k < by.size(); ++k) by[k] = rate * (std::clamp(time_of(k), from, to) - from);
  move(c, by);
  c.onsets = {from, to};
}

void hunting(MainsCase& c, Dice& d) {
  const double size = d.log_between(0.05, 1), hertz = d.log_between(0.3, 2), start = d.between(0, 2 * pi);
  std::vector<double> by(track_points);
  for (std::size_t k = 0; k < by.size(); ++k) by[k] = size * std::sin(2 * pi * hertz * time_of(k) + start);
  move(c, by);
}

void frequency_noise(MainsCase& c, Dice& d) {
  move(c, slow_noise(d, d.log_between(0.01, 0.1), d.log_between(0.5, 5)));
}

/// A load step on a governed set: the frequency falls with the power missing and is brought back by the governor.
void generator_set(MainsCase& c, Dice& d) {
  const double w = d.log_between(2, 8), damping = d.between(0.3, 0.8), rate = d.either(d.log_between(1, 6));
  const double at = d.between(0.7, 1.5), wd = w * std::sqrt(1 - damping * damping);
  const auto rough = slow_noise(d, d.log_between(0.01, 0.05), d.between(0.5, 3));
  std::vector<double> by(track_points);
  for (std::size_t k = 0; k < by.size(); ++k) {
    const double t = time_of(k) - at;
    by[k] = rough[k] + (t > 0 ? rate / wd * std::exp(-damping * w * t) * std::sin(wd * t) : 0.0);
  }
  move(c, by);
  c.onsets = {at};
  set_harmonic(c, 5, d.between(0.01, 0.05), d);
  set_harmonic(c, 7, d.between(0.01, 0.03), d);
}

void interharmonic(MainsCase& c, Dice& d) {
  const double order = d.log_between(0.25, 3.7);
  c.tones.push_back({order * c.track.front(), d.log_between(0.002, 0.02), d.random.uniform()});
}

void subharmonic(MainsCase& c, Dice& d) {
  c.tones.push_back(
      {c.track.front() / (d.chance(0.7) ? 2 : 3), d.log_between(0.005, 0.03), d.random.uniform()});
}

void spikes(MainsCase& c, Dice& d) {
  c.spike = d.between(0.1, 0.6);
  c.spikes_a_second = d.log_between(20, 300);
}

void flicker(MainsCase& c, Dice& d) {
  c.flicker = d.log_between(0.01, 0.06);
  c.flicker_hertz = d.log_between(1, 20);
  c.flicker_square = d.chance(0.25);
}

void ripple(MainsCase& c, Dice& d) {
  c.tones.push_back({d.log_between(2000, 18000), d.log_between(0.01, 0.1), d.random.uniform()});
}

void ripple_control(MainsCase& c, Dice& d) {
  static constexpr std::array<double, 8> used = {110, 175, 190, 216.67, 283.33, 492, 1050, 1350};
  Tone tone{used[d.random.below(used.size())], d.log_between(0.01, 0.05), d.random.uniform()};
  tone.period = d.between(0.2, 1.5);
  tone.to = tone.period * d.between(0.3, 0.7);
  c.tones.push_back(tone);
}

void notches(MainsCase& c, Dice& d) {
  c.notch_depth = d.between(0.2, 0.9);
  c.notch_seconds = d.log_between(100e-6, 600e-6);
  c.notch_start = d.between(5, 45);
}

void half_wave(MainsCase& c, Dice& d) {
  c.half_wave = d.either(d.log_between(0.01, 0.06));
  c.half_wave_from = d.chance(0.5) ? d.between(0.8, 2) : 0;
}

void capacitor(MainsCase& c, Dice& d) {
  for (int i = 0; i < 2; ++i) {
    const double at = d.between(0.8, 2.8);
    c.transients.push_back({at, d.between(0.1, 0.6), d.log_between(300, 1200), d.log_between(0.002, 0.02)});
    c.events.push_back({at, 10, 1 + d.between(0, 0.02), d.either(d.between(0, 0.5)) / 360});
    c.breaks.push_back(at);
  }
}

void sag(MainsCase& c, Dice& d) {
  const double from = d.between(0.8, 1.5), to = from + d.log_between(0.02, 0.4);
  c.events.push_back({from, to, d.between(0.1, 0.9), d.either(d.between(2, 40)) / 360});
  c.breaks = {from, to};
}

void missing(MainsCase& c, Dice& d) {
  c.missing_from = d.between(0.8, 2);
  c.missing_to = c.missing_from + d.between(0.015, 0.12);
  c.breaks = {c.missing_from, c.missing_to};
}

void clipped(MainsCase& c, Dice& d) {
  c.amplitude = d.between(1.0, 1.15);
  c.offset = d.either(d.between(0.01, 0.08));
  c.clip_high = d.between(0.85, 1.05);
  c.clip_low = d.chance(0.5) ? -c.clip_high : -10;
}

void noisy(MainsCase& c, Dice& d) {
  (d.chance(0.5) ? c.noise : c.band_noise) = d.log_between(0.005, 0.03);
}

void distorted(MainsCase& c, Dice& d) {
  for (int order = 2; order <= 15; ++order)
    set_harmonic(c, order, d.between(0, order % 2 == 1 ? 0.25 : 0.06) / order, d);
}

void everything(MainsCase& c, Dice& d) {
  const double size = d.between(0.2, 1);
  distorted(c, d);
  c.band_noise = 0.007 * size;
  c.offset = d.either(0.05 * size);
  c.notch_depth = 0.4 * size;
  c.notch_seconds = 100e-6;
  c.tones.push_back({c.track.front() * d.between(1.45, 1.55), 0.01 * size, d.random.uniform()});
  if (d.chance(0.5)) quiet(c, d);
}

struct Family {
  std::string_view name;
  void (*disturb)(MainsCase&, Dice&);
};
constexpr std::array families = {Family{"quiet grid", quiet},
                                 Family{"ramp 0.5..5 Hz/s", ramp},
                                 Family{"hunting 0.05..1 Hz", hunting},
                                 Family{"frequency noise", frequency_noise},
                                 Family{"generator set", generator_set},
                                 Family{"interharmonic", interharmonic},
                                 Family{"subharmonic", subharmonic},
                                 Family{"spikes", spikes},
                                 Family{"flicker", flicker},
                                 Family{"PWM ripple", ripple},
                                 Family{"keyed ripple control", ripple_control},
                                 Family{"commutation notches", notches},
                                 Family{"half-wave load", half_wave},
                                 Family{"capacitor switching", capacitor},
                                 Family{"sag with phase jump", sag},
                                 Family{"missing half-waves", missing},
                                 Family{"clipped and offset", clipped},
                                 Family{"noise 0.5..3 %", noisy},
                                 Family{"distorted", distorted},
                                 Family{"everything", everything}};

}  // namespace

MainsCase plain_case(double hertz, std::uint64_t seed) {
  MainsCase c;
  c.family = "by hand";
  c.seed = seed;
  c.start_turns = Random(seed).uniform();
  c.track.assign(track_points, hertz);
  return c;
}

std::span<const std::string_view> family_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const Family& family : families) list.push_back(family.name);
    return list;
  }();
  return names;
}

MainsCase draw_case(std::string_view name, Draws draws, int number) {
  for (std::size_t f = 0; f < families.size(); ++f) {
    if (families[f].name != name) continue;
    const std::uint64_t seed = 1'000'000'000U * static_cast<std::uint64_t>(draws) + 1'000'000U * f +
                               static_cast<std::uint64_t>(number);
    Dice dice{Random(seed)};
    MainsCase drawn = usual(families[f].name, dice);
    families[f].disturb(drawn, dice);
    drawn.seed = seed;
    return drawn;
  }
  throw std::invalid_argument("no family of mains is called '" + std::string(name) + "'");
}

CaseSource::CaseSource(const MainsCase& c) : case_(&c), turns_(c.track.size()), random_(c.seed + 77) {
  turns_[0] = c.start_turns;
  for (std::size_t k = 1; k < turns_.size(); ++k)
    turns_[k] = turns_[k - 1] + 0.5 * (c.track[k - 1] + c.track[k]) / track_hertz;
}

double CaseSource::phase(double t) const {
  const double place = t * track_hertz;
  const auto k = static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(turns_.size()) - 2));
  const double dt = (place - static_cast<double>(k)) / track_hertz;
  double turns = turns_[k] + case_->track[k] * dt +
                 0.5 * (case_->track[k + 1] - case_->track[k]) * track_hertz * dt * dt;
  for (const Event& e : case_->events) turns += t >= e.from && t < e.to ? e.jump : 0.0;
  return turns;
}

double CaseSource::hertz(double t) const {
  const auto k =
      static_cast<std::size_t>(std::clamp(t * track_hertz, 0.0, static_cast<double>(turns_.size()) - 1));
  return case_->track[k];
}

bool CaseSource::breaks(double from, double to) const {
  return std::any_of(case_->breaks.begin(), case_->breaks.end(),
                     [&](double at) { return at > from && at <= to; });
}

bool CaseSource::onsets(double from, double to) const {
  return std::any_of(case_->onsets.begin(), case_->onsets.end(),
                     [&](double at) { return at > from && at <= to; });
}

double CaseSource::waveform(double t) {
  const MainsCase& c = *case_;
  const double turns = phase(t);
  const std::complex<double> z = std::polar(1.0, 2 * pi * (turns - std::floor(turns)));
  double sine = z.imag();
  double value = sine;
  std::complex<double> power = z;
  for (std::size_t k = 2; k < c.harmonics.size(); ++k) {
    power *= z;
    value += c.harmonics[k].real() * power.imag() + c.harmonics[k].imag() * power.real();
  }
  if (c.missing_from >= 0 && t >= c.missing_from && t < c.missing_to && sine > 0) value = sine = 0;
  if (c.notch_depth > 0) {
    const double degrees_in = (turns - std::floor(turns)) * 360.0;
    const double in_sixth = std::fmod(degrees_in - c.notch_start + 360.0, 60.0);
    if (in_sixth < c.notch_seconds * hertz(t) * 360.0)
      value -= std::copysign(c.notch_depth, sine) * std::min(1.0, std::abs(value));
  }
  if (c.half_wave != 0 && t >= c.half_wave_from)
    value -= c.half_wave * std::max(0.0, std::copysign(1.0, c.half_wave) * sine);
  double factor = c.amplitude;
  if (c.flicker > 0) {
    const double wave = std::sin(2 * pi * c.flicker_hertz * t);
    factor *= 1 + c.flicker * (c.flicker_square ? std::copysign(1.0, wave) : wave);
  }
  for (const Event& e : c.events) factor *= t >= e.from && t < e.to ? e.factor : 1.0;
  value *= factor;
  for (const Tone& tone : c.tones) {
    const double place = tone.period > 0 ? std::fmod(t, tone.period) : 0.0;
    if (tone.period == 0 || (place >= tone.from && place < tone.to))
      value += tone.share * std::sin(2 * pi * (tone.hertz * t + tone.turns));
  }
  for (const Transient& e : c.transients)
    if (t >= e.at && t < e.at + 10 * e.decay)
      value += e.share * std::exp(-(t - e.at) / e.decay) * std::sin(2 * pi * e.hertz * (t - e.at));
  return value + c.offset;
}

std::int16_t CaseSource::next() {
  const MainsCase& c = *case_;
  double value = waveform(static_cast<double>(index_) / mains_rate);
  if (c.noise > 0) value += c.noise * random_.normal();
  if (c.band_noise > 0) {
    if (index_ % 10 == 3) held_noise_ = c.band_noise * random_.normal();
    value += held_noise_;
  }
  if (c.spike > 0 && random_.uniform() < c.spikes_a_second / mains_rate)
    value += random_.uniform() < 0.5 ? c.spike : -c.spike;
  ++index_;
  value = std::clamp(value, c.clip_low, c.clip_high);
  const double steps = std::round(value * mains_counts / 16.0);
  return static_cast<std::int16_t>(std::clamp(steps, -2048.0, 2047.0) * 16.0);
}

}  // namespace powbench::bench
