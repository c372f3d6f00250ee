#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/dsp_synth.h"
#include "dsp/contacts/edge_laws.h"
#include "dsp/contacts/one_law.h"

using namespace powbench;
using namespace powbench::dsp;
using powbench::bench::Random;

namespace {

constexpr double dt = 5e-6, noise = 0.03;

/// A touch at `at` of F = peak (t / 0.3 ms)^q, sampled every 5 us.
EdgeAnswer touch_of(double peak, double q, double at, Random& random) {
  Signal s;
  s.dt = dt;
  s.t0 = -0.4e-3;
  for (std::size_t i = 0; i < 200; ++i) {
    const double t = s.time(i) - at;
    s.value.push_back((t > 0 ? peak * std::pow(t / 0.3e-3, q) : 0.0) + noise * random.normal());
  }
  s.masked.assign(200, 0);
  return locate_edge(s, {at + 8e-6, +1, 0.15e-3, 0.25e-3, noise});
}

}  // namespace

TEST_CASE("a faint touch takes the law from the strong ones of its film", "[edge]") {
  // exponent, most of the squared errors and of u that may be left; 1.5 lies amid the laws, so less is gained there
  struct Case {
    double q, squares, u;
  };
  for (const auto& [q, most_squares, most_u] : {Case{1.0, 0.7, 0.9}, Case{1.5, 0.97, 0.95}}) {
    Random random(11);
    double alone = 0, together = 0, squares = 0, u_alone = 0, u_together = 0;
    constexpr int rounds = 60;
    for (int k = 0; k < rounds; ++k) {
      const double at = random.uniform(0, 1e-5);
      EdgeAnswer faint = touch_of(1.5, q, at, random), a = touch_of(40, q, 0, random),
                 b = touch_of(25, q, 2e-6, random);
      alone += std::pow(faint.time.value - at, 2), u_alone += faint.time.u;
      const std::vector<EdgeAnswer*> all{&faint, &a, &b};
      agree_on_law(all);
      together += std::pow(faint.time.value - at, 2), u_together += faint.time.u;
      squares += std::pow((faint.time.value - at) / faint.time.u, 2);
      double weight = 0, mean = 0;
      for (const EdgeLaw& law : faint.law) weight += law.weight, mean += law.weight * law.mean;
      CHECK(weight == Approx(1));
      CHECK(std::abs(mean) < 1e-12);  // counted from the new time
    }
    INFO("q " << q);
    CHECK(together < most_squares * alone);
    CHECK(u_together < most_u * u_alone);
    CHECK(std::sqrt(squares / rounds) < 1.3);
  }
}

TEST_CASE("one edge alone, and edges beside one that no law follows, keep what they had", "[edge]") {
  Random random(12);
  EdgeAnswer a = touch_of(10, 1.5, 0, random), strange = touch_of(40, 1.0, 0, random);
  strange.followed = false;
  const Measured was = a.time;
  const std::vector<EdgeAnswer*> one{&a}, two{&a, &strange};
  agree_on_law(one);
  CHECK(a.time.value == Approx(was.value).margin(1e-12));
  CHECK(a.time.u == Approx(was.u));
  agree_on_law(two);
  CHECK(a.time.value == Approx(was.value).margin(1e-12));
  CHECK(a.time.u == Approx(was.u));
}

TEST_CASE("a clear touch of another law is not talked out of it", "[edge]") {
  Random random(13);
  EdgeAnswer own = touch_of(40, 1.5, 0, random);
  std::vector<EdgeAnswer> others(3);
  for (EdgeAnswer& e : others) e = touch_of(40, 1.0, 0, random);
  std::vector<EdgeAnswer*> all{&own};
  for (EdgeAnswer& e : others) all.push_back(&e);
  agree_on_law(all);
  CHECK(std::abs(own.time.value) < 3 * own.time.u);
}

TEST_CASE("a force that rises steeply behind a jump is less believed of a release than of a touch",
          "[edge]") {
  constexpr double span = 0.25e-3, sigmas = 200;  // largest row over the noise
  EdgeRows rows;
  rows.step = dt, rows.noise = noise, rows.top = sigmas * noise;
  Random random(7);
  for (int i = -40; i < 50; ++i) {
    const double t = (i + 0.5) * dt, x = t / span;
    rows.t.push_back(t);
    rows.y.push_back((t > 0 ? sigmas * (0.3 + 0.7 * x * x * x) : 0.0) + random.normal());
    rows.closed += t > 0;
  }
  const EdgeTotals totals = totals_of(rows);
  const EdgeEvidence touch = evidence_at(rows, totals, 0, span, false, false);
  const EdgeEvidence release = evidence_at(rows, totals, 0, span, true, false);
  CHECK(touch.log > release.log + 5);
}
