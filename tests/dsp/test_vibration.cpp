#include "dsp/events/vibration.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/events/extract.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

Signal make(std::size_t n, double rate, double t0, auto&& f) {
  Signal s;
  s.dt = 1 / rate;
  s.t0 = t0;
  s.masked.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) s.value.push_back(f(s.time(i)));
  return s;
}

Ring one_mode(double hertz, double decay) {
  Ring r;
  r.modes.push_back({{hertz, decay}, 1.0, 0.0});
  return r;
}

double ring(double t, double hertz, double decay, double phase) {
  return t > 0 ? std::exp(-decay * t) * std::sin(2 * pi * hertz * t + phase) : 0.0;
}

/// A closing with a contact from 12 ms, the core's impact at 14 ms, ringing on film A, and an accelerometer on `aux`.
struct Bench {
  Record record;
  Events events;
};
Bench closing(std::uint64_t seed, bool reference_moves) {
  bench::Random random(seed);
  const double phase = 2 * pi * random.uniform(), impact = 14e-3;
  Bench b;
  b.record.sample_rate = 200e3;
  b.record.fire_sample = 9000;
  b.record.conditions.hold_time = 0.05;
  ChannelRecord film, aux;
  film.channel = Channel::pvdf_a;
  aux.channel = Channel::aux;
  film.scale = aux.scale = 1e-3;
  const double touch = 12e-3 + 1e-3 * random.uniform();
  for (std::size_t i = 0; i < 19000; ++i) {
    const double t = b.record.time(i), r = ring(t - impact, 5e3, 900, phase);
    const double force = t > touch ? 4 * (1 - std::exp(-(t - touch) / 0.5e-3)) : 0.0;
    const auto count = [&](double v) { return static_cast<std::int16_t>(std::lround(1e3 * v)); };
    film.raw.push_back(count(force + 1.5 * r + 0.02 * random.normal()));
    aux.raw.push_back(count((reference_moves ? 2 * ring(t - impact, 5e3, 900, phase + 0.6) : 0.0) +
                            0.02 * random.normal()));
  }
  b.record.channels = {film, aux};
  b.events.core.present = true;
  b.events.core.seat = {impact, 1e-6};
  return b;
}

double rms(const Signal& s, double from, double to) {
  double sum = 0, n = 0;
  for (std::size_t i = s.index_at(from); i < s.index_at(to); ++i) sum += s.value[i] * s.value[i], n += 1;
  return std::sqrt(sum / n);
}

}  // namespace

TEST_CASE("a mode far above the contact band leaves -20 dB or less there, one inside leaves all") {
  BandQuestion q;  // 1 ms: the contact band ends at 1.5 kHz
  const BandReport far = bands_of_ring(one_mode(8e3, 200), q);
  CHECK_FALSE(far.overlaps);
  // a resonance of half width decay / 2 pi has atan-shaped energy below an edge
  const double half = 200 / (2 * pi), share = 0.5 + std::atan((1.5e3 - 8e3) / half) / pi;
  CHECK(far.ring_in_contact_db == Approx(10 * std::log10(share)).margin(1e-9));
  CHECK(far.core.front().low == Approx(8e3 - half));
  CHECK_NOTHROW(plain_filter(far, 200e3));
  const BandReport inside = bands_of_ring(one_mode(1e3, 200), q);
  CHECK(inside.overlaps);
  CHECK(inside.ring_in_contact_db > -0.3);
  CHECK_THROWS_AS(plain_filter(inside, 200e3), BandOverlapError);
  CHECK_FALSE(bands_of_ring({}, q).overlaps);
  CHECK(std::isinf(bands_of_ring({}, q).ring_in_contact_db));
  q.pulse_width = 0;
  CHECK_THROWS_AS(bands_of_ring({}, q), std::invalid_argument);
}

TEST_CASE("the band comes out of the coherence over closings, its phase being different in each") {
  std::vector<Closing> closings;
  for (std::uint64_t k = 0; k < 12; ++k) {
    const Bench b = closing(k + 1, true);
    auto c = closing_of(b.record, Channel::pvdf_a, b.events, {});
    REQUIRE(c);
    closings.push_back(std::move(*c));
  }
  CHECK_FALSE(bands_of_closings(std::span(closings).first(2), {}));
  const auto bands = bands_of_closings(closings, {});
  REQUIRE(bands);
  CHECK(bands->closings == 12);
  bool found = false;
  for (const Band& band : bands->core) found = found || (band.low < 5e3 && band.high > 5e3);
  CHECK(found);
  CHECK_FALSE(bands->overlaps);
}

TEST_CASE("a reference that moves with the core takes its ringing off; a silent one is not used") {
  const Bench b = closing(3, true);
  const FilmVibration v = film_vibration(b.record, Channel::pvdf_a, b.events, {});
  REQUIRE(v.present);
  CHECK(v.reference == "aux");
  REQUIRE(v.cancelled);
  CHECK_FALSE(v.cancelled->refused);
  // what is left of the fast part between impact and two milliseconds later
  const auto fast = [](const Signal& s) {
    Signal d = s;
    for (std::size_t i = 4; i < s.size(); ++i) d.value[i] = s.value[i] - s.value[i - 4];
    return rms(d, 14.1e-3, 16e-3);
  };
  CHECK(fast(v.cancelled->force) < 0.2 * fast(v.force));
  const Bench quiet = closing(3, false);
  CHECK_FALSE(film_vibration(quiet.record, Channel::pvdf_a, quiet.events, {}).cancelled);
  CHECK_FALSE(closing_of(quiet.record, Channel::pvdf_a, quiet.events, {}));
  CHECK_FALSE(film_vibration(b.record, Channel::pvdf_b, b.events, {}).present);
}

TEST_CASE("a record too short for the reference's high-pass refuses it and keeps the film's force") {
  Bench b = closing(3, true);
  constexpr std::size_t from = 11'720, count = 200;  // 1 ms from 13.6 ms on
  for (ChannelRecord& c : b.record.channels)
    c.raw = std::vector<std::int16_t>(c.raw.begin() + from, c.raw.begin() + from + count);
  b.record.fire_sample -= static_cast<std::int64_t>(from);
  const FilmVibration v = film_vibration(b.record, Channel::pvdf_a, b.events, {});
  REQUIRE(v.present);
  REQUIRE(v.cancelled);
  CHECK(v.cancelled->refused);
  CHECK_FALSE(v.cancelled->reason.empty());
  CHECK(v.cancelled->taps.empty());
  CHECK(v.cancelled->force.value == v.force.value);
}

TEST_CASE("without a seat and without vibration the first touch stands for the impact") {
  Bench b = closing(3, false);
  for (std::size_t i = 0; i < b.record.samples(); ++i) {  // the film without its ring
    const double t = b.record.time(i);
    b.record.channels[0].raw[i] =
        static_cast<std::int16_t>(t > 12e-3 ? std::lround(4e3 * (1 - std::exp(-(t - 12e-3) / 0.5e-3))) : 0);
  }
  Events e;
  e.pvdf_a.present = true;
  Contact c;
  c.touch = {12e-3, 1e-6};
  e.pvdf_a.contacts = {c};
  const FilmVibration v = film_vibration(b.record, Channel::pvdf_a, e, {});
  REQUIRE(v.present);
  REQUIRE(v.ring.empty());
  CHECK(v.impact == 12e-3);
}

TEST_CASE("another axis: straight lines stay straight, the outside is marked") {
  const Signal s = make(100, 1e3, 0.0, [](double t) { return 3 * t + 1; });
  const Signal axis = make(500, 4.1e3, -0.01, [](double) { return 0.0; });
  const Signal out = on_axis_of(s, axis);
  REQUIRE(out.size() == axis.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double t = out.time(i);
    if (t < 0 || t > 0.099)
      CHECK(out.masked[i] == mask_edge);
    else
      CHECK(out.value[i] == Approx(3 * t + 1).margin(1e-12));
  }
  CHECK(on_axis_of({}, axis).empty());
}

TEST_CASE("a spectrogram shows a sine where and when it sounds, with its power") {
  const Signal s =
      make(4000, 100e3, 0.0, [](double t) { return t > 0.02 ? 2 * std::sin(2 * pi * 7e3 * t) : 0.0; });
  const Spectrogram g = spectrogram(s, 0.005, 0.035, 2e-3, 31);
  REQUIRE(g.density.size() == g.frames * g.bins);
  const auto power = [&](std::size_t frame) {
    double sum = 0;
    for (std::size_t b = 0; b < g.bins; ++b) sum += g.density[frame * g.bins + b] * g.bin_hertz;
    return sum;
  };
  CHECK(power(5) == Approx(0).margin(1e-20));
  CHECK(power(28) == Approx(2.0).epsilon(0.01));  // mean square of an amplitude of 2
  std::size_t loudest = 0;
  for (std::size_t b = 0; b < g.bins; ++b)
    if (g.density[28 * g.bins + b] > g.density[28 * g.bins + loudest]) loudest = b;
  CHECK(static_cast<double>(loudest) * g.bin_hertz == Approx(7e3).margin(g.bin_hertz));
  CHECK_THROWS_AS(spectrogram({}, 0, 1, 1e-3, 10), std::invalid_argument);
  CHECK_THROWS_AS(spectrogram(s, 1, 0, 1e-3, 10), std::invalid_argument);
  CHECK_THROWS_AS(spectrogram(s, 0, 1, 1e-6, 10), std::invalid_argument);
}
