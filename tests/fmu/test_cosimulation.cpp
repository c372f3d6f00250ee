#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/commanded_phase.h"
#include "tests/fmu/importer.h"
#include "tests/fmu/specimens.h"

using namespace powbench;
using namespace powbench::test;

namespace {

constexpr double end = 0.03;      // s
constexpr double claimed = 1e-6;  // s: what the unit claims
constexpr double steps[] = {1e-6, 1e-5, 137e-6, 1e-3};

struct Times {
  double touch = -1, seat = -1;
};

Times times_of(Unit2& u) {
  return {u.get("pole[1].touch_time"), u.get("seat_time")};
}

sim::ClosingTruth native(const sim::Specimen& s, const Conditions& c, const sim::Supply& bench = {}) {
  return sim::simulate_rigid(s, c, end, 0, 1e-8, true, bench).truth;
}

/// Steps to the end; `before(k, t)` sets inputs.
template <class Before>
Times run(Unit2& u, double h, Before&& before) {
  for (int k = 0; k * h < end - 0.5 * h; ++k) {
    before(k, k * h);
    REQUIRE(u.step(k * h, h) == 0);
  }
  return times_of(u);
}

void check_close(const Times& t, const sim::ClosingTruth& truth) {
  REQUIRE((truth.touch && truth.core_seat));
  CHECK(std::fabs(t.touch - *truth.touch) < claimed);
  CHECK(std::fabs(t.seat - *truth.core_seat) < claimed);
}

}  // namespace

TEST_CASE("with its own sine the unit closes as the native simulation, at any communication step") {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> angle(0, 360);
  for (const auto& [name, specimen] : kinds_of_contactor()) {
    const Conditions c = conditions_at(angle(random));
    const auto trajectory = sim::simulate_rigid(specimen, c, end, 1e-3);
    const auto& truth = trajectory.truth;
    const Unpacked files(specimen, fmu::Fmi::two);
    Times first;
    for (const double h : steps) {
      INFO(name << ", " << h << " s");
      Unit2 u(files, fmu::fmi2::co_simulation);
      REQUIRE(u.c != nullptr);
      u.set("source.volts", c.supply_volts);
      u.set("source.phase", commanded_phase(c));
      u.start();
      const Times t = run(u, h, [](int, double) {});
      check_close(t, truth);
      if (first.touch < 0) first = t;
      CHECK((t.touch == first.touch && t.seat == first.seat));  // the step has no influence at all
      if (h != 1e-3) continue;
      const auto& last = trajectory.samples.back();
      CHECK(u.get("time") == Approx(last.time).epsilon(1e-12));
      CHECK(u.get("coil_current") == Approx(last.coil_current).epsilon(1e-3).margin(1e-5));
      CHECK(u.get("flux_linkage") == Approx(last.flux_linkage).epsilon(1e-4));
      CHECK(u.get("magnetic_force") == Approx(last.pull).epsilon(1e-3));
      CHECK(u.get("core_position") == Approx(last.travel).margin(2e-6));
      CHECK(u.get("core_speed") == Approx(last.core_velocity).margin(2e-3));
      CHECK(u.get("pole[1].force_a") == Approx(last.force_a).epsilon(0.02).margin(0.05));
      CHECK(u.get("pole[1].force_b") == Approx(last.force_b).epsilon(0.02).margin(0.05));
      CHECK(u.is("core_seated") == (last.core_force > 0));
      CHECK(u.is("pole[1].closed") == (last.force_a > 0 && last.force_b > 0));
    }
  }
}

TEST_CASE("with a held voltage the unit closes as the native simulation on a direct source with dips") {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> share(0.1, 0.7);
  for (const double h : steps) {
    sim::Supply bench;
    bench.mains.kind = sim::Mains::Kind::dc;
    const double unit_of_time = std::max(h, 1e-3 * (h < 1e-4)) == h ? h : std::round(1e-3 / h) * h;
    const auto grid = [&](double t) { return std::round(t / unit_of_time) * unit_of_time; };
    bench.mains.dips[0] = {grid(2e-3), grid(3e-3), share(random), 0};
    bench.mains.dips[1] = {grid(4e-3), grid(6e-3), share(random), 0};
    for (const auto& [name, specimen] : kinds_of_contactor()) {
      if (h < 1e-5 && name != "reference") continue;
      const Conditions c = conditions_at(0, 200);
      const auto truth = native(specimen, c, bench);
      INFO(name << ", " << h << " s");
      const Unpacked files(specimen, fmu::Fmi::two);
      Unit2 u(files, fmu::fmi2::co_simulation);
      u.start();
      const auto volts = [&](double t) {
        double v = c.supply_volts;
        for (const auto& d : bench.mains.dips)
          if (t > d.start - 0.5 * h && t < d.start + d.duration - 0.5 * h) v *= 1 - d.depth;
        return v;
      };
      check_close(run(u, h, [&](int, double t) { u.set("coil_voltage", volts(t)); }), truth);
    }
  }
}

TEST_CASE("with five input derivatives a sampled sine is the sine, also at 1 ms") {
  const Unpacked files({}, fmu::Fmi::two);
  for (const double degrees : {0.0, 67.0, 135.0}) {
    const Conditions c = conditions_at(degrees);
    const auto truth = native({}, c);
    const double peak = std::sqrt(2.0) * c.supply_volts, w = 2 * pi * c.mains_hertz;
    for (const double h : steps) {
      if (h < 1e-5 && degrees > 0) continue;
      INFO(degrees << " degrees, " << h << " s");
      Unit2 u(files, fmu::fmi2::co_simulation);
      u.start();
      const unsigned vr = u.reference("coil_voltage"), references[] = {vr, vr, vr, vr, vr};
      const int orders[] = {1, 2, 3, 4, 5};
      check_close(run(u, h,
                      [&](int, double t) {
                        const double a = w * t + commanded_phase(c);
                        u.set("coil_voltage", peak * std::sin(a));
                        double d[5], size = peak;
                        for (int k = 0; k < 5; ++k) d[k] = (size *= w) * std::sin(a + (k + 1) * pi / 2);
                        REQUIRE(u.call("fmi2SetRealInputDerivatives", &references[0], std::size_t{5},
                                       &orders[0], static_cast<const double*>(d)) == 0);
                      }),
                  truth);
    }
  }
}

TEST_CASE("FMI 3.0 takes a slope, returns early at every contact and shows it in event mode alone") {
  const Conditions c = conditions_at(40);
  const auto truth = native({}, c);
  const Unpacked files({}, fmu::Fmi::three);
  std::vector<std::vector<double>> all;
  for (const double h : {1e-3, 137e-6}) {
    Unit3 u(files, true, true);
    REQUIRE(u.c != nullptr);
    u.set("source.volts", c.supply_volts);
    u.set("source.phase", commanded_phase(c));
    u.start();
    REQUIRE(u.step(0, h).status != 0);  // event mode comes first
    REQUIRE(u.update() == 0);
    REQUIRE(u.call("fmi3EnterStepMode") == 0);
    std::vector<double> closings;
    bool closed = false;
    double t = 0, goal = h;
    for (int k = 1; t < end;) {
      const auto s = u.step(t, goal - t);
      REQUIRE(s.status == 0);
      CHECK(s.reached > t);
      CHECK(s.early == (s.reached < goal));
      CHECK((!s.early || s.event));
      t = s.reached;
      if (t == goal) goal = ++k * h;
      CHECK(u.is("pole[1].closed") == closed);
      if (!s.event) continue;
      REQUIRE(u.call("fmi3EnterEventMode") == 0);
      REQUIRE(u.update() == 0);
      if (u.is("pole[1].closed") && !closed) closings.push_back(t);
      closed = u.is("pole[1].closed");
      REQUIRE(u.call("fmi3EnterStepMode") == 0);
    }
    REQUIRE(closings.size() >= 2);
    CHECK(std::fabs(closings[0] - *truth.touch) < claimed);
    CHECK(u.get("pole[1].touch_time") == closings[0]);
    CHECK(std::fabs(u.get("seat_time") - *truth.core_seat) < claimed);
    for (std::size_t k = 0; k + 1 < closings.size() && k < truth.openings.size() && k < 3; ++k)
      CHECK(std::fabs(closings[k + 1] - truth.openings[k].touch) < claimed);
    all.push_back(closings);
  }
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(all[0].at(k) - all[1].at(k)) < 1e-9);

  // without early return a step is whole, and the slope of the voltage counts
  Unit3 plain(files, false, false), sloped(files, false, false);
  plain.start(), sloped.start();
  for (int k = 0; k < 250; ++k) {
    const double h = 1e-4;
    for (int part = 0; part < 10; ++part) {  // the same ramp in finer steps
      plain.set("coil_voltage", 2e4 * (k * h + part * h / 10));
      plain.set("coil_voltage_rate", 2e4);
      REQUIRE(plain.step(k * h + part * h / 10, h / 10).status == 0);
    }
    sloped.set("coil_voltage", 2e4 * k * h);
    sloped.set("coil_voltage_rate", 2e4);
    const auto s = sloped.step(k * h, h);
    REQUIRE((s.status == 0 && !s.early && !s.event && s.reached == k * h + h));
  }
  CHECK((sloped.get("pole[1].touch_time") > 0 && sloped.get("seat_time") > 0));
  CHECK(std::fabs(plain.get("pole[1].touch_time") - sloped.get("pole[1].touch_time")) < claimed);
  CHECK(std::fabs(plain.get("seat_time") - sloped.get("seat_time")) < claimed);
}

TEST_CASE("parameters set before the start are the specimen's, and the coil's temperature counts") {
  sim::Specimen changed;
  changed.bridges.gap = 2.2e-3;
  changed.core.mass = 0.21;
  Conditions c = conditions_at(90, 240);
  c.ambient = 330;
  const auto truth = native(changed, c);
  const Unpacked files({}, fmu::Fmi::two);
  Unit2 u(files, fmu::fmi2::co_simulation);
  u.set("bridges.gap_mm", 2.2);
  u.set("core.mass_g", 210);
  u.set("coil_temperature", c.ambient);
  u.set("source.volts", c.supply_volts);
  u.set("source.phase", commanded_phase(c));
  u.start();
  check_close(run(u, 1e-3, [](int, double) {}), truth);
}

TEST_CASE("a coil that is switched off opens the contacts as the native one") {
  Conditions c = conditions_at(30);
  c.hold_time = 0.04;
  const auto native_run = sim::simulate_rigid({}, c, 0.08, 0);
  REQUIRE(native_run.truth.opened);
  const Unpacked files({}, fmu::Fmi::two);
  Unit2 u(files, fmu::fmi2::co_simulation);
  u.set("source.volts", c.supply_volts);
  u.set("source.phase", commanded_phase(c));
  u.start();
  const double h = 1e-4;
  double opened = -1;
  for (int k = 0; k < 800; ++k) {
    if (k == 400) {
      const unsigned vr = u.reference("coil_closed");
      const int off = 0;
      REQUIRE(u.call("fmi2SetBoolean", &vr, std::size_t{1}, &off) == 0);
    }
    REQUIRE(u.step(k * h, h) == 0);
    if (k > 400 && opened < 0 && !u.is("pole[1].closed")) opened = (k + 1) * h;
  }
  CHECK(opened >= *native_run.truth.opened);
  CHECK(opened < *native_run.truth.opened + 1.01 * h);
  CHECK(u.get("coil_current") == 0);
}
