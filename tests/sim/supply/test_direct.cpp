// Direct and rectified sources, what lies across the coil, and the economiser: against closed forms of R and L.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <functional>

#include "sim/models/rigid_closing.h"
#include "tests/sim/supply/supply_cases.h"

using namespace powbench;
using namespace powbench::sim;
using Source = Mains::Kind;
using Across = Suppression::Kind;

namespace {

constexpr double volts = 48, off = 30e-3;

struct PlainCoil {
  Specimen specimen = plain_coil();
  double l = open_inductance(specimen), r = specimen.coil.resistance;
};

Supply of(Source kind, Across across = Across::none) {
  Supply s;
  s.mains.kind = kind;
  s.suppression.kind = across;
  return s;
}

Supply rc_of() {
  Supply s = of(Source::dc, Across::rc);
  s.suppression.resistance = 1000;
  s.suppression.capacitance = 5e-7;
  return s;
}

/// Conditions of a plain coil that is on for `off`.
Conditions short_hold(double degrees = 0) {
  Conditions c = at_angle(degrees, volts);
  c.hold_time = off;
  return c;
}

std::vector<double> current_ends(const Trajectory& run) {
  std::vector<double> times;
  for (const auto& e : run.events)
    if (e.kind == PlantEvent::Kind::coil_open) times.push_back(e.time);
  return times;
}

/// The largest difference of the current from `expected`, A, on the plant and on the rigid rung.
double worst_of_both(const Specimen& s, const Conditions& c, const Supply& supply, double duration,
                     const std::function<double(double)>& expected) {
  double worst = 0;
  for (const auto& run : {simulate(s, c, duration, 1e-4, 1e-11, supply),
                          simulate_rigid(s, c, duration, 1e-4, 1e-11, true, supply)}) {
    CHECK(run.energy_residual < 1e-7);
    for (const auto& p : run.samples) worst = std::max(worst, std::fabs(p.coil_current - expected(p.time)));
  }
  return worst;
}

/// The plain coil by many small steps of the rule for its voltage: u(t), current -> V; a current below zero is zero.
std::vector<double> by_small_steps(const PlainCoil& coil, double duration,
                                   const std::function<double(double, double)>& voltage) {
  constexpr double h = 5e-7;
  constexpr int each = 200;  // a value every 1e-4 s
  std::vector<double> values;
  double i = 0;
  for (int k = 1; (k - 1) * h < duration; ++k) {
    const double middle = (k - 0.5) * h, decay = std::exp(-coil.r / coil.l * h);
    i = std::max(0.0, i * decay + voltage(middle, i) / coil.r * (1 - decay));
    if (k % each == 0) values.push_back(i);
  }
  return values;
}

}  // namespace

TEST_CASE("a direct source drives the coil as R and L do, and a diode lets its current die out") {
  const PlainCoil c;
  Supply dc = of(Source::dc, Across::diode);
  dc.suppression.forward = 0.8;
  dc.suppression.resistance = 55;
  dc.mains.resistance = 5;
  const double on = c.r + 5, free = c.r + 55;
  const double reached = volts / on * (1 - std::exp(-off * on / c.l)), held = 0.8 / free;
  const double gone = off + c.l / free * std::log(1 + reached / held);
  const auto expected = [&](double t) {
    if (t <= off) return volts / on * (1 - std::exp(-t * on / c.l));
    return t >= gone ? 0.0 : (reached + held) * std::exp(-(t - off) * free / c.l) - held;
  };
  CHECK(worst_of_both(c.specimen, short_hold(73), dc, 0.4, expected) < 1e-9);
  const auto ends = current_ends(simulate(c.specimen, short_hold(), 0.4, 0, 1e-11, dc));
  REQUIRE(ends.size() == 1);
  CHECK(ends[0] == Approx(gone).margin(1e-8));
}

TEST_CASE("a varistor holds its voltage: closed forms of a constant one and of a resistor") {
  const PlainCoil c;
  const double reached = volts / c.r * (1 - std::exp(-off * c.r / c.l));
  Supply dc = of(Source::dc, Across::varistor);
  dc.suppression.clamp = 150;
  dc.suppression.clamp_exponent = 0;
  const double held = 150 / c.r, gone = off + c.l / c.r * std::log(1 + reached / held);
  const auto constant = [&](double t) {
    if (t <= off) return volts / c.r * (1 - std::exp(-t * c.r / c.l));
    return t >= gone ? 0.0 : (reached + held) * std::exp(-(t - off) * c.r / c.l) - held;
  };
  CHECK(worst_of_both(c.specimen, short_hold(), dc, 0.08, constant) < 1e-9);

  dc.suppression.clamp_exponent = 1;
  dc.suppression.clamp_current = 0.2;  // 750 ohm down to 20 uA
  const auto resistor = [&](double t) {
    return t <= off ? constant(t) : reached * std::exp(-(t - off) * (c.r + 750) / c.l);
  };
  REQUIRE(resistor(0.033) > 1e-4);
  CHECK(worst_of_both(c.specimen, short_hold(), dc, 0.033, resistor) < 1e-9);
}

TEST_CASE("a capacitor with its resistor rings with the coil") {
  const PlainCoil c;
  Supply dc = of(Source::dc, Across::rc);
  dc.suppression.capacitance = 2e-6;
  dc.suppression.resistance = 100;
  const double reached = volts / c.r * (1 - std::exp(-off * c.r / c.l));
  const double r = c.r + 100, damped = r / (2 * c.l), omega = std::sqrt(1 / (c.l * 2e-6) - damped * damped);
  const double slope = (volts - r * reached) / c.l;  // of the current, the capacitor charged to the source
  const auto expected = [&](double t) {
    if (t <= off) return volts / c.r * (1 - std::exp(-t * c.r / c.l));
    const double s = t - off;
    return std::exp(-damped * s) *
           (reached * std::cos(omega * s) + (slope + damped * reached) / omega * std::sin(omega * s));
  };
  CHECK(worst_of_both(c.specimen, short_hold(), dc, 0.05, expected) < 1e-8);

  dc.mains.resistance = 40;  // the source charges the capacitor and feeds the coil through it
  const auto run = simulate(c.specimen, short_hold(), 0.12, 1e-4, 1e-11, dc);
  const auto rigid = simulate_rigid(c.specimen, short_hold(), 0.12, 1e-4, 1e-11, true, dc);
  CHECK(run.energy_residual < 1e-7);
  CHECK(rigid.energy_residual < 1e-7);
  const auto small = [&] {  // both states by small steps of Heun's rule
    double i = 0, v = 0;
    constexpr double h = 1e-7;
    const auto rates = [&](double a, double b, double& da, double& db) {
      const double at = (volts - 40 * a + 0.4 * b) / 1.4;
      da = (at - c.r * a) / c.l;
      db = (at - b) / (100 * 2e-6);
    };
    for (int k = 0; k < 50'000; ++k) {
      double a1, b1, a2, b2;
      rates(i, v, a1, b1);
      rates(i + h * a1, v + h * b1, a2, b2);
      i += 0.5 * h * (a1 + a2);
      v += 0.5 * h * (b1 + b2);
    }
    return i;
  }();
  CHECK(run.samples[49].coil_current == Approx(small).epsilon(1e-8));
  CHECK(rigid.samples[49].coil_current == Approx(small).epsilon(1e-8));
}

TEST_CASE("without suppression a direct current is cut, and its energy is booked as lost") {
  const PlainCoil c;
  const Supply dc = of(Source::dc);
  const auto run = simulate(c.specimen, short_hold(), 0.06, 1e-4, 1e-10, dc);
  REQUIRE(current_ends(run).size() == 1);
  CHECK(current_ends(run)[0] == Approx(off).margin(1e-12));
  for (const auto& p : run.samples) CHECK((p.time <= off) == (p.coil_current != 0));
  CHECK(run.energy_residual < 1e-8);
}

TEST_CASE("rectified mains: half wave and full wave, with and without a diode across the coil") {
  const PlainCoil c;
  for (const auto kind : {Source::half_wave, Source::full_wave})
    for (const auto across : {Across::none, Across::diode})
      for (const double degrees : {0.0, 50.0, 200.0, 300.0}) {
        CAPTURE(static_cast<int>(kind), static_cast<int>(across), degrees);
        Supply s = of(kind, across);
        s.mains.rectifier_drop = 1.4;
        s.mains.resistance = 20;
        s.mains.harmonics[1].share = 0.06;
        Conditions cond = short_hold(degrees);
        cond.hold_time = 1;
        const auto values = by_small_steps(c, 0.1, [&](double t, double i) {
          const double a = 2 * pi * 50 * t + radians(degrees);
          const double u = std::sqrt(2.0) * volts * (std::sin(a) + 0.06 * std::sin(5 * a));
          const double e = (kind == Source::full_wave ? std::fabs(u) : u) - 1.4 - 20 * i;
          return across == Across::diode ? std::max(e, -0.7) : e;
        });
        const auto at = [&](double t) { return values[static_cast<std::size_t>(std::lround(t * 1e4)) - 1]; };
        CHECK(worst_of_both(c.specimen, cond, s, 0.0995, at) < 2e-6);
      }
}

TEST_CASE("an economiser: the ripple of its steady state, between closed forms") {
  const PlainCoil c;
  Supply dc = of(Source::dc, Across::diode);
  dc.coil_switch.hold_period = 2e-3;
  dc.coil_switch.hold_after = 20e-3;
  dc.coil_switch.hold_duty = 0.3;
  Conditions cond = short_hold();
  cond.hold_time = 1;
  const double q = c.r / c.l, full = volts / c.r, back = 0.7 / c.r;
  const double fed = std::exp(-q * 0.6e-3), free = std::exp(-q * 1.4e-3);
  // high = full (1 - fed) + low fed, low = (high + back) free - back
  const double high = (full * (1 - fed) - back * (1 - free) * fed) / (1 - fed * free);
  const double low = (high + back) * free - back;
  for (const auto& run : {simulate(c.specimen, cond, 0.9, 1e-4, 1e-11, dc),
                          simulate_rigid(c.specimen, cond, 0.9, 1e-4, 1e-11, true, dc)}) {
    double least = 1, most = 0;
    for (const auto& p : run.samples)
      if (p.time > 0.88) {
        least = std::min(least, p.coil_current);
        most = std::max(most, p.coil_current);
      }
    CHECK(least == Approx(low).epsilon(1e-6));
    CHECK(most == Approx(high).epsilon(1e-6));
    CHECK(run.samples[198].coil_current == Approx(full * (1 - std::exp(-q * 19.9e-3))).epsilon(1e-8));
    CHECK(run.energy_residual < 1e-7);
  }
}

TEST_CASE(
    "a whole closing and release on direct and rectified sources: both models, energy, order of release") {
  Specimen s;
  s.magnet.shaded_share = 0;  // direct current needs no ring
  Conditions c = at_angle(0, 240);
  c.hold_time = 80e-3;
  const auto released = [&](const Supply& supply) {
    const auto run = simulate(s, c, 0.5, 1e-3, 1e-9, supply);
    const auto rigid = simulate_rigid(s, c, 0.5, 1e-3, 1e-9, true, supply);
    REQUIRE(run.truth.core_seat);
    REQUIRE(run.truth.opened);
    REQUIRE(rigid.truth.opened);
    CHECK(run.energy_residual < 1e-6);
    CHECK(rigid.energy_residual < 1e-6);
    CHECK(*rigid.truth.core_seat == Approx(*run.truth.core_seat).margin(1e-7));
    CHECK(*rigid.truth.opened == Approx(*run.truth.opened).margin(1e-6));
    return *run.truth.opened - c.hold_time;
  };
  const double cut = released(of(Source::dc)), varistor = released(of(Source::dc, Across::varistor));
  const double rc = released(rc_of()), diode = released(of(Source::dc, Across::diode));
  CHECK(cut < varistor);
  CHECK(varistor < diode);
  CHECK(rc < diode);
  CHECK(diode > 3 * varistor);
  c.supply_volts = 270;
  CHECK(released(of(Source::full_wave, Across::diode)) > 2 * varistor);
  std::printf("  release after: cut %.2f ms, varistor %.2f, rc %.2f, diode %.2f\n", cut * 1e3, varistor * 1e3,
              rc * 1e3, diode * 1e3);
}

TEST_CASE("supplies whose parts do not go together are refused by key") {
  const auto refused = [](Source kind, Across across, auto&& change) {
    Supply s = of(kind, across);
    change(s);
    return [s] { require_valid(s); };
  };
  using Catch::Matchers::Contains;
  const auto as_is = [](Supply&) {};
  CHECK_THROWS_WITH(refused(Source::ac, Across::diode, as_is)(), Contains("suppression.kind = diode"));
  CHECK_THROWS_WITH(refused(Source::half_wave, Across::rc, as_is)(), Contains("suppression"));
  CHECK_THROWS_WITH(refused(Source::dc, Across::none, [](Supply& s) { s.mains.inductance = 1e-3; })(),
                    Contains("inductance"));
  CHECK_THROWS_WITH(
      refused(Source::dc, Across::none, [](Supply& s) { s.coil_switch.kind = CoilSwitch::Kind::triac; })(),
      Contains("triac"));
  CHECK_THROWS_WITH(refused(Source::dc, Across::none, [](Supply& s) { s.coil_switch.hold_period = 1e-3; })(),
                    Contains("hold_period"));
  CHECK_THROWS_WITH(
      refused(Source::full_wave, Across::diode, [](Supply& s) { s.suppression.resistance = 10; })(),
      Contains("resistance_ohm"));
  CHECK_NOTHROW(refused(Source::ac, Across::varistor, as_is)());
  CHECK_NOTHROW(refused(Source::full_wave, Across::diode, as_is)());
}
