// Identification: a device that the simulator made is found again, and angles it was not told are predicted.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/study/fit.h"
#include "sim/study/posterior.h"
#include "sim/study/steady.h"

using namespace powbench::sim;
using powbench::Measured;
using powbench::pi;
using powbench::radians;

namespace {

MeasuredClosing closing_of(const Specimen& s, double degrees) {
  MeasuredClosing m;
  m.conditions.closing_angle = radians(degrees);
  const auto t = simulate(s, m.conditions, 0.06, 0, 1e-8).truth;
  m.touch = {*t.touch, 20e-6};
  m.seat = {*t.core_seat, 20e-6};
  m.bounce = {*t.settled - *t.touch, 100e-6};
  return m;
}

FitProblem small_problem(const Specimen& device, std::initializer_list<double> angles) {
  FitProblem p;
  p.base = Specimen{};
  const auto around = [&](const char* name, double share) {
    const auto& f = specimen_field(name);
    const double v = f.get(p.base) / f.si_per_unit;
    p.parameters.push_back(parameter(name, v * (1 - share), v * (1 + share)));
  };
  around("coil.resistance_ohm", 0.1);
  around("core.return_preload_N", 0.2);
  around("bridges.gap_mm", 0.06);
  for (const double a : angles) p.closings.push_back(closing_of(device, a));
  p.prior_deviation = 0;
  p.edge = 0;
  p.robust = false;
  return p;
}

}  // namespace

TEST_CASE("steady current of a linear coil without ring: U / |R + j w L|") {
  Specimen s;
  s.magnet.shaded_share = 0;
  s.magnet.bh_power = 0;
  s.magnet.fringing = 0;
  Mains mains;
  for (const double separation : {s.core.travel, 1e-3, 0.0}) {
    // without a share inside the ring the outer poles carry all of phi: r (phi + phi) and the iron
    const double r = (s.magnet.residual_gap + separation) / (4e-7 * pi * s.magnet.pole_area);
    const double reluctance = 2 * r + s.magnet.iron_length * s.magnet.bh_linear / s.magnet.pole_area;
    const double inductance = s.coil.turns * s.coil.turns / reluctance + s.coil.leakage;
    const double expected = mains.volts / std::hypot(s.coil.resistance, 2 * pi * mains.hertz * inductance);
    // what is left of the offset after two periods: R / (w L) at the most
    CHECK(steady_current(s, mains, separation) == Approx(expected).epsilon(0.02));
  }
}

TEST_CASE("steady currents side by side are those of each place alone, to the bit") {
  const Mains mains;
  const auto compare = [&](const Specimen& s) {
    const SteadyCurrents both = steady_currents(s, mains);
    CHECK(both.open == steady_current(s, mains, s.core.travel));
    CHECK(both.closed == steady_current(s, mains, 0));
    CHECK(both.open > 2 * both.closed);
  };
  Specimen s;  // its ring asks for more steps with the core open
  compare(s);
  for (const double exponent : {3.0, 7.4, 9.0}) {
    s.magnet.bh_exponent = exponent;
    compare(s);
  }
  s.magnet.ring_resistance *= 30;
  compare(s);
  s.magnet.shaded_share = 0;
  compare(s);
  s = {};
  s.magnet.steel = "measured";
  s.magnet.steel_b = {0.5, 1, 1.5, 2};
  s.magnet.steel_h = {60, 140, 1500, 3e4};
  compare(s);
}

TEST_CASE("a device with three numbers off is found again and predicts an angle it has not seen") {
  Specimen device;
  device.coil.resistance *= 1.04;
  device.core.return_preload *= 0.93;
  device.bridges.gap *= 1.015;
  const FitProblem problem = small_problem(device, {10, 50, 120, 160});
  FitOptions options;
  options.evaluations = 900;
  options.ensemble = 2;
  Team team(2);
  const FitResult r = fit(Misfit(problem), options, team);
  CHECK_FALSE(r.stopped);
  CHECK(r.best.specimen.coil.resistance == Approx(device.coil.resistance).epsilon(3e-3));
  CHECK(r.best.specimen.core.return_preload == Approx(device.core.return_preload).epsilon(1e-2));
  CHECK(r.best.specimen.bridges.gap == Approx(device.bridges.gap).epsilon(3e-3));
  const auto unseen = closing_of(device, 30);
  const auto predicted = closing_of(r.best.specimen, 30);
  CHECK(predicted.touch.value == Approx(unseen.touch.value).epsilon(3e-3));
  CHECK(predicted.seat.value == Approx(unseen.seat.value).epsilon(3e-3));
  REQUIRE(r.ensemble.size() == 2);
  CHECK(r.ensemble[0].point != r.ensemble[1].point);
  CHECK(r.sensitivity.rows == 4 * 4);
  for (const double d : r.identifiability.deviation) CHECK((d > 0 && d < 0.5));
}

TEST_CASE("a fit does not depend on the number of threads and stops when asked") {
  const FitProblem problem = small_problem(Specimen{}, {30, 150});
  FitOptions options;
  options.evaluations = 120;
  options.ensemble = 0;
  options.polished = 0;
  Team one(1), three(3);
  CHECK(fit(Misfit(problem), options, one).best.point == fit(Misfit(problem), options, three).best.point);
  FitWatch watch;
  int generations = 0;
  watch.go_on = [&](long, long, double) { return ++generations < 3; };
  const FitResult r = fit(Misfit(problem), options, one, watch);
  CHECK(r.stopped);
  CHECK(generations == 3);
}

TEST_CASE("the misfit: zero at the device itself, large where nothing closes, early end above the limit") {
  FitProblem problem = small_problem(Specimen{}, {60, 150});
  problem.tolerance = 1e-8;
  const Misfit misfit(problem);
  const std::vector<double> middle(3, 0.5);
  CHECK(misfit.value(middle) < 1e-3);
  FitProblem stiff = problem;
  stiff.parameters = {parameter("core.return_preload_N", 100, 200)};
  CHECK(Misfit(stiff).value(std::vector<double>{0.5}) > 3000);
  CHECK(Misfit(stiff).value(std::vector<double>{0.5}, 10) < Misfit(stiff).value(std::vector<double>{0.5}));
  // residuals and value agree where nothing is a step
  double sum = 0;
  const std::vector<double> off{0.6, 0.4, 0.5};
  for (const double r : misfit.residuals(off, problem.tolerance)) sum += r * r;
  CHECK(sum == Approx(misfit.value(off)).epsilon(1e-9));
}

TEST_CASE(
    "the misfit: an overtravel time that is a target adds one residual a closing, and nothing else moves") {
  FitProblem problem = small_problem(Specimen{}, {60, 150});
  problem.tolerance = 1e-8;
  const Misfit without(problem);
  for (auto& m : problem.closings) {
    const double time = m.seat.value - m.touch.value;
    m.overtravel_time = {time + 0.3e-3, 0.1e-3};
  }
  const Misfit with(problem);
  CHECK(without.per_closing() == 4);
  CHECK(with.per_closing() == 5);
  const std::vector<double> middle(3, 0.5);
  const auto before = without.residuals(middle, 1e-8), after = with.residuals(middle, 1e-8);
  REQUIRE(after.size() == before.size() + 2);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < 4; ++i) CHECK(after[5 * k + i] == before[4 * k + i]);
    CHECK(after[5 * k + 4] == Approx(-3).margin(0.02));  // 0.3 ms later than simulated, in units of 0.1 ms
  }
  CHECK(with.value(middle) == Approx(without.value(middle) + 18).margin(0.3));
  // it is smooth: the search for posteriors keeps it, and shifts it
  CHECK(with.motion().problem().closings[0].overtravel_time.known());
  const auto moved = with.perturbed(std::vector<double>{1}).problem().closings;
  for (std::size_t k = 0; k < 2; ++k)
    CHECK(moved[k].overtravel_time.value == Approx(problem.closings[k].overtravel_time.value + 0.1e-3));
}

TEST_CASE("side by side, a misfit has the bits of its closings one by one, on any number of threads") {
  FitProblem problem = small_problem(Specimen{}, {20, 60, 150});
  problem.parameters.push_back(parameter("core.return_preload_N", 8, 200));  // some close, some do not
  problem.parameters.push_back(parameter("magnet.bh_exponent", 8, 10));      // mostly unknown to the lanes
  problem.plausible = catalogue_ranges();
  problem.robust = true;
  std::vector<std::vector<double>> points;
  powbench::Random random(8);
  for (int k = 0; k < 20; ++k) {
    points.emplace_back();
    for (int i = 0; i < 5; ++i) points.back().push_back(random.uniform());
    if (k % 2 == 0) points.back()[3] = 0.01 * random.uniform(), points.back()[4] = 0.5;
  }
  Team one(1), three(3);
  for (const bool absolute : {false, true}) {
    problem.absolute = absolute;
    const Misfit misfit(problem);
    std::vector<double> values, limits;
    for (const auto& p : points) values.push_back(misfit.value(p));
    const std::vector<double> never(points.size(), std::numeric_limits<double>::infinity());
    CHECK(misfit.values(points, never, one) == values);
    CHECK(misfit.values(points, never, three) == values);
    for (std::size_t k = 0; k < points.size(); ++k)
      limits.push_back(k % 3 == 0 ? values[k] : 0.3 * values[k]);
    const auto limited = misfit.values(points, limits, three);
    for (std::size_t k = 0; k < points.size(); ++k) CHECK(limited[k] == misfit.value(points[k], limits[k]));
  }
  const Misfit misfit(problem);
  const auto all = misfit.residuals(points, 1e-6, three);
  const auto bounces = misfit.bounces(points, 1e-6, three);
  for (std::size_t k = 0; k < points.size(); ++k) {
    CHECK(all[k] == misfit.residuals(points[k], 1e-6));
    for (std::size_t c = 0; c < 3; ++c) {
      const auto t =
          tried_closing(misfit.specimen(points[k]), problem.closings[c].conditions, problem.duration, 1e-6);
      const bool closed = t.touch && t.core_seat;
      CHECK(std::isfinite(bounces[k][c]) == closed);
      if (!closed) continue;
      CHECK(bounces[k][c] == *t.settled - *t.touch);
      CHECK(all[k][misfit.per_closing() * c] == (*t.touch - problem.closings[c].touch.value) / 20e-6);
    }
  }
}

TEST_CASE("a posterior: the device by touch and seat alone; bounce moves no draw and tells each a factor") {
  Specimen device;
  device.coil.resistance *= 1.05;
  device.core.return_preload *= 0.9;
  device.bridges.gap *= 1.02;
  FitProblem problem = small_problem(device, {10, 50, 120, 160});
  PosteriorOptions options;
  options.evaluations = 200;
  options.samples = 12;
  options.tolerance = 1e-8;
  Team one(1), three(3);
  const auto always = [](double, double) { return true; };
  const auto sample = [&](Team& team) { return sample_posterior(Misfit(problem), options, team, always); };
  const Posterior p = sample(one);
  REQUIRE(p.samples.size() == 12);
  REQUIRE(p.bounce.factors.size() == 12);
  const Posterior threaded = sample(three);
  CHECK(p.samples == threaded.samples);
  CHECK(p.bounce.factors == threaded.bounce.factors);
  CHECK(p.misfit < 0.1);
  REQUIRE(p.ends.size() == 3);
  CHECK(std::is_sorted(p.ends.begin(), p.ends.end()));
  double mean = 0, square = 0;
  for (const auto& point : p.samples) {
    const double r = Misfit(problem).specimen(point).coil.resistance;
    mean += r / 12;
    square += r * r / 12;
  }
  // the spread is what deviations of 20 us leave open, about the truth: 8 times, in one direction of three
  const double spread = std::sqrt(square - mean * mean);
  CHECK(spread > 1e-5 * mean);
  CHECK(spread < 1e-2 * mean);
  CHECK(std::fabs(mean - device.coil.resistance) < 3 * spread / std::sqrt(12.0) + 1e-4 * mean);
  // the model is right: its bounces need no factor, and are worth more than those of other angles
  for (const double f : p.bounce.factors) CHECK(f == Approx(1).margin(0.05));
  CHECK(p.bounce.deviation < 0.3 * p.bounce.median_deviation);

  for (auto& m : problem.closings) m.bounce.value *= 1.2;
  const Posterior longer = sample(one);
  CHECK(longer.samples == p.samples);
  for (std::size_t k = 0; k < 12; ++k) CHECK(longer.bounce.factors[k] == Approx(1.2 * p.bounce.factors[k]));
  CHECK(longer.bounce.deviation == Approx(p.bounce.deviation));

  int asked = 0;
  const auto stop = [&](double, double) { return ++asked < 4; };
  CHECK(sample_posterior(Misfit(problem), options, one, stop).stopped);
  CHECK(asked == 4);

  // no device closes so: further starts are tried, as many as are allowed, for what might fit better
  problem.closings[1].touch.value += 1e-3;
  options.samples = 1;
  options.further_starts = 2;
  const Posterior none_fits = sample(one);
  CHECK(none_fits.misfit > 8);
  CHECK(none_fits.ends.size() == 5);
}

TEST_CASE("least pull: what the ring leaves at the zeros of the main flux, none of it without a ring") {
  Specimen s;
  Mains mains;
  const double held = least_pull(s, mains);
  CHECK(held > closed_load(s));  // the reference contactor holds
  mains.volts *= 0.5;
  CHECK(least_pull(s, mains) < 0.6 * held);
  mains.volts *= 2;
  s.magnet.shaded_share = 0;
  CHECK(least_pull(s, mains) < 0.02 * held);
  s.bridges.rate = 0;
  s.core.return_rate = 0;
  CHECK(closed_load(s) == Approx(s.core.return_preload + s.bridges.poles * s.bridges.preload));
}

TEST_CASE(
    "a device whose springs nearly match its least pull chatters in the whole simulation, one far below does "
    "not") {
  const auto late = [](const Specimen& s) {
    double last = 0;
    for (const double degrees : {45.0, 70.0, 80.0}) {
      powbench::Conditions c;
      c.closing_angle = radians(degrees);
      const auto t = simulate(s, c, 0.06, 0, 1e-5).truth;
      last = std::max(last, t.settled ? *t.settled : 1.0);
    }
    return last;
  };
  Specimen s;
  Mains mains;
  CHECK(closed_load(s) < 0.72 * least_pull(s, mains));
  CHECK(late(s) < 26e-3);
  s.magnet.ring_resistance *= 8;  // a weak ring
  CHECK(closed_load(s) > least_pull(s, mains));
  CHECK(late(s) > 40e-3);
}
