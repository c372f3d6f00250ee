// The same specimen by two programs: the first plant and the rigid rung share neither equations of motion in code, nor
// states, nor integrator; what they share is the lumped circuit, the supply and the law of friction. Where both are
// right they agree to their tolerances.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "sim/models/rigid_closing.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

double worst_event(const Trajectory& a, const Trajectory& b) {
  REQUIRE(a.events.size() >= 5);
  std::size_t i = 0;
  double worst = 0;
  std::size_t matched = 0;
  for (const auto& e : b.events) {
    if (e.kind == PlantEvent::Kind::stall || e.kind == PlantEvent::Kind::coil_open) continue;
    // events at one instant may be listed in another order
    double nearest = 1;
    for (const auto& f : a.events)
      if (f.kind == e.kind) nearest = std::min(nearest, std::fabs(f.time - e.time));
    worst = std::max(worst, nearest);
    ++matched;
    ++i;
  }
  CHECK(a.events.size() == matched);
  return worst;
}

}  // namespace

TEST_CASE("first plant and rigid rung agree on every event of the reference specimen", "[mechanics]") {
  for (const int angle : {30, 60, 90, 120, 150, 180}) {
    Conditions c;
    c.closing_angle = radians(angle);
    const auto first = simulate({}, c, 0.06, 0, 1e-11);
    const auto rigid = simulate_rigid({}, c, 0.06, 0, 1e-10);
    const double worst = worst_event(rigid, first);
    std::printf("  %3d deg: %zu events, largest difference %.1e s, rigid residual %.1e\n", angle,
                rigid.events.size(), worst, rigid.energy_residual);
    CHECK(worst < 1e-8);
    CHECK(rigid.energy_residual < 1e-6);
  }
}

TEST_CASE("an opening shorter than a step is not stepped over, whatever the tolerance", "[mechanics]") {
  // at 90 degrees the pads leave for 15 us, 0.2 ms after their last long opening, pressed again before the step ends
  Conditions c;
  c.closing_angle = radians(90);
  const auto first = simulate({}, c, 0.06, 0, 1e-11);
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    const auto rigid = simulate_rigid({}, c, 0.06, 0, tolerance);
    std::printf("  tolerance %.0e: last touch %.1e s off\n", tolerance,
                std::fabs(*rigid.truth.settled - *first.truth.settled));
    CHECK(rigid.truth.openings.size() == first.truth.openings.size());
    CHECK(std::fabs(*rigid.truth.settled - *first.truth.settled) < 1e-4 * std::sqrt(tolerance));
  }
}

TEST_CASE("both models agree on tilted bridges of different gaps, and on the samples", "[mechanics]") {
  Specimen s;
  s.bridges.tilt_gap = 0.05e-3;
  s.bridges.gap_spread = 0.03e-3;
  Conditions c;
  c.closing_angle = radians(72.0);
  const auto first = simulate(s, c, 0.05, 1e-3, 1e-11);
  const auto rigid = simulate_rigid(s, c, 0.05, 1e-3, 1e-10);
  const double worst = worst_event(rigid, first);
  std::printf("  tilted: %zu events, largest difference %.1e s\n", rigid.events.size(), worst);
  CHECK(worst < 1e-7);
  REQUIRE(rigid.samples.size() == first.samples.size());
  for (std::size_t k = 0; k < first.samples.size(); ++k) {
    const auto& a = first.samples[k];
    const auto& b = rigid.samples[k];
    CHECK(b.travel == Approx(a.travel).margin(1e-10));
    CHECK(b.coil_current == Approx(a.coil_current).margin(1e-8));
    CHECK(b.coil_voltage == Approx(a.coil_voltage).margin(1e-4));
    CHECK(b.flux_linkage == Approx(a.flux_linkage).margin(1e-9));
    CHECK(b.pull == Approx(a.pull).margin(1e-5));
    CHECK(b.force_a == Approx(a.force_a).margin(1e-3));
    CHECK(b.core_force == Approx(a.core_force).margin(1e-3));
  }
}

TEST_CASE("both models agree where the static core floats on buffer springs in its housing", "[mechanics]") {
  Specimen s;
  s.base.core_mass = 0.18;
  s.base.core_hertz = 250;
  Conditions c;
  c.closing_angle = radians(60.0);
  const auto first = simulate(s, c, 0.05, 1e-3, 1e-11);
  const auto rigid = simulate_rigid(s, c, 0.05, 1e-3, 1e-10);
  const double worst = worst_event(rigid, first);
  std::printf("  floating static core: %zu events, largest difference %.1e s, residual %.1e\n",
              rigid.events.size(), worst, rigid.energy_residual);
  CHECK(worst < 1e-7);
  CHECK(rigid.energy_residual < 1e-7);
  for (std::size_t k = 0; k < first.samples.size(); ++k) {
    CHECK(rigid.samples[k].base == Approx(first.samples[k].base).margin(1e-10));
    CHECK(rigid.samples[k].base_acceleration == Approx(first.samples[k].base_acceleration).margin(1e-2));
  }
  // it is another machine than with one mass
  CHECK(std::fabs(*first.truth.settled - *simulate({}, c, 0.05, 0, 1e-9).truth.settled) > 1e-5);
}

TEST_CASE("both models open again after the coil was switched off", "[mechanics]") {
  Conditions c;
  c.closing_angle = radians(90.0);
  c.hold_time = 0.08;
  const auto first = simulate({}, c, 0.12, 0, 1e-11);
  const auto rigid = simulate_rigid({}, c, 0.12, 0, 1e-10);
  REQUIRE(first.truth.opened);
  REQUIRE(rigid.truth.opened);
  CHECK(*rigid.truth.opened == Approx(*first.truth.opened).margin(1e-7));
}
