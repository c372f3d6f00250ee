#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/contacts/crest.h"

using namespace powbench;
using namespace powbench::dsp;
using powbench::bench::Random;

namespace {

constexpr double dt = 5e-6, noise = 0.03, sigma = 0.0105;

Signal film_of(const std::function<double(double)>& force, double from, double to) {
  Random random(7);
  Signal s;
  s.dt = dt;
  s.t0 = from;
  for (double t = from; t < to; t += dt) s.value.push_back(force(t) + noise * random.normal());
  s.masked.assign(s.value.size(), 0);
  return s;
}

/// F = 12 N (t / 0.3 ms)^1.5 from `at` on.
double contact(double t, double at) {
  return t > at ? 12 * std::pow((t - at) / 0.3e-3, 1.5) : 0.0;
}

/// From `onset` on: 1.5 N, 3 kHz, damping ratio 1.5 %.
double vibration(double t, double onset) {
  const double w = 2 * pi * 3e3;
  return t > onset ? 1.5 * std::exp(-0.015 * w * (t - onset)) * std::sin(w * (t - onset)) : 0.0;
}

struct Looked {
  EdgeInVibration how;
  Measured edge;
};

/// An edge that was dated to 2 us.
Looked look(const Signal& s, double at_rest, double edge, int side) {
  const CalmForce calm = calm_force(s, noise, {});
  const VibratingFilm film{s, calm, at_rest, 0};
  const EdgeInVibration how = look_at_edge(film, s, calm, {edge, side, 0.5e-3, 2e-3});
  return {how, how.of({edge, 2e-6}, side)};
}

}  // namespace

TEST_CASE("a crest of vibration before a touch is no foot of it", "[crest]") {
  // the touch falls where the vibration comes down: before, the foot seen began with the vibration
  const double touch = 0.19e-3;
  const auto force = [&](double t) { return contact(t, touch) + vibration(t, 0); };
  const Looked in = look(film_of(force, -2e-3, 0.6e-3), 1.5, 2e-6, +1);
  REQUIRE(in.how.passed > 0);
  CHECK(std::abs(in.edge.value - touch) < 0.3 * touch);
  CHECK(std::abs(in.edge.value - touch) < 3 * in.edge.u);

  // the same in time reversed is a release
  const Looked out = look(film_of([&](double t) { return force(-t); }, -0.6e-3, 2e-3), 1.5, -2e-6, -1);
  REQUIRE(out.how.passed > 0);
  CHECK(std::abs(out.edge.value + touch) < 0.3 * touch);
  CHECK(std::abs(out.edge.value + touch) < 3 * out.edge.u);
}

TEST_CASE("an edge that nothing swings beside keeps its time and its certainty", "[crest]") {
  const Signal calm = film_of([](double t) { return contact(t, 0); }, -2e-3, 0.6e-3);
  for (const double at_rest :
       {0.0, 1.5}) {  // the film vibrates elsewhere, and open time before this edge is calm
    const Measured kept = look(calm, at_rest, 2e-6, +1).edge;
    CHECK(kept.value == 2e-6);
    CHECK(kept.u == 2e-6);
  }
}

TEST_CASE("vibration on both sides of zero hides the foot of a touch", "[crest]") {
  // Whatever its phase: the touch lies within three u of where the force was last seen at zero, and nearer to what is
  // made of it on the whole.
  double found = 0, made = 0;
  for (int k = 0; k < 8; ++k) {
    const double onset = -1.0e-3 - k * 42e-6;  // an eighth of a period each
    const Signal s = film_of([&](double t) { return contact(t, 0) + vibration(t, onset); }, -3e-3, 0.6e-3);
    const CalmForce calm = calm_force(s, noise, {});
    std::size_t i = s.index_at(0.25e-3);
    while (calm.value[i] > 3 * sigma) --i;
    const Measured edge = look(s, 0, s.time(i), +1).edge;
    INFO("phase " << k << " found " << s.time(i) << " made " << edge.value << " u " << edge.u);
    CHECK(std::abs(edge.value) < 3 * edge.u);
    // no more than from there to where the contact presses with twice the amplitude
    CHECK(edge.u < (std::abs(s.time(i)) + 0.12e-3) / std::sqrt(3.0));
    found += s.time(i) * s.time(i), made += edge.value * edge.value;
  }
  CHECK(made < 0.7 * found);
}

TEST_CASE("the vibration of a contact at rest is carried back to its touch", "[crest]") {
  const double settled = 4;
  const auto film = [&](bool rings) {
    return film_of(
        [&](double t) {
          return t > 0 ? -settled * std::expm1(-t / 0.3e-3) + (rings ? vibration(t, 0) : 0.0) : 0.0;
        },
        -1e-3, 15e-3);
  };
  const Signal s = film(true);
  const CalmForce calm = calm_force(s, noise, {});
  const double found = vibration_at_rest(calm, s, 0, 15e-3);
  CHECK(found > 0.75);
  CHECK(found < 6.0);  // a sum of modes is no better known: the filter passes 0.9 .. 2 of each
  CHECK(vibration_at_rest(calm, s, 0, 8e-3) == 0);  // not long enough at rest
  const Signal quiet = film(false);
  CHECK(vibration_at_rest(calm_force(quiet, noise, {}), quiet, 0, 15e-3) == 0);
}
