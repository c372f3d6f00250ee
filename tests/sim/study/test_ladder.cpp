// The ladder of rungs: errors, estimates, and the choice by accuracy.

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "bench/study/estimate_coverage.h"
#include "core/units.h"
#include "sim/models/mechanics.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/study/ladder.h"

using namespace powbench::sim;

namespace {

/// A rung with known error: every time is off by `scale` times the tolerance; its cost is told by the clock.
struct KnownRungs {
  double now = 0;
  std::vector<Rung> rungs;

  void add(const std::string& mechanics, double scale, double cost) {
    rungs.push_back(
        {"circuit", mechanics, "known error", [this, scale, cost](const Case&, double, double tol, double) {
           now += cost / tol;
           Trajectory t;
           t.truth.touch = 0.010 + scale * tol;
           t.truth.core_seat = 0.012 - 2 * scale * tol;
           t.truth.settled = 0.015;
           return t;
         }});
  }
  CpuClock clock() {
    return [this] { return now; };
  }
};

Case at(double degrees, double volts = 230) {
  Case c;
  c.conditions.closing_angle = powbench::radians(degrees);
  c.conditions.supply_volts = volts;
  return c;
}

double no_clock() {
  return 0;
}

}  // namespace

TEST_CASE("error and estimate of a rung whose error is known", "[ladder]") {
  KnownRungs known;
  known.add("first", 1, 1e-6);
  known.add("second", 3, 1e-7);
  LadderOptions o;
  o.tolerances = {1e-3, 1e-4};
  o.truth = 1e-9;
  const auto ladder = run_ladder(known.rungs, at(0), o, known.clock());
  REQUIRE(ladder.rows.size() == 4);
  CHECK(ladder.rows[0].error[0] == Approx(1e-3 - 1e-9));
  CHECK(ladder.rows[0].estimate[0] == Approx(estimator_factor * 0.9e-3));
  CHECK(ladder.rows[3].error[1] == Approx(6e-4 - 6e-9));
  CHECK(ladder.rows[3].estimate[1] == Approx(estimator_factor * 5.4e-4));
  CHECK(ladder.rows[1].run.cpu == Approx(1e-2));
  CHECK(ladder.rows[3].error[2] == 0);
  CHECK(ladder.rows[3].estimate[2] == Approx(1e-12));
  REQUIRE(ladder.models.size() == 1);
  CHECK(ladder.models[0].difference[1] == Approx(4e-9).epsilon(1e-6));
}

TEST_CASE("the cheapest rung and tolerance that meets the accuracy is taken", "[ladder]") {
  // at 10 ms: 1 % is 1e-4 s; estimates are 2.5 * 1.8 and 2.5 * 3.6 times the tolerance: 1e-5 meets it, 1e-4 does not
  KnownRungs known;
  known.add("first", 1, 1e-6);
  known.add("second", 2, 1e-7);
  const auto cheap = choose_rung(known.rungs, at(0), 0.01, 0.08, known.clock());
  CHECK(cheap.met);
  CHECK(cheap.run.rung == 1);
  CHECK(cheap.run.tolerance == Approx(1e-5));
  CHECK(cheap.relative <= 0.01);
  CHECK(cheap.spent == Approx(known.now));
  const auto only = choose_rung(std::span(known.rungs).first(1), at(0), 0.01, 0.08, known.clock());
  CHECK(only.run.rung == 0);
  CHECK(only.run.cpu == Approx(0.1));
}

TEST_CASE("an accuracy out of reach is said to be", "[ladder]") {
  KnownRungs known;
  known.add("first", 1, 1e-6);
  const auto c = choose_rung(known.rungs, at(0), 1e-9, 0.08, known.clock(), 1e-3, 1e-6);
  CHECK_FALSE(c.met);
  CHECK(c.relative > 1e-9);
  CHECK(c.run.tolerance == Approx(1e-5));  // the one that comes nearest; 1e-6 only serves to judge it
  CHECK(c.tried.size() == 3);
}

TEST_CASE("a time that only one run has is an infinite error, one that none has is no error", "[ladder]") {
  LadderRun a;
  LadderRun b;
  a.times = {0.01, std::nan(""), std::nan("")};
  b.times = {0.01, 0.02, std::nan("")};
  const auto e = time_error(a, b);
  CHECK(e[0] == 0);
  CHECK(std::isinf(e[1]));
  CHECK(std::isnan(e[2]));
  CHECK(std::isinf(largest(error_estimate(a, b))));
}

TEST_CASE("both rungs go to the same closing, and the choice keeps its promise", "[ladder]") {
  const auto rungs = closing_rungs();
  for (const double degrees : {0.0, 60.0, 90.0}) {
    const Case c = at(degrees);
    const auto plant = run_rung(rungs, 0, c, 0.08, 1e-12, no_clock);
    const auto rigid = run_rung(rungs, 1, c, 0.08, 1e-12, no_clock);
    CHECK(largest(time_error(plant, rigid)) < 1e-9);
    for (const double accuracy : {1e-2, 1e-4, 1e-6}) {
      const auto choice = choose_rung(rungs, c, accuracy, 0.08, no_clock);
      REQUIRE(choice.met);
      CHECK(largest(time_error(choice.run, plant)) <= accuracy * plant.times[0]);
    }
  }
}

TEST_CASE("another potential drives the same rigid parts", "[ladder]") {
  // the circuit again, but held at gap 0 where the faces are pressed together: equal until the core arrives
  const Case c = at(60);
  const std::vector<Rung> rungs{
      closing_rungs()[1],
      scene_rung(pure_field("again", "the circuit", std::make_shared<SpecimenPotential>(c.specimen)),
                 "rigid")};
  CHECK(rungs[1].name() == "again+rigid");
  const auto a = run_rung(rungs, 0, c, 0.08, 1e-11, no_clock);
  const auto b = run_rung(rungs, 1, c, 0.08, 1e-11, no_clock);
  const auto difference = time_error(a, b);
  CHECK(difference[0] < 1e-9);
  CHECK(difference[1] < 1e-9);
  CHECK(difference[2] > 1e-9);
}

TEST_CASE("a coil that does not pull in has no times and no error", "[ladder]") {
  const auto rungs = closing_rungs();
  const auto choice = choose_rung(rungs, at(0, 40), 0.01, 0.08, no_clock);
  CHECK(choice.met);
  for (const double t : choice.run.times) CHECK(std::isnan(t));
}

TEST_CASE("the estimate covers the error in most of some random scenes, and scenes repeat", "[ladder]") {
  const auto scenes = powbench::bench::random_scenes({}, 25, 3);
  const auto again = powbench::bench::random_scenes({}, 25, 3);
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    CHECK(scenes[k].conditions.closing_angle == again[k].conditions.closing_angle);
    CHECK((scenes[k].conditions.supply_volts >= 195.5 && scenes[k].conditions.supply_volts <= 253));
  }
  LadderOptions o;
  o.tolerances = {1e-4, 1e-5, 1e-6};
  o.truth = 1e-11;
  o.repeats = 1;
  int happened = 0;
  double covered = 0;
  Team team(1);
  for (const auto& c : powbench::bench::estimator_coverage(closing_rungs(), scenes, o, no_clock, team)) {
    for (const int n : c.happened) happened += n;
    for (const int n : c.covered) covered += n;
  }
  CHECK(happened > 400);
  CHECK(covered / happened > 0.85);
  CHECK(covered / happened < 1);
}

TEST_CASE("bad requests are refused by name", "[ladder]") {
  const auto rungs = closing_rungs();
  CHECK_THROWS_AS(choose_rung(rungs, at(0), 0, 0.08, no_clock), std::invalid_argument);
  CHECK_THROWS_AS(choose_rung({}, at(0), 0.01, 0.08, no_clock), std::invalid_argument);
  LadderOptions o;
  o.tolerances = {1e-3, 1e-5};
  CHECK_THROWS_AS(run_ladder(rungs, at(0), o, no_clock), std::invalid_argument);
  o.tolerances = {1e-3, 1e-4};
  o.truth = 1e-5;
  CHECK_THROWS_AS(run_ladder(rungs, at(0), o, no_clock), std::invalid_argument);
}
