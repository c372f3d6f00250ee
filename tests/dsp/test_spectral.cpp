#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/bands.h"
#include "dsp/canceller.h"
#include "dsp/cascade.h"
#include "dsp/fir.h"
#include "dsp/pair_convolver.h"
#include "dsp/sos.h"
#include "dsp/spectrum.h"

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

TEST_CASE("windowed-sinc taps agree with the reference to 1e-12") {
  // scipy 1.10.1, signal.firwin(31, ..., fs=100e3)
  const auto band = design_fir(FilterKind::band, 5e3, 20e3, 100e3, 31);
  CHECK(std::abs(band[0] - 0.0016928187235203055) < 1e-12);
  CHECK(std::abs(band[5]) < 1e-12);
  CHECK(std::abs(band[15] - 0.2991457611939736) < 1e-12);
  CHECK(std::abs(design_fir(FilterKind::high, 10e3, 0, 100e3, 31)[15] - 0.8004097073279481) < 1e-12);
  CHECK(std::abs(design_fir(FilterKind::low, 0, 10e3, 100e3, 31)[15] - 0.1996606672986955) < 1e-12);
  const auto stop = design_fir(FilterKind::stop, 5e3, 20e3, 100e3, 31);
  CHECK(std::abs(stop[0] - -0.0017293767498742464) < 1e-12);
  CHECK(std::abs(stop[15] - 0.7130808946660815) < 1e-12);
  CHECK_THROWS_AS(design_fir(FilterKind::band, 5e3, 20e3, 100e3, 30), FilterDesignError);
  CHECK_THROWS_AS(design_fir(FilterKind::band, 20e3, 5e3, 100e3, 31), FilterDesignError);
  CHECK_THROWS_AS(design_fir(FilterKind::low, 0, std::nan(""), 100e3, 31), FilterDesignError);
}

TEST_CASE("two blocks in one transform are two circular convolutions") {
  if (!PairConvolver::available()) return;
  for (std::size_t n = 256; n <= 65536; n *= 2) {  // every mixture of radices
    const std::size_t taps = n == 256 ? 256 : 101;
    const auto h = noise(taps, 3), a = noise(n, 4), b = noise(n, 5);  // not symmetric
    PairConvolver pair(n, h);
    for (const std::size_t skip : {std::size_t{0}, taps - 1, n / 2 + 3}) {
      std::vector<double> ya(n - skip), yb(n - skip);
      pair.run(a.data(), b.data(), ya.data(), yb.data(), skip);
      double worst = 0;
      for (std::size_t j = skip; j < n; j += 1 + n / 97) {
        double sa = 0, sb = 0;
        for (std::size_t k = 0; k < taps; ++k) {
          sa += h[k] * a[(j + n - k) % n];
          sb += h[k] * b[(j + n - k) % n];
        }
        worst = std::max({worst, std::abs(sa - ya[j - skip]), std::abs(sb - yb[j - skip])});
      }
      CHECK(worst < 1e-12);
    }
  }
  CHECK_THROWS_AS(PairConvolver(300, noise(3, 1)), std::invalid_argument);
  CHECK_THROWS_AS(PairConvolver(128, noise(3, 1)), std::invalid_argument);
  CHECK_THROWS_AS(PairConvolver(256, noise(257, 1)), std::invalid_argument);
}

TEST_CASE("overlap-save is the direct convolution, for every length of record") {
  for (const std::size_t taps : {3, 63, 501}) {
    OverlapSave filter(design_fir(FilterKind::band, 2e3, 9e3, 100e3, taps));
    const auto h = design_fir(FilterKind::band, 2e3, 9e3, 100e3, taps);
    for (const std::size_t n : {1UL, 2UL, taps, filter.block(), 3 * filter.block() + 17}) {
      const auto x = noise(n, n);
      std::vector<double> y(n);
      filter.run(x, y);
      double worst = 0;
      for (std::size_t i = 0; i<n; i += n> 3000 ? 37 : 1) {
        double sum = 0;
        for (std::size_t k = 0; k < taps; ++k) {
          const auto j = static_cast<std::ptrdiff_t>(i + filter.edge()) - static_cast<std::ptrdiff_t>(k);
          if (j >= 0 && j < static_cast<std::ptrdiff_t>(n)) sum += h[k] * x[static_cast<std::size_t>(j)];
        }
        worst = std::max(worst, std::abs(sum - y[i]));
      }
      CHECK(worst < 1e-13);
    }
    Signal s = signal(noise(taps + 5, 1), 100e3);
    const Signal y = filter_linear_phase(filter, s);
    CHECK(y.masked[filter.edge() - 1] == mask_edge);
    CHECK(y.masked[filter.edge()] == mask_none);
    CHECK(y.masked.back() == mask_edge);
    CHECK_THROWS_AS(filter_linear_phase(filter, signal(noise(taps, 1), 100e3)), FilterMemoryError);
  }
  CHECK_THROWS_AS(OverlapSave({1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(OverlapSave({1.0, std::nan(""), 1.0}), std::invalid_argument);
}

TEST_CASE("the filter in the spectrum is the forward-backward cascade inside the edges") {
  const Cascade c(FilterSpec{FilterKind::low, 4, 0, 8e3, 100e3});
  const std::size_t n = 10007, padding = 2 * c.warm_up();
  auto x = noise(n, 3), y = x;
  SpectralFilter filter(n, padding, two_pass_gain(c.sections(), good_length(n + padding)));
  filter.run(x);
  c.zero_phase(y);
  double worst = 0;
  for (std::size_t i = c.warm_up(); i + c.warm_up() < n; ++i) worst = std::max(worst, std::abs(x[i] - y[i]));
  CHECK(worst < 1e-13);
  std::vector<double> other(n - 1);
  CHECK_THROWS_AS(filter.run(other), std::invalid_argument);
}

TEST_CASE("the filter in rows and columns is the one in a single transform") {
  for (const std::size_t n :
       {std::size_t{131072}, std::size_t{163840}, std::size_t{3} << 16, std::size_t{1} << 18}) {
    CAPTURE(n);
    REQUIRE(LargeSpectralGain::serves(n));
    std::vector<double> gain = noise(n / 2 + 1, 8);
    const auto x = noise(n, n);
    LargeSpectralGain large(n, gain, FftEffort::quick);
    std::copy(x.begin(), x.end(), large.time().begin());
    large.run();
    RealFft fft(n);
    std::copy(x.begin(), x.end(), fft.time().begin());
    fft.forward();
    for (std::size_t k = 0; k <= n / 2; ++k) fft.spectrum()[k] *= gain[k] / static_cast<double>(n);
    fft.inverse();
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) worst = std::max(worst, std::abs(large.time()[i] - fft.time()[i]));
    CHECK(worst < 1e-13);
  }
  CHECK_FALSE(LargeSpectralGain::serves(100'000));
}

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
}

TEST_CASE("wisdom can be handed over as text, and nonsense is refused") {
  RealFft fft(1000, FftEffort::thorough);
  const std::string wisdom = fft_wisdom();
  CHECK(use_fft_wisdom(wisdom));
  CHECK_FALSE(use_fft_wisdom("(not wisdom"));
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
