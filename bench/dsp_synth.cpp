#include "bench/dsp_synth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {

namespace {

constexpr double pretrigger = 0.040, after_fire = 0.035;

std::uint64_t rotate(std::uint64_t x, int k) {
  return (x << k) | (x >> (64 - k));
}

double shape(PulseForm form, double v) {
  switch (form) {
    case PulseForm::hertz:
      return std::pow(std::sin(pi * v), 1.5);
    case PulseForm::asymmetric:
      return std::sin(pi * std::pow(v, 0.8));
    default:
      return std::sin(pi * v);
  }
}

void add_pulse(std::vector<double>& f, double rate, const TrueContact& c, PulseForm form) {
  const double width = c.release - c.touch;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double v = (static_cast<double>(i) / rate - pretrigger - c.touch) / width;
    if (v > 0 && v < 1) f[i] += c.peak * shape(form, v);
  }
}

/// Three modes around `hertz` (+-15 %), damping 1.5 %, random phases; root-sum-square amplitude `amplitude`.
void add_ring(std::vector<double>& f, double rate, double onset, double amplitude, double hertz,
              Random& random) {
  std::array<double, 3> weight{};
  double squares = 0;
  for (double& w : weight) w = random.uniform(0.4, 1.0), squares += w * w;
  for (const double w : weight) {
    const double omega = 2 * pi * hertz * random.uniform(0.85, 1.15), phase = random.uniform(0, 2 * pi);
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double t = static_cast<double>(i) / rate - pretrigger - onset;
      if (t >= 0)
        f[i] +=
            amplitude * w / std::sqrt(squares) * std::exp(-0.015 * omega * t) * std::sin(omega * t + phase);
    }
  }
}

/// One-pole high-pass, bilinear, as a charge amplifier droops.
void droop(std::vector<double>& f, double rate, double corner) {
  const double w = std::tan(pi * corner / rate), a = (1 - w) / (1 + w), b = 1 / (1 + w);
  double before = 0, out = 0;
  for (double& v : f) {
    const double in = v;
    out = a * out + b * (in - before);
    before = in;
    v = out;
  }
}

ChannelRecord quantise(Channel channel, const std::vector<double>& x, double scale) {
  ChannelRecord c;
  c.channel = channel;
  c.scale = scale;
  c.raw.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    c.raw[i] = static_cast<std::int16_t>(std::lround(std::clamp(x[i] / scale, -32768.0, 32767.0)));
  return c;
}

Record empty_record(double rate) {
  Record r;
  r.sample_rate = rate;
  r.fire_sample = std::llround(pretrigger * rate);
  r.rig = "synthetic";
  r.calibration = "synthetic";
  return r;
}

bool has_ring(ForceCase c) {
  return c == ForceCase::ring_in_band || c == ForceCase::ring_out_of_band || c == ForceCase::ring_overlap ||
         c == ForceCase::ring_and_hum;
}

std::vector<TrueContact> draw_contacts(const SynthSettings& s, Random& random) {
  std::vector<TrueContact> out;
  const bool brief = s.force_case == ForceCase::short_pulses;
  double t = 0.005 + random.uniform(0, 0.002);
  const int bounces = random.uniform() < 0.5 ? 2 : 3;
  for (int k = 0; k < bounces; ++k) {
    const double width = brief ? random.uniform(0.2e-3, 0.6e-3) : random.uniform(0.4e-3, 2.0e-3);
    out.push_back({t, t + width, 10.0 / (1 << k) * random.uniform(0.85, 1.15)});
    t += width + (brief ? random.uniform(0.1e-3, 0.3e-3) : random.uniform(0.15e-3, 1.0e-3));
  }
  out.push_back({t, std::numeric_limits<double>::infinity(), random.uniform(3, 6)});
  return out;
}

void add_settled(std::vector<double>& f, double rate, const TrueContact& c, Random& random) {
  const double rise = random.uniform(0.1e-3, 0.4e-3), phase = random.uniform(0, 2 * pi);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double t = static_cast<double>(i) / rate - pretrigger - c.touch;
    if (t >= 0) f[i] += c.peak * (1 - std::exp(-t / rise)) * (1 + 0.10 * std::sin(2 * pi * 100 * t + phase));
  }
}

/// Travel that lands at `seat` with 1.5 m/s and then follows the yielding base.
std::vector<double> travel(double rate, std::size_t n, double seat, double velocity, Random& random) {
  std::vector<double> x(n);
  const double length = 3.8e-3, duration = 2 * length / velocity;  // constant acceleration
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate - pretrigger - seat;
    const double u = std::clamp(1 + t / duration, 0.0, 1.0);
    const double base = t > 0 ? 0.4e-3 * std::exp(-t / 8e-3) * std::sin(2 * pi * 150 * t) : 0.0;
    x[i] = length * u * u + base + 0.7e-6 * random.normal();
  }
  return x;
}

}  // namespace

std::string_view name(ForceCase c) {
  constexpr std::array<std::string_view, 9> names{"clean",
                                                  "hum 0.5 N",
                                                  "ring 3 kHz 2 N",
                                                  "ring 15 kHz 2 N",
                                                  "ring 3 kHz 2 N from before touch",
                                                  "ring 0.5 N + hum 0.2 N",
                                                  "short 0.2-0.6 ms",
                                                  "droop 5 Hz",
                                                  "clipped at 60 %"};
  return names[static_cast<std::size_t>(c)];
}

std::string_view name(PulseForm f) {
  constexpr std::array<std::string_view, 3> names{"half sine", "Hertz 1.5", "asymmetric"};
  return names[static_cast<std::size_t>(f)];
}

Random::Random(std::uint64_t seed) {
  for (auto& s : s_) {  // splitmix64
    seed += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = seed;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    s = z ^ (z >> 31);
  }
}

std::uint64_t Random::next() {
  const std::uint64_t result = rotate(s_[1] * 5, 7) * 9, t = s_[1] << 17;
  s_[2] ^= s_[0], s_[3] ^= s_[1], s_[1] ^= s_[2], s_[0] ^= s_[3], s_[2] ^= t;
  s_[3] = rotate(s_[3], 45);
  return result;
}

double Random::uniform() {
  return static_cast<double>(next() >> 11) * 0x1.0p-53;
}
double Random::uniform(double low, double high) {
  return low + (high - low) * uniform();
}
double Random::normal() {
  double sum = -6;
  for (int k = 0; k < 12; ++k) sum += uniform();
  return sum;
}

SynthRecord synthesise(const SynthSettings& s, std::uint64_t seed) {
  Random random(seed * 7919 + 17);
  SynthRecord out;
  out.record = empty_record(s.rate);
  std::vector<double> f(static_cast<std::size_t>(std::llround((pretrigger + after_fire) * s.rate)), 0.0);
  out.contacts = draw_contacts(s, random);
  for (const TrueContact& c : out.contacts) {
    if (std::isinf(c.release))
      add_settled(f, s.rate, c, random);
    else
      add_pulse(f, s.rate, c, s.form);
  }
  const bool overlap = s.force_case == ForceCase::ring_overlap;
  const double onset =
      out.contacts.front().touch + (overlap ? random.uniform(-0.5e-3, 0) : random.uniform(0.5e-3, 2.5e-3));
  if (has_ring(s.force_case)) {
    out.ring_onset = onset;
    const double amplitude = s.force_case == ForceCase::ring_and_hum ? 0.5 : 2.0;
    add_ring(f, s.rate, onset, amplitude, s.force_case == ForceCase::ring_out_of_band ? 15e3 : 3e3, random);
  }
  const double hum =
      s.force_case == ForceCase::hum ? 0.5 : (s.force_case == ForceCase::ring_and_hum ? 0.2 : 0.0);
  const double phase1 = random.uniform(0, 2 * pi), phase3 = random.uniform(0, 2 * pi);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double a = 2 * pi * s.mains_hertz * static_cast<double>(i) / s.rate;
    f[i] += hum * (std::sin(a + phase1) + 0.3 * std::sin(3 * a + phase3));
  }
  const double corner = s.force_case == ForceCase::droop ? 5.0 : 0.5;
  droop(f, s.rate, corner);
  out.noise = 10.0 * std::pow(10.0, -s.snr_db / 20);
  for (double& v : f) v += out.noise * random.normal();
  ChannelRecord c = quantise(Channel::pvdf_a, f, 1e-3);
  c.corner_hertz = corner;
  if (s.force_case == ForceCase::clip) {
    c.clip_high = static_cast<std::int16_t>(std::lround(0.6 * out.contacts.front().peak / c.scale));
    for (auto& r : c.raw) r = std::min(r, c.clip_high);
  }
  out.record.channels.push_back(std::move(c));
  if (s.with_core_seat)
    out.record.channels.push_back(
        quantise(Channel::laser, travel(s.rate, f.size(), onset, 1.5, random), 0.25e-6));
  return out;
}

Record synthesise_full(double rate, double mains_hertz, double angle, std::uint64_t seed, FullTruth* truth) {
  Random random(seed * 104729 + 5);
  Record r = empty_record(rate);
  r.conditions.closing_angle = angle;
  r.fire_offset = random.uniform(0, 1 / rate);
  const auto n = static_cast<std::size_t>(std::llround(0.140 * rate));
  const auto channel = [&](Channel c, double scale, double noise, auto&& of_time) {
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = of_time(r.time(i)) + noise * random.normal();
    r.channels.push_back(quantise(c, x, scale));
  };
  const double w = 2 * pi * mains_hertz;
  const auto mains = [&](double t) {
    return 325.0 * (std::sin(w * t + angle) + 0.03 * std::sin(5 * (w * t + angle) + 1));
  };
  const double seat = 0.0135 + random.uniform(0, 1e-3), touch = seat - 1.7e-3;
  const std::vector<TrueContact> train{
      {touch, touch + 0.1e-3, 90},         {touch + 0.8e-3, touch + 0.9e-3, 40},
      {touch + 1.1e-3, seat + 0.05e-3, 6}, {seat + 1.5e-3, seat + 1.6e-3, 70},
      {seat + 2.3e-3, seat + 2.4e-3, 30},  {seat + 2.6e-3}};
  for (const Channel film : {Channel::pvdf_a, Channel::pvdf_b}) {
    std::vector<double> f(n, 0.0);
    for (const TrueContact& c : train)
      for (std::size_t i = 0; i < n; ++i) {
        const double t = r.time(i);
        if (std::isfinite(c.release) && t > c.touch && t < c.release)
          f[i] += c.peak * std::sin(pi * (t - c.touch) / (c.release - c.touch));
        if (!std::isfinite(c.release) && t > c.touch) f[i] += 3.0 * (1 - std::exp(-(t - c.touch) / 2e-4));
      }
    for (std::size_t i = 0; i < n; ++i) {
      const double t = r.time(i) - seat;
      if (t > 0)
        for (const double hertz : {1700.0, 3100.0, 6800.0})
          f[i] += 0.8 * std::exp(-0.015 * 2 * pi * hertz * t) * std::sin(2 * pi * hertz * t + hertz);
    }
    droop(f, rate, 0.5);
    for (double& v : f) v += 0.03 * random.normal();
    r.channels.push_back(quantise(film, f, 8e-3));
    r.channels.back().corner_hertz = 0.5;
  }
  auto x = travel(rate, n, seat + r.fire_offset, 1.5, random);
  for (std::size_t i = 0; i < n; ++i) x[i] += 0;
  r.channels.push_back(quantise(Channel::laser, x, 0.25e-6));
  channel(Channel::coil_current, 1e-4, 0.3e-3, [&](double t) {
    return t > 0 ? 0.5 * (std::sin(w * t + angle - 1.2) - std::exp(-t / 5e-3) * std::sin(angle - 1.2)) : 0.0;
  });
  channel(Channel::coil_voltage, 0.02, 0.15, [&](double t) { return t >= 0 ? mains(t) : 0.0; });
  channel(Channel::mains_voltage, 0.02, 3.25, mains);
  channel(Channel::contact_a, 4e-4, 5e-3, [&](double t) {
    for (const TrueContact& c : train)
      if (t >= c.touch && t < c.release) return 0.0;
    return 6.0;
  });
  channel(Channel::aux, 10.0, 20.0, [&](double t) {
    return t > seat ? 2e3 * std::exp(-(t - seat) / 5e-3) * std::sin(2 * pi * 1700 * (t - seat)) : 0.0;
  });
  if (truth) *truth = {angle, seat, 1.5};
  return r;
}

}  // namespace powbench::bench
