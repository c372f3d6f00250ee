// Hard cases of the rigid contactor itself: laws whose force jumps, tilt, restart in mid-closing, threads.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>

#include "bench/mechanics/reference_closing.h"
#include "tests/sim/mechanics/gap_inductance.h"

namespace {

using namespace powbench::sim;
using Contactor = RigidContactor<double>;
using Solver = EventSolver<Contactor>;

/// A core alone that flies with a constant pull against a static core that does not move.
RigidParts core_alone(const ContactLaw& pole) {
  auto p = powbench::bench::reference_closing();
  p.bridges.clear();
  p.modes.clear();
  p.static_mass = 1e15;
  p.core_damping = 0;
  p.pull = {160, 1e-6, 1, 50, 2e-3};
  p.pole = pole;
  return p;
}

struct Contact {
  double duration = 0, left_with = 0;
};

/// The same contact by a plain integrator of order 4 at a fixed step: d'' = (pull - springs(d) - 2 F(d, d')) / M from
/// d = 0, d' = v0, until F = 0.
Contact plainly(const RigidParts& p, double v0) {
  const auto& law = p.pole;
  const double hysteresis = law.hysteresis(v0);
  const auto force = [&](double d, double v) {
    return d > 0 || law.form == DampingForm::linear ? raw_force(law, std::max(d, 0.0), v, hysteresis) : 0.0;
  };
  const auto slope = [&](double d, double v) {
    const double springs = p.return_preload + p.return_rate * (p.travel + d);
    return (p.pull.peak - springs - 2 * force(d, v)) / p.core_mass;
  };
  const double h = 2e-9;
  double d = 0, v = v0, t = 0;
  for (;;) {
    const double a1 = slope(d, v);
    const double a2 = slope(d + h / 2 * v, v + h / 2 * a1);
    const double a3 = slope(d + h / 2 * v + h * h / 4 * a1, v + h / 2 * a2);
    const double a4 = slope(d + h * v + h * h / 2 * a2, v + h * a3);
    const double next_d = d + h * v + h * h / 6 * (a1 + a2 + a3);
    const double next_v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    const bool ends = next_d <= 0 || force(next_d, next_v) <= 0;
    if (ends && t > 0) {
      const double before = force(d, v);
      const double after = next_d <= 0 ? next_d : force(next_d, next_v);
      const double share = next_d <= 0 ? d / (d - next_d) : before / (before - after);
      return {t + share * h, std::fabs(v + share * (next_v - v))};
    }
    d = next_d;
    v = next_v;
    t += h;
  }
}

}  // namespace

TEST_CASE("every contact law of the rung against a plain integration of the same contact", "[mechanics]") {
  const ContactLaw laws[] = {{1e9, 1.5, DampingForm::none, 0, 0},
                             {1e9, 1.5, DampingForm::hunt_crossley, 0.3, 0},
                             {1e9, 1.5, DampingForm::lankarani_nikravesh, 0.6, 0},
                             {1e9, 1.5, DampingForm::flores, 0.6, 0},
                             {1e9, 1.5, DampingForm::ramped, 400, 4e-5},
                             {1e9, 1.5, DampingForm::linear, 400, 0},
                             {1e7, 1, DampingForm::linear, 400, 0},
                             {1e12, 2, DampingForm::linear, 100, 0}};
  for (const auto& law : laws) {
    const auto parts = core_alone(law);
    RigidOptions o;
    o.tolerance = 1e-11;
    o.end = 0.02;
    const auto run = run_rigid(parts, {}, o);
    REQUIRE(run.completed);
    const auto pole = [](const RigidEvent& e) { return e.contact == core_group * rigid_lanes; };
    const auto touch = std::find_if(run.events.begin(), run.events.end(), pole);
    const auto leave = std::find_if(touch + 1, run.events.end(), pole);
    REQUIRE(leave != run.events.end());
    REQUIRE(touch->closes);
    REQUIRE_FALSE(leave->closes);
    const auto exact = plainly(parts, touch->speed);
    const double dt = (leave->time - touch->time) / exact.duration - 1;
    const double dv = leave->speed / exact.left_with - 1;
    std::printf("  law %d, n %.1f: %.3f us, restitution %.5f, off by %.1e and %.1e\n",
                static_cast<int>(law.form), law.exponent, exact.duration * 1e6,
                exact.left_with / touch->speed, dt, dv);
    CHECK(std::fabs(dt) < 1e-7);
    CHECK(std::fabs(dv) < 1e-7);
  }
}

TEST_CASE("force that jumps at the touch: it ends at F = 0 with a dent, and only once", "[mechanics]") {
  const auto parts = core_alone({1e9, 1.5, DampingForm::linear, 400, 0});
  Contactor c(parts);
  alignas(64) double y[Solver::capacity] = {};
  c.equilibrium(y);
  const auto solver = std::make_unique<Solver>(c, 1e-10, 1e-3);
  solver->restart(0, y, 1e-6);
  const int pole = core_group * rigid_lanes;
  bool pressed = false;
  while (!pressed || c.is_pressing(pole)) {
    REQUIRE(solver->end() < 0.02);
    REQUIRE(solver->extend());
    pressed = pressed || c.is_pressing(pole);
  }
  // the force has just ended: the dent is still there
  const double depth = c.depth_of(pole, solver->end_state());
  CHECK(depth > 1e-6);
  const std::size_t events = c.events().size();
  CHECK_FALSE(c.events().back().closes);
  while (c.depth_of(pole, solver->end_state()) > 0) {
    REQUIRE(solver->end() < 0.02);
    REQUIRE(solver->extend());
  }
  REQUIRE(solver->extend());
  CHECK(c.events().size() == events);  // leaving the dent is no second release
}

TEST_CASE("uneven bridges tilt the core, mirrored ones do not: not by one bit", "[mechanics]") {
  auto even = powbench::bench::reference_closing();
  even.modes.clear();
  for (auto& b : even.bridges) b.gap[0] = b.gap[1] = std::fabs(b.position) > 20e-3 ? 2.2e-3 : 3e-3;
  const auto poles = [](const RigidParts& p) {
    RigidOptions o;
    o.end = 0.04;
    std::array<double, 2> first{};
    for (const auto& e : run_rigid(p, {}, o).events)
      if (const auto place = contact_place(e.contact); place.kind == ContactKind::pole)
        if (auto& t = first[static_cast<std::size_t>(place.end)]; t == 0) t = e.time;
    return first;
  };
  const auto together = poles(even);
  CHECK(together[0] > 0.02);
  CHECK(together[0] == together[1]);
  auto uneven = even;
  uneven.bridges[4].preload *= 1.5;  // holds the side at +24 mm back
  const auto apart = poles(uneven);
  CHECK(apart[1] > apart[0] + 1e-7);
  auto other = even;
  other.bridges[3].preload *= 1.5;  // its mirror image at -24 mm
  const auto mirrored = poles(other);
  CHECK(mirrored[0] == Approx(apart[1]).margin(1e-8));
  CHECK(mirrored[1] == Approx(apart[0]).margin(1e-8));
}

namespace {

/// Copies solver and contactor at `when` and goes on with both: every bit has to agree.
void check_restart(const RigidParts& parts, const CoilDrive& drive, double when, double tolerance) {
  Contactor c(parts, drive, true);
  alignas(64) double y[Solver::capacity] = {};
  c.equilibrium(y);
  c.mark_energy(y);
  c.set_coil(0, y, true);
  const auto solver = std::make_unique<Solver>(c, tolerance, 1e-3);
  solver->restart(0, y, 1e-6);
  while (solver->end() < when) REQUIRE(solver->extend());
  Contactor twin = c;
  const auto resumed = std::make_unique<Solver>(twin, tolerance, 1e-3);
  resumed->resume(solver->memory());
  for (int k = 0; k < 200; ++k) {
    REQUIRE(solver->extend());
    REQUIRE(resumed->extend());
    REQUIRE(solver->end() == resumed->end());
    const auto bytes = static_cast<std::size_t>(c.size()) * sizeof(double);
    REQUIRE(std::memcmp(solver->end_state(), resumed->end_state(), bytes) == 0);
  }
  REQUIRE(c.events().size() == twin.events().size());
  CHECK(c.events().back().time == twin.events().back().time);
}

}  // namespace

TEST_CASE("restart at any time of the closing: dents, friction, coil and ledger go on bit for bit",
          "[mechanics]") {
  auto rubbing = powbench::bench::reference_closing();
  rubbing.pad = {1e8, 1.5, DampingForm::linear, 50, 0};
  rubbing.core_friction = 0.5;
  GapInductance potential;
  CoilDrive coil;
  coil.potential = &potential;
  coil.resistance = 60;
  for (int k = 1; k <= 12; ++k) {
    check_restart(rubbing, {}, 24e-3 + 0.7e-3 * k, 1e-7);
    check_restart(powbench::bench::reference_closing(), coil, 1.5e-3 * k, 1e-7);
  }
}

TEST_CASE("closings side by side in two threads have the bits of one alone", "[mechanics]") {
  RigidOptions o;
  o.tolerance = 1e-7;
  o.end = 0.035;
  const auto alone = run_rigid(powbench::bench::reference_closing(100), {}, o);
  std::array<RigidRun, 2> both;
  std::array<std::thread, 2> threads;
  for (std::size_t k = 0; k < 2; ++k)
    threads[k] = std::thread([&, k] { both[k] = run_rigid(powbench::bench::reference_closing(100), {}, o); });
  for (auto& t : threads) t.join();
  for (const auto& run : both) {
    REQUIRE(run.events.size() == alone.events.size());
    CHECK(run.evaluations == alone.evaluations);
    for (std::size_t k = 0; k < alone.events.size(); ++k) REQUIRE(run.events[k].time == alone.events[k].time);
  }
}

TEST_CASE("options and parts out of range: one sentence with key, value and range", "[mechanics]") {
  const auto refuses = [](auto change, const char* words) {
    auto p = powbench::bench::reference_closing();
    RigidOptions o;
    change(p, o);
    CHECK_THROWS_WITH(run_rigid(p, {}, o), Catch::Contains(words));
  };
  refuses([](RigidParts&, RigidOptions& o) { o.largest_step = 0.02; },
          "largest_step = 0.02, allowed above 1e-9 .. 0.01 s");
  refuses([](RigidParts&, RigidOptions& o) { o.end = -1; }, "end = -1, allowed above 0 .. 100 s");
  refuses([](RigidParts&, RigidOptions& o) { o.energy_bound = -1; },
          "energy_bound = -1, allowed 0 and above");
  refuses([](RigidParts& p, RigidOptions&) { p.static_mass = -0.1; }, "static_mass = -0.1, allowed above 0");
  // a positive gap that the seats' depth at rest has already used up
  refuses(
      [](RigidParts& p, RigidOptions&) {
        p.return_preload = 0.1;
        p.bridges[2].gap[1] = 1e-6;
      },
      "bridge 3.gap = 1e-06, allowed above");
}
