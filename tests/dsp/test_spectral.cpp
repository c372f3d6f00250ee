#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/filter/bands.h"
#include "dsp/filter/canceller.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/sos.h"
#include "dsp/signal/spectrum.h"
#include "dsp/signal/statistics.h"

using namespace powbench;
using namespace powbench::dsp;
using bench::Random;

namespace {

std::vector<double> noise(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> x(n);
  for (double& v : x) v = random.normal();
  return x;
}

Signal signal(std::vector<double> value, double rate) {
  Signal s;
  s.dt = 1 / rate;
  s.masked.assign(value.size(), mask_none);
  s.value = std::move(value);
  return s;
}

/// Damped modes from sample `from` on.
void add_ring(std::vector<double>& x, double rate, std::size_t from, std::vector<double> hertz,
              double amplitude, Random& random) {
  for (const double f : hertz) {
    const double phase = random.uniform(0, 2 * pi), a = amplitude * random.uniform(0.7, 1.3);
    for (std::size_t i = from; i < x.size(); ++i) {
      const double t = static_cast<double>(i - from) / rate;
      x[i] += a * std::exp(-0.015 * 2 * pi * f * t) * std::sin(2 * pi * f * t + phase);
    }
  }
}

double rms(std::span<const double> x) {
  double s = 0;
  for (const double v : x) s += v * v;
  return std::sqrt(s / static_cast<double>(x.size()));
}

}  // namespace

TEST_CASE("good lengths are even, have only the factors 2, 3, 5, and none is skipped") {
  const auto smooth = [](std::size_t n) {
    for (const std::size_t p : {2, 3, 5})
      while (n % p == 0) n /= p;
    return n == 1;
  };
  for (std::size_t n = 1; n < 3000; ++n) {
    std::size_t expected = n + n % 2;
    while (!smooth(expected)) expected += 2;
    CHECK(good_length(n) == expected);
  }
  CHECK(good_length(1'000'003) <= 1'012'500);
  CHECK_THROWS_AS(RealFft(0), std::invalid_argument);
}

TEST_CASE("Welch density and coherence agree with the reference to 1e-12") {
  // scipy 1.10.1, signal.welch and coherence(x, y, 1e4, nperseg=128)
  std::vector<double> x(1000), y(1000);
  for (std::size_t i = 0; i < 1000; ++i) {
    const double n = static_cast<double>(i);
    x[i] = std::sin(0.3 * n) + 0.2 * std::cos(0.011 * n * n / 7);
    y[i] = std::cos(0.3 * n + 1) + 0.3 * std::sin(0.02 * n * n / 5);
  }
  SpectrumEstimator e(128, 1e4);
  const Spectrum p = e.welch(x);
  CHECK(p.density[0] == Approx(2.3577934810148846e-06).epsilon(1e-10));
  CHECK(p.density[1] == Approx(1.4012059161974043e-06).epsilon(1e-10));
  CHECK(p.density[6] == Approx(0.004269451468381242).epsilon(1e-12));
  CHECK(p.density[40] == Approx(4.575597960563181e-06).epsilon(1e-12));
  CHECK(p.density[64] == Approx(6.502601663918596e-10).epsilon(1e-9));
  const Coherence c = e.coherence(x, y);
  CHECK(std::abs(c.value[1] - 0.06866522723675919) < 1e-12);
  CHECK(std::abs(c.value[6] - 0.9967261232675085) < 1e-12);
  CHECK(std::abs(c.value[40] - 0.008276551663288403) < 1e-12);
  CHECK(c.x.density[6] == Approx(p.density[6]).epsilon(1e-14));
  CHECK(c.averages == 14);
  CHECK_THROWS_AS(e.welch(std::vector<double>(127)), std::invalid_argument);
  x[500] = std::nan("");
  CHECK_THROWS_AS(e.welch(x), std::invalid_argument);
  CHECK_THROWS_AS(SpectrumEstimator(7, 1e4), std::invalid_argument);
  CHECK_THROWS_AS(SpectrumEstimator(64, std::nan("")), std::invalid_argument);
}

TEST_CASE("the coherence threshold is passed by chance as often as it says") {
  const std::size_t closings = 8, n = 256;
  SpectrumEstimator e(n, 1e5);
  std::size_t above = 0, bins = 0;
  for (std::uint64_t trial = 0; trial < 120; ++trial) {
    std::vector<std::vector<double>> a, b;
    for (std::uint64_t k = 0; k < closings; ++k) {
      a.push_back(noise(n, 1000 + 97 * trial + k));
      b.push_back(noise(n, 500'000 + 89 * trial + k));
    }
    const std::vector<std::span<const double>> x(a.begin(), a.end()), y(b.begin(), b.end());
    const Coherence c = e.shot_coherence(x, y);
    for (std::size_t k = 2; k < n / 2; ++k, ++bins) above += c.value[k] > coherence_threshold(closings, 0.01);
  }
  const double share = static_cast<double>(above) / static_cast<double>(bins);
  CHECK(share > 0.006);
  CHECK(share < 0.014);
  CHECK(coherence_threshold(2, 0.01) == Approx(0.99));
  CHECK_THROWS_AS(coherence_threshold(1, 0.01), std::invalid_argument);
}

namespace {

struct Closings {
  std::vector<std::vector<double>> reference, force;
};

/// Core ringing seen by the reference and, through a fixed path, by the force; contact pulses of their own.
Closings closings(std::size_t count, std::vector<double> hertz, double rate, std::size_t n) {
  Closings out;
  for (std::size_t k = 0; k < count; ++k) {
    Random random(77 + k);
    std::vector<double> r(n, 0.0), f(n, 0.0);
    add_ring(r, rate, 0, hertz, 2.0, random);
    for (std::size_t i = 4; i < n; ++i) f[i] = 0.8 * r[i] - 0.4 * r[i - 4];
    const double start = random.uniform(0, 3e-3), width = random.uniform(0.8e-3, 1.5e-3);
    for (std::size_t i = 0; i < n; ++i) {
      const double u = (static_cast<double>(i) / rate - start) / width;
      if (u > 0 && u < 1) f[i] += 5 * std::sin(pi * u);
      f[i] += 0.05 * random.normal();
      r[i] += 0.05 * random.normal();
    }
    out.reference.push_back(std::move(r));
    out.force.push_back(std::move(f));
  }
  return out;
}

BandReport bands(std::vector<double> hertz, std::size_t count) {
  const Closings data = closings(count, std::move(hertz), 200e3, 2048);
  SpectrumEstimator e(2048, 200e3);
  const std::vector<std::span<const double>> x(data.reference.begin(), data.reference.end()),
      y(data.force.begin(), data.force.end());
  return find_bands(e.shot_coherence(x, y));
}

bool covered(const BandReport& r, double hertz) {
  return std::any_of(r.core.begin(), r.core.end(),
                     [&](const Band& b) { return b.low <= hertz && hertz <= b.high; });
}

}  // namespace

TEST_CASE("the band finder finds the core's modes, and allows a plain filter only where they stay apart") {
  const BandReport apart = bands({9e3, 15e3}, 20);
  CHECK(covered(apart, 9e3));
  CHECK(covered(apart, 15e3));
  CHECK_FALSE(covered(apart, 40e3));
  CHECK_FALSE(covered(apart, 70e3));
  CHECK(apart.contact.high == Approx(1500));
  CHECK(apart.ring_in_contact_db < -20);
  CHECK_FALSE(apart.overlaps);
  CHECK(plain_filter(apart, 200e3).high_hertz == Approx(1500));
  CHECK(to_sections(plain_filter(apart, 200e3)).size() == 3);

  const BandReport together = bands({1.2e3, 15e3}, 20);
  CHECK(covered(together, 1.2e3));
  CHECK(together.ring_in_contact_db > -10);
  CHECK(together.overlaps);
  CHECK_THROWS_AS(plain_filter(together, 200e3), BandOverlapError);
  CHECK_THROWS_WITH(plain_filter(together, 200e3), Catch::Contains("dB") && Catch::Contains("1500 Hz"));

  Coherence silent;
  silent.averages = 20;
  silent.bin_hertz = 100;
  silent.value.assign(100, 0.0);
  silent.x.density = silent.y.density = silent.value;
  const BandReport none = find_bands(silent);
  CHECK(none.core.empty());
  CHECK(std::isinf(none.ring_in_contact_db));
  CHECK_FALSE(none.overlaps);
  CHECK_THROWS_AS(find_bands(silent, {0.0}), std::invalid_argument);
}

TEST_CASE("energy of a half sine: 99 % below 1.18 / T, 99.5 % below 1.5 / T") {
  CHECK(half_sine_energy_below(1180, 1e-3) == Approx(0.990).margin(2e-4));
  CHECK(half_sine_energy_below(1500, 1e-3) == Approx(0.99495).margin(2e-4));
  CHECK(half_sine_energy_below(0, 1e-3) == 0);
}

namespace {

struct Cancelling {
  Signal force, reference;
  std::vector<double> ring;
};

/// 20 ms at 1 MS/s: a 10 N pulse, and 2 N of ringing from 5 ms on, seen by a reference through another path.
Cancelling ringing(double hertz, double reference_noise, std::uint64_t seed) {
  const double rate = 1e6;
  Random random(seed);
  std::vector<double> source(20000, 0.0);
  add_ring(source, rate, 5000, {hertz, 1.13 * hertz, 0.9 * hertz}, 1.2, random);
  Cancelling out;
  out.ring.resize(source.size());
  std::vector<double> r(source.size()), f(source.size());
  for (std::size_t i = 12; i < source.size(); ++i) {
    out.ring[i] = 0.9 * source[i - 6] + 0.3 * source[i - 12];
    r[i] = source[i] + reference_noise * random.normal();
    const double u = (static_cast<double>(i) - 6000) / 1000;
    f[i] = out.ring[i] + (u > 0 && u < 1 ? 10 * std::sin(pi * u) : 0.0) + 0.1 * random.normal();
  }
  out.force = signal(std::move(f), rate);
  out.reference = signal(std::move(r), rate);
  return out;
}

}  // namespace

TEST_CASE("the canceller takes 19 to 25 dB off the ringing, and refuses a reference that explains nothing") {
  CancelOptions o;
  o.from = 5e-3;
  o.to = 15e-3;
  for (const double hertz : {1.5e3, 3e3, 8e3}) {
    const Cancelling c = ringing(hertz, 0.005, 5);
    const Cancelled y = cancel_reference(c.force, c.reference, o);
    REQUIRE_FALSE(y.refused);
    CHECK(y.taps.size() == 64);
    std::vector<double> left, before;
    for (std::size_t i = 5100; i < 14900; ++i) {
      left.push_back(y.force.value[i] - c.force.value[i] + c.ring[i]);  // what is still there of the ring
      before.push_back(c.ring[i]);
    }
    CAPTURE(hertz, 20 * std::log10(rms(left) / rms(before)));
    CHECK(rms(left) < 0.112 * rms(before));  // -19 dB; 1.5 kHz is worst: the pulse itself has power there
    CHECK(y.explained > 0.3);
    CHECK(y.force.value[4000] == c.force.value[4000]);  // outside the window nothing changes
  }
  const Cancelling c = ringing(3e3, 0.005, 5);
  const Signal unrelated = signal(noise(20000, 99), 1e6);
  const Cancelled y = cancel_reference(c.force, unrelated, o);
  CHECK(y.refused);
  CHECK(y.explained < 0.3);
  CHECK(y.force.value == c.force.value);
  CHECK(cancel_reference(c.force, signal(std::vector<double>(20000, 1.0), 1e6), o).refused);
  CancelOptions narrow = o;
  narrow.to = o.from + 1e-4;
  CHECK(cancel_reference(c.force, c.reference, narrow).refused);
  CancelOptions outside = o;
  outside.to = 1;
  CHECK_THROWS_AS(cancel_reference(c.force, c.reference, outside), std::invalid_argument);
  CHECK_THROWS_AS(cancel_reference(c.force, signal(noise(20000, 1), 2e6), o), std::invalid_argument);
  CHECK_THROWS_AS(cancel_reference(c.force, Signal{}, o), std::invalid_argument);
}

TEST_CASE("median and scatter of any series are those of the sorted one, to the bit", "[spectral]") {
  Random random(91);
  const auto sorted_median = [](std::vector<double> v) {
    std::sort(v.begin(), v.end());
    const std::size_t h = v.size() / 2;
    return v.size() % 2 ? v[h] : 0.5 * (v[h] + v[h - 1]);
  };
  for (std::size_t n : {1u, 2u, 7u, 511u, 512u, 513u, 617u, 4001u, 8008u})
    for (int shape = 0; shape < 6; ++shape) {
      std::vector<double> x(n);
      for (std::size_t i = 0; i < n; ++i) {
        const double t = static_cast<double>(i), drawn = random.normal();
        // noise; few levels; all equal; rising; a period of the sample that the selection takes; two far levels
        x[i] = shape == 0   ? drawn
               : shape == 1 ? std::round(drawn)
               : shape == 2 ? 0.25
               : shape == 3 ? t
               : shape == 4 ? (i * 63 % n < 63 ? 100 + drawn : drawn)
                            : (i < n / 2 ? -1e9 : 1e9) + drawn;
      }
      const double m = sorted_median(x);
      CAPTURE(n, shape);
      CHECK(median(x) == m);
      std::vector<double> from(x);
      for (double& v : from) v = std::abs(v - m);
      CHECK(robust_sigma(x) == 1.4826 * sorted_median(from));
    }
}
