#include "bench/events/scenes.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {

namespace {

constexpr double usual_noise = 0.03;  // N, one sample

/// What is laid over the contact force; each class changes a few.
struct Film {
  double rate = 200e3;           // Hz
  double pretrigger = 50e-3;     // s
  double after = 60e-3;          // s
  double noise = usual_noise;    // N
  double corner = 0.5;           // Hz, of the amplifier
  double hum = 0, hum_jump = 0;  // N; rad at switch-on
  double drift = 0;              // N: exponential approach within 30 ms of switch-on
  double slope = 0;              // N/s through the record
  double coloured = 0;           // N rms of a first-order noise with 2 ms
  double ring = 0;               // N, of each source
  int rings = 1;                 // sources, 0.4 .. 1.2 ms apart
  double bursts = 0;             // N, EMI of 100 us
};

void add_hum(std::vector<double>& f, const Film& film, Random& r) {
  const double a1 = r.uniform(0, 2 * pi), a3 = r.uniform(0, 2 * pi), hertz = r.uniform(49.9, 50.1);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double t = static_cast<double>(i) / film.rate;
    const double a = 2 * pi * hertz * t + (t > film.pretrigger ? film.hum_jump : 0.0);
    f[i] += film.hum * (std::sin(a + a1) + 0.2 * std::sin(3 * a + a3));
  }
}

void add_drift(std::vector<double>& f, const Film& film) {
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double t = static_cast<double>(i) / film.rate - film.pretrigger;
    f[i] += film.slope * t + (t > 0 ? film.drift * -std::expm1(-t / 30e-3) : 0.0);
  }
}

void add_coloured(std::vector<double>& f, const Film& film, Random& r) {
  const double keep = std::exp(-1 / film.rate / 2e-3);
  double x = 0;
  for (double& v : f) v += x = keep * x + film.coloured * std::sqrt(1 - keep * keep) * r.normal();
}

/// Modes of a struck frame: three frequencies of 1.2 .. 9 kHz, damping ratios of 0.8 .. 2.5 %.
void add_rings(std::vector<double>& f, const Film& film, double from, Random& r) {
  for (int k = 0; k < film.rings; ++k) {
    const double onset = from + (k > 0 ? r.uniform(0.4e-3, 1.2e-3) : 0.0);
    for (const double low : {1.2e3, 2.6e3, 5.5e3}) {
      const double hertz = low * r.uniform(1, 1.6), ratio = r.uniform(0.008, 0.025),
                   share = r.uniform(0.2, 1);
      for (std::size_t i = 0; i < f.size(); ++i) {
        const double t = static_cast<double>(i) / film.rate - film.pretrigger - onset;
        if (t > 0)
          f[i] += film.ring * share * std::exp(-ratio * 2 * pi * hertz * t) * std::sin(2 * pi * hertz * t);
      }
    }
  }
}

void add_bursts(std::vector<double>& f, const Film& film, Random& r) {
  for (int k = 0; k < 6; ++k) {
    const double at = r.uniform(0.1, 0.9) * static_cast<double>(f.size()) / film.rate;
    const double hertz = r.uniform(30e3, 80e3), sign = r.uniform() < 0.5 ? -1 : 1;
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double t = static_cast<double>(i) / film.rate - at;
      if (t > 0 && t < 0.4e-3)
        f[i] += sign * film.bursts * std::exp(-t / 50e-6) * std::cos(2 * pi * hertz * t);
    }
  }
}

/// One-pole high-pass of the charge amplifier, exact for steps held over a sample.
void charge_amplifier(std::vector<double>& f, const Film& film) {
  const double keep = std::exp(-2 * pi * film.corner / film.rate);
  double out = 0, before = 0;
  for (double& v : f) {
    out = keep * (out + v - before);
    before = v;
    v = out;
  }
}

Scene scene_of(const Film& film, const Impact* impact, Random& r, double ring_from) {
  Scene out;
  const auto n = static_cast<std::size_t>(std::llround((film.pretrigger + film.after) * film.rate));
  const auto fire = static_cast<std::size_t>(std::llround(film.pretrigger * film.rate));
  std::vector<double> f(n, 0.0);
  if (impact) {
    Closing c = closing_of(*impact, film.after, film.rate);
    std::copy(c.force.begin(), c.force.end(), f.begin() + static_cast<std::ptrdiff_t>(fire));
    out.contacts = std::move(c.contacts);
    const double end = film.after;
    std::erase_if(out.contacts, [&](const TrueContact& x) { return x.touch >= end; });
    // 100 Hz of the magnet presses once the contact stays
    const double phase = r.uniform(0, 2 * pi);
    const double from = out.contacts.empty() ? end : out.contacts.back().touch;
    for (std::size_t i = fire; i < n; ++i) {
      const double t = static_cast<double>(i - fire) / film.rate - from;
      if (t > 2e-3)
        f[i] += 0.08 * impact->settled * -std::expm1(-(t - 2e-3) / 2e-3) * std::sin(2 * pi * 100 * t + phase);
    }
  }
  if (film.ring > 0) add_rings(f, film, ring_from, r);
  if (film.hum > 0) add_hum(f, film, r);
  add_drift(f, film);
  if (film.coloured > 0) add_coloured(f, film, r);
  if (film.bursts > 0) add_bursts(f, film, r);
  charge_amplifier(f, film);
  ChannelRecord c;
  c.channel = Channel::pvdf_a;
  c.scale = 2e-3;
  c.corner_hertz = film.corner;
  for (const double v : f)
    c.raw.push_back(static_cast<std::int16_t>(
        std::lround(std::clamp((v + film.noise * r.normal()) / c.scale, -32768.0, 32767.0))));
  out.record.sample_rate = film.rate;
  out.record.fire_sample = static_cast<std::int64_t>(fire);
  out.record.rig = out.record.calibration = "synthetic";
  out.record.channels.push_back(std::move(c));
  return out;
}

Impact draw(Pad pad, double loss, Random& r) {
  Impact i;
  i.pad = pad;
  i.loss = loss;
  i.width = 0.25e-3 * std::pow(5.0, r.uniform());
  i.peak = r.uniform(6, 25);
  i.settled = r.uniform(2.5, 6);
  i.first_touch = r.uniform(5e-3, 12e-3);
  return i;
}

template <Pad pad, int percent>
Scene family(std::uint64_t seed) {
  Random r(seed * 6151 + 1000 * static_cast<std::uint64_t>(pad) + percent);
  const Impact i = draw(pad, percent / 100.0, r);
  return scene_of({}, &i, r, 0);
}

/// Hunt-Crossley under a disturbance. The ring starts with the core's landing, 1 .. 3 ms after the first touch.
template <void (*change)(Film&, Random&)>
Scene disturbed(std::uint64_t seed) {
  Random r(seed * 7877 + 11);
  const Impact i = draw(Pad::hunt_crossley, r.uniform(0.05, 0.3), r);
  Film film;
  change(film, r);
  return scene_of(film, &i, r, i.first_touch + r.uniform(1e-3, 3e-3));
}

template <void (*change)(Film&, Random&)>
Scene nothing(std::uint64_t seed) {
  Random r(seed * 8221 + 29);
  Film film;
  change(film, r);
  return scene_of(film, nullptr, r, r.uniform(6e-3, 12e-3));
}

void hum_04(Film& f, Random&) {
  f.hum = 0.4;
}
void hum_jump(Film& f, Random& r) {
  f.hum = 0.4, f.hum_jump = r.uniform(0.5, 2.5);
}
void drifting(Film& f, Random& r) {
  f.drift = r.uniform(-1.5, 1.5), f.slope = r.uniform(-5, 5);
}
void noisy(Film& f, Random&) {
  f.noise = 0.2;
}
void coloured(Film& f, Random&) {
  f.coloured = 0.08;
}
void one_ring(Film& f, Random& r) {
  f.ring = r.uniform(0.4, 1.5);
}
void two_rings(Film& f, Random& r) {
  f.ring = r.uniform(0.4, 1.5), f.rings = 2;
}
void bursts(Film& f, Random& r) {
  f.bursts = r.uniform(0.3, 1.5);
}
void short_pretrigger(Film& f, Random&) {
  f.hum = 0.4, f.pretrigger = 36.8e-3;
}
void cut(Film& f, Random&) {
  f.after = 16e-3;
}
void fast(Film& f, Random&) {
  f.rate = 1e6, f.after = 35e-3;
}
void slow(Film& f, Random&) {
  f.rate = 100e3;
}
void wrong_corner(Film& f, Random&) {
  f.corner = 5;
}
void quiet(Film&, Random&) {}
void everything(Film& f, Random& r) {
  hum_jump(f, r), drifting(f, r), two_rings(f, r), bursts(f, r);
}

/// Record from t = 0 on, the contact 52 ms later.
Scene no_pretrigger(std::uint64_t seed) {
  Random r(seed * 9377 + 3);
  Impact i = draw(Pad::hunt_crossley, r.uniform(0.05, 0.3), r);
  i.first_touch = 52e-3;
  Film film;
  film.pretrigger = 0, film.after = 110e-3, film.hum = 0.4;
  return scene_of(film, &i, r, 0);
}

}  // namespace

const std::vector<SceneClass>& scene_classes() {
  static const std::vector<SceneClass> all{
      {"spring, no loss", true, family<Pad::spring, 0>},
      {"Hertz, no loss", true, family<Pad::hertz, 0>},
      {"Hunt-Crossley 0.15", true, family<Pad::hunt_crossley, 15>},
      {"Hunt-Crossley 0.3", true, family<Pad::hunt_crossley, 30>},
      {"Hunt-Crossley 0.5", true, family<Pad::hunt_crossley, 50>},
      {"damped, sticking 0.05", true, family<Pad::damped, 5>},
      {"damped, sticking 0.15", true, family<Pad::damped, 15>},
      {"yielding 0.2", true, family<Pad::yielding, 20>},
      {"yielding 0.4", true, family<Pad::yielding, 40>},
      {"1 MS/s", true, disturbed<fast>},
      {"100 kS/s", true, disturbed<slow>},
      {"noise 0.2 N", true, disturbed<noisy>},
      {"coloured noise", true, disturbed<coloured>},
      {"amplifier corner 5 Hz", true, disturbed<wrong_corner>},
      {"hum 0.4 N", true, disturbed<hum_04>},
      {"hum jumps at switch-on", true, disturbed<hum_jump>},
      {"drift", true, disturbed<drifting>},
      {"one ring", true, disturbed<one_ring>},
      {"two rings", true, disturbed<two_rings>},
      {"EMI bursts", true, disturbed<bursts>},
      {"pre-trigger 1.84 periods", true, disturbed<short_pretrigger>},
      {"no pre-trigger", true, no_pretrigger},
      {"cut at 16 ms", true, disturbed<cut>},
      {"all at once", true, disturbed<everything>},
      {"nothing: noise", false, nothing<quiet>},
      {"nothing: hum", false, nothing<hum_04>},
      {"nothing: hum jumps", false, nothing<hum_jump>},
      {"nothing: drift", false, nothing<drifting>},
      {"nothing: coloured noise", false, nothing<coloured>},
      {"nothing: EMI bursts", false, nothing<bursts>},
      {"nothing: one ring", false, nothing<one_ring>},
      {"nothing: two rings", false, nothing<two_rings>},
  };
  return all;
}

}  // namespace powbench::bench
