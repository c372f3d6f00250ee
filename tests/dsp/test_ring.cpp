#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/vibration/ring.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

struct Scene {
  Signal signal;
  std::vector<std::uint8_t> usable;
};

/// Two modes from t = 1.0005 ms on, amplitude 1, at `rate`; noise sigma.
Scene two_modes(double rate, double noise, double settled) {
  Scene s;
  s.signal.dt = 1 / rate;
  const auto n = static_cast<std::size_t>(0.015 * rate);
  bench::Random random(9);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate, u = t - 1.0005e-3;
    double v = noise * random.normal() + settled * (1 + 0.1 * std::sin(2 * pi * 100 * t));
    if (u > 0)
      v += std::exp(-2 * pi * 1700 * 0.012 * u) * std::cos(2 * pi * 1700 * u) +
           std::exp(-2 * pi * 3100 * 0.015 * u) * std::sin(2 * pi * 3100 * u);
    s.signal.value.push_back(v);
  }
  s.signal.masked.assign(n, 0);
  s.usable.assign(n, 1);
  return s;
}

}  // namespace

TEST_CASE("poles of two damped modes are found in a tail of noise and settled force") {
  for (const double rate : {1e5, 1e6}) {
    const Scene s = two_modes(rate, 0.03, 3.0);
    const RingInput in{s.signal, s.usable, 1.5e-3, 0.0, 13e-3, 0.03};
    auto poles = tail_poles(in, {});
    for (const auto& [hertz, damping] : {std::pair(1700.0, 0.012), std::pair(3100.0, 0.015)}) {
      const bool found = std::any_of(poles.begin(), poles.end(), [&](const Pole& p) {
        return std::abs(p.hertz - hertz) < 10 && std::abs(p.decay / (2 * pi * p.hertz) - damping) < 0.006;
      });
      CHECK(found);
    }
  }
}

TEST_CASE("ring fit recovers poles and amplitudes, and the ring taken out leaves the noise") {
  for (const double rate : {1e5, 1e6}) {
    Scene s = two_modes(rate, 0.02, 0.0);
    const RingInput in{s.signal, s.usable, 1.001e-3, 0.014, 0.014, 0.02};
    const Ring ring = grow_ring(in, {}, {});
    REQUIRE(ring.modes.size() == 2);
    for (const RingMode& m : ring.modes) {
      const bool low = m.pole.hertz < 2400;
      CHECK(m.pole.hertz == Approx(low ? 1700 : 3100).margin(3));
      CHECK(m.pole.decay == Approx(2 * pi * (low ? 1700 * 0.012 : 3100 * 0.015)).epsilon(0.05));
      CHECK(std::hypot(m.cosine, m.sine) == Approx(1.0).epsilon(0.05));
    }
    ring.add_to(s.signal, -1.0);
    double sum = 0;
    for (const double v : s.signal.value) sum += v * v;
    CHECK(std::sqrt(sum / static_cast<double>(s.signal.size())) == Approx(0.02).epsilon(0.15));
  }
}

TEST_CASE("the onset is found to a fraction of a period") {
  const Scene s = two_modes(1e5, 0.02, 0.0);
  Ring ring = grow_ring({s.signal, s.usable, 3e-3, 0.014, 0.014, 0.02}, {}, {});
  REQUIRE(ring.modes.size() == 2);
  CHECK(find_onset(s.signal, &s.usable, ring, 0.0, 6e-3) == Approx(1e-3).margin(60e-6));
}

TEST_CASE("noise alone has no ring") {
  bench::Random random(1);
  Scene s = two_modes(1e5, 0.0, 0.0);
  for (double& v : s.signal.value) v = 0.1 * random.normal();
  const RingInput in{s.signal, s.usable, 0.0, 0.0, 0.014, 0.1};
  CHECK(grow_ring(in, tail_poles(in, {}), {}).empty());
}

TEST_CASE("where no sample is usable there is no ring, and nothing is read") {
  Scene s = two_modes(1e5, 0.03, 3.0);
  std::fill(s.usable.begin(), s.usable.end(), std::uint8_t{0});
  const RingInput in{s.signal, s.usable, 1.001e-3, 2e-3, 0.014, 0.03};
  CHECK(fit_ring(in, {{1700, 130}, {3100, 290}}, {}).empty());
  CHECK(grow_ring(in, {{1700, 130}}, {}).empty());
  CHECK(tail_poles({s.signal, s.usable, 0.02, 0.03, 0.04, 0.03}, {}).empty());
}
