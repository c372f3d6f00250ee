// Any fields with any mechanics, and the pair that a wanted accuracy needs.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/units.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/models/mechanics.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/study/scene_choice.h"

using namespace powbench::sim;

namespace {

constexpr double unwanted = std::numeric_limits<double>::quiet_NaN();

double no_clock() {
  return 0;
}

Case at(double degrees) {
  Case c;
  c.conditions.closing_angle = powbench::radians(degrees);
  return c;
}

/// Rungs whose model errors are known: fields f and mechanics m are off by 1e-3 / 10^f and 4e-4 / 10^m s.
SceneAxes known_axes(std::size_t fields, std::size_t mechanics) {
  SceneAxes axes;
  for (std::size_t f = 0; f < fields; ++f) axes.fields.push_back("field" + std::to_string(f));
  for (std::size_t m = 0; m < mechanics; ++m) axes.mechanics.push_back("mechanics" + std::to_string(m));
  axes.rung = [axes](std::size_t f, std::size_t m) {
    return Rung{axes.fields[f], axes.mechanics[m], "known error",
                [f, m](const Case&, double, double tolerance, double) {
                  Trajectory t;
                  t.truth.touch =
                      0.010 + 1e-3 * std::pow(0.1, f) + 4e-4 * std::pow(0.1, m) + 0.01 * tolerance;
                  t.truth.core_seat = 0.012;
                  t.truth.settled = 0.015;
                  return t;
                }};
  };
  return axes;
}

}  // namespace

TEST_CASE("a scene climbs along the axis that is furthest off, and stops where it may", "[scene]") {
  // fields: 9e-4, 9e-5; mechanics: 3.6e-4, 3.6e-5 s to the next rung
  const auto loose = choose_scene(known_axes(3, 3), at(0), {0.2, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(loose.reached() == Reached::met);
  CHECK(loose.rung.name() == "field0+mechanics0");
  const auto middle = choose_scene(known_axes(3, 3), at(0), {0.06, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(middle.reached() == Reached::met);
  CHECK(middle.rung.name() == "field1+mechanics0");
  const auto tight = choose_scene(known_axes(3, 3), at(0), {0.0135, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(tight.reached() == Reached::met);
  CHECK(tight.rung.name() == "field1+mechanics1");
  REQUIRE(tight.steps.size() == 3);
  CHECK(tight.steps[1].name == "field1+mechanics0");
  CHECK(tight.steps[2].mechanics.below[0] == Approx(3.6e-4).margin(4e-6));
  // to the next rung is its distance and its own step: 0.01 s times the tolerance, judged by a tenth of it
  const double step = estimator_factor * 0.01 * (1e-4 - 1e-5);
  CHECK(tight.steps[1].mechanics.above[0] == Approx(3.6e-4 + step).margin(1e-9));
  CHECK(tight.steps[1].step_error[0] == Approx(step).margin(1e-9));
  // where the next rung is far enough off, the others are not asked for; where it is not, they are
  CHECK(loose.steps[0].fields.above[0] == Approx(9.9e-4 + step).margin(1e-7));
  // what is not wanted does not climb
  CHECK(choose_scene(known_axes(3, 2), at(0), {unwanted, 1e-6, unwanted}, 0.08, {}, no_clock).rung.name() ==
        "field0+mechanics0");
}

TEST_CASE("a next rung that errs in the same direction is no proof", "[scene]") {
  // 0.2 ms to the next fields, which are 1 ms from those above
  SceneAxes axes = known_axes(3, 1);
  axes.rung = [axes](std::size_t f, std::size_t m) {
    Rung r = axes.rung(f, m);
    r.run = [f](const Case&, double, double, double) {
      Trajectory t;
      t.truth.touch = std::array{0.0100, 0.0102, 0.0112}[f];
      return t;
    };
    return r;
  };
  const auto all = look_at_all(axes, at(0), {0.05, unwanted, unwanted}, 0.08, no_clock);
  CHECK(all[0].fields.above[0] == Approx(1.2e-3));
  CHECK(all[0].by_time[0] == Reached::not_met);
  CHECK(all[1].by_time[0] == Reached::not_met);
}

TEST_CASE("the last increment of the fields bounds nothing, and left out fields are an unknown", "[scene]") {
  // as the plane table lies beside the circuit: near each other, and both 3 ms from the fields above
  SceneAxes axes = known_axes(3, 2);
  axes.rung = [axes](std::size_t f, std::size_t m) {
    Rung r = axes.rung(f, m);
    r.run = [f](const Case&, double, double, double) {
      Trajectory t;
      t.truth.touch = std::array{0.0100, 0.0101, 0.0130}[f];
      return t;
    };
    return r;
  };
  const WantedTimes wanted{0.05, unwanted, unwanted};
  const auto all = look_at_all(axes, at(0), wanted, 0.08, no_clock);
  CHECK(all[0].by_time[0] == Reached::not_met);
  CHECK(all[2].by_time[0] == Reached::not_met);
  // without the highest: what is below agrees, and proves nothing
  SceneAxes two = axes;
  two.fields.pop_back();
  const auto foretold = look_at_all(two, at(0), wanted, 0.08, no_clock);
  CHECK(foretold[2].fields.below[0] == Approx(1e-4).margin(1e-9));
  CHECK(foretold[2].by_time[0] == Reached::not_known);
  CHECK(foretold[3].by_time[0] == Reached::not_known);
  CHECK(foretold[0].by_time[0] == Reached::met);  // nobody has said that there are others
  two.fields_left_out = "field2";
  const auto told = look_at_all(two, at(0), wanted, 0.08, no_clock);
  CHECK(told[0].by_time[0] == Reached::not_known);
  REQUIRE_FALSE(told[0].unknown.empty());
  CHECK_THAT(told[0].unknown.front(), Catch::Contains("field2 is left out"));
}

TEST_CASE("bending that matters with other fields alone is part of the total", "[scene]") {
  // with field0 the mechanics agree; with field1 the finer ones are 2 ms later, and so is the best pair
  SceneAxes axes = known_axes(2, 2);
  axes.rung = [axes](std::size_t f, std::size_t m) {
    Rung r = axes.rung(f, m);
    r.run = [f, m](const Case&, double, double, double) {
      Trajectory t;
      t.truth.touch = f == 1 && m == 1 ? 0.012 : 0.010;
      return t;
    };
    return r;
  };
  const auto all = look_at_all(axes, at(0), {0.05, unwanted, unwanted}, 0.08, no_clock);
  CHECK(all[0].to_best[0] == Approx(2e-3));
  CHECK(all[0].model_error[0] == Approx(2e-3));
  CHECK(all[0].by_time[0] == Reached::not_met);
  CHECK(std::isnan(all[3].to_best[0]));
  // a choice does not call it met either
  const auto chosen = choose_scene(axes, at(0), {0.05, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(chosen.steps.front().reached == Reached::not_met);
  CHECK(chosen.rung.name() == "field1+mechanics1");
  // a measurement beside the only fields there are: nothing to climb to
  SceneAxes only = known_axes(1, 1);
  only.measured = {0.02, unwanted, unwanted};
  const auto one = choose_scene(only, at(0), {0.05, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(one.reached() == Reached::not_met);
  CHECK(one.steps.size() == 1);
}

TEST_CASE("the distance to a finer rung contains the error of the step, which is not added again",
          "[scene]") {
  // all rungs have one truth; the first one's two steps are off by 1 and 0.1 ms
  SceneAxes axes = known_axes(2, 2);
  axes.rung = [axes](std::size_t f, std::size_t m) {
    Rung r = axes.rung(f, m);
    const double per_tolerance = f + m == 0 ? 10 : 0;
    r.run = [per_tolerance](const Case&, double, double tolerance, double) {
      Trajectory t;
      t.truth.touch = 0.010 + per_tolerance * tolerance;
      return t;
    };
    r.settings = {1e-4, 1e-5};
    return r;
  };
  const auto all = look_at_all(axes, at(0), {0.2, unwanted, unwanted}, 0.08, no_clock);
  REQUIRE(all.front().step_error[0] == Approx(estimator_factor * 0.9e-3));
  CHECK(all.front().model_error[0] ==
        Approx(2e-3).epsilon(0.01));              // 1 ms to the next fields, 1 ms to the next mechanics
  CHECK(all.front().by_time[0] == Reached::met);  // 20 % of 11 ms
  // without anything to compare with, the step is what is known
  const auto alone = look_at_all(known_axes(1, 1), at(0), {1e-9, unwanted, unwanted}, 0.08, no_clock);
  CHECK(alone.front().share == Approx(alone.front().step_error[0] / (1e-9 * alone.front().run.times[0])));
}

TEST_CASE("a run that its guards stop is not computable, and stops nothing else", "[scene]") {
  // mechanics1 stops at every step, or at its coarsest alone
  for (const double stops_from : {0.0, 5e-5}) {
    SceneAxes axes = known_axes(1, 2);
    axes.rung = [axes, stops_from](std::size_t f, std::size_t m) {
      Rung r = axes.rung(f, m);
      if (m == 1)
        r.run = [run = r.run, stops_from](const Case& c, double duration, double tolerance, double dt) {
          if (tolerance > stops_from) throw std::runtime_error("energy residual");
          return run(c, duration, tolerance, dt);
        };
      return r;
    };
    const auto all = look_at_all(axes, at(0), {0.06, unwanted, unwanted}, 0.08, no_clock);
    REQUIRE(all.size() == 2);
    const bool never = stops_from == 0;
    CHECK(all[0].stopped.empty());
    CHECK(std::isnan(all[0].mechanics.above[0]) == never);
    CHECK(all[1].stopped == (never ? "energy residual" : ""));
    CHECK(std::isnan(all[1].run.times[0]) == never);
    CHECK(std::isnan(all[1].step_error[0]) == never);
    CHECK(all[1].by_time[0] == Reached::not_known);
    if (never)
      CHECK(all[1].unknown == std::vector<std::string>{"touch: not computable, energy residual"});
    else
      CHECK(all[1].run.tolerance < 5e-5);
  }
}

TEST_CASE("an unknown error is no zero: met, not met and not known are three answers", "[scene]") {
  const auto only = choose_scene(known_axes(1, 1), at(0), {0.01, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(only.reached() == Reached::not_known);
  CHECK(only.steps.back().unknown ==
        std::vector<std::string>{"touch: error of the fields, nothing to compare field0 with",
                                 "touch: error of the mechanics, nothing to compare mechanics0 with"});
  // the fields are known to be too far off: no unknown of the mechanics mends that
  SceneAxes apart = known_axes(2, 1);
  const auto one = choose_scene(apart, at(0), {0.01, unwanted, unwanted}, 0.08, {}, no_clock);
  REQUIRE(one.steps.size() == 2);
  CHECK(one.steps[0].reached == Reached::not_met);
  CHECK(one.reached() == Reached::not_known);  // at the top of the fields: 900 us below, and 2 us of its step
  CHECK_THAT(one.steps[1].unknown.front(), Catch::Contains("differs by 902 us"));
  // at the top, the step from below stands for the error where it is small enough
  const auto top = choose_scene(known_axes(3, 2), at(0), {0.06, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(top.reached() == Reached::met);
  const auto higher = choose_scene(known_axes(3, 2), at(0), {0.012, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(higher.rung.name() == "field1+mechanics1");
  CHECK(higher.reached() == Reached::not_known);
  // a closing that does not happen has no error either
  SceneAxes still = known_axes(2, 2);
  still.rung = [](std::size_t, std::size_t) {
    return Rung{"f", "m", "no touch", [](const Case&, double, double, double) { return Trajectory{}; }};
  };
  const auto none = choose_scene(still, at(0), {0.01, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(none.reached() == Reached::not_known);
  CHECK(none.steps.back().unknown == std::vector<std::string>{"touch: does not happen"});
}

TEST_CASE("a single rung is refined by its step alone, and says when that is not enough", "[scene]") {
  const auto fine = choose_scene(known_axes(1, 1), at(0), {1e-6, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(fine.steps.back().share <= 1);
  CHECK(fine.setting < 1e-6);
  SceneAxes fixed = known_axes(1, 1);
  const auto make = fixed.rung;
  fixed.rung = [make](std::size_t f, std::size_t m) {
    Rung r = make(f, m);
    r.setting = "cell mm";
    r.settings = {6, 4};
    return r;
  };
  const auto coarse = choose_scene(fixed, at(0), {0.01, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(coarse.reached() == Reached::not_met);
  CHECK(coarse.setting == 6);
  CHECK(coarse.steps.back().setting_name == "cell mm");
}

TEST_CASE("every pair is looked at, and each time has a verdict of its own", "[scene]") {
  std::size_t counted = 0;
  const auto all = look_at_all(known_axes(3, 2), at(0), {0.06, 0.06, unwanted}, 0.08, no_clock,
                               [&](std::size_t done) { counted = done; });
  REQUIRE(all.size() == 6);
  CHECK(counted == 6);
  CHECK(all[0].name == "field0+mechanics0");
  CHECK(all[1].name == "field0+mechanics1");
  // touch: 9e-4 + 3.6e-4 s of 0.06 * 11.4 ms; seat: equal on all rungs
  CHECK(all[0].by_time[0] == Reached::not_met);
  CHECK(all[0].by_time[1] == Reached::met);
  CHECK(all[0].by_time[2] == Reached::not_known);  // not wanted
  CHECK(all[0].reached == Reached::not_met);
  CHECK(all[2].reached == Reached::met);
  // as the choice judges the same pair
  const auto one = choose_scene(known_axes(3, 2), at(0), {0.06, 0.06, unwanted}, 0.08, {}, no_clock);
  CHECK(one.steps.back().name == all[2].name);
  CHECK(one.steps.back().model_error[0] == all[2].model_error[0]);
  // a measurement counts where it says more than the next rung, and where there is none
  SceneAxes measured = known_axes(2, 1);
  measured.measured = {0.0114 + 2e-3, unwanted, unwanted};
  measured.held_out_error = {unwanted, 5e-5, unwanted};
  const auto told_by = look_at_all(measured, at(0), {0.06, 0.06, unwanted}, 0.08, no_clock);
  CHECK(told_by[0].fields.above[0] == Approx(2e-3).margin(2e-6));
  CHECK(told_by[0].fields.above[1] == 5e-5);
  CHECK(std::isnan(told_by[1].fields.above[0]));  // of the first fields alone
  CHECK_THROWS_AS(look_at_all({}, at(0), {0.1, unwanted, unwanted}, 0.08, no_clock), std::invalid_argument);
}

TEST_CASE("bad wishes are refused", "[scene]") {
  CHECK_THROWS_AS(choose_scene(known_axes(1, 1), at(0), {unwanted, unwanted, unwanted}, 0.08, {}, no_clock),
                  std::invalid_argument);
  CHECK_THROWS_AS(choose_scene(known_axes(1, 1), at(0), {0.9, unwanted, unwanted}, 0.08, {}, no_clock),
                  std::invalid_argument);
  CHECK_THROWS_AS(choose_scene({}, at(0), {0.1, unwanted, unwanted}, 0.08, {}, no_clock),
                  std::invalid_argument);
  CHECK_THROWS_WITH(scene_rung(circuit_field(), "elastic"),
                    Catch::Contains("plant, rigid, modal, deformable"));
  const auto table = pure_field("table", "a table", std::make_shared<SpecimenPotential>(Specimen{}));
  CHECK_THROWS_WITH(scene_rung(table, "plant"), Catch::Contains("take rigid"));
}

TEST_CASE("the same circuit behind every mechanics: touch and seat agree, bending moves the settled time",
          "[scene]") {
  const Case c = at(60);
  const auto field = pure_field("again", "the circuit", std::make_shared<SpecimenPotential>(c.specimen));
  const std::vector<Rung> rungs{scene_rung(circuit_field(), "plant"), scene_rung(circuit_field(), "rigid"),
                                scene_rung(field, "rigid"), scene_rung(circuit_field(), "modal")};
  const auto plant = run_rung(rungs, 0, c, 0.03, 1e-10, no_clock);
  CHECK(largest(time_error(run_rung(rungs, 1, c, 0.03, 1e-10, no_clock), plant)) < 1e-8);
  CHECK(time_error(run_rung(rungs, 2, c, 0.03, 1e-10, no_clock), plant)[1] < 1e-8);
  const auto modal = time_error(run_rung(rungs, 3, c, 0.03, 0.4, no_clock), plant);
  CHECK(modal[0] < 1e-6);
  CHECK(modal[1] < 10e-6);
  CHECK(modal[2] > 10e-6);
}

TEST_CASE("plane finite elements solved at every step are the table they would fill", "[scene][.slow]") {
  Case c = at(60);
  const MagnetDesign design = magnet_design(c.specimen);
  TableOptions options;
  options.accuracy = 0.02;
  options.largest_gap = 1.5 * c.specimen.core.travel;
  Team team(2);
  const auto table =
      pure_field("table", "table", std::make_shared<TablePotential>(build_table(design, options, team)));
  const auto live = solved_field(design, plan_table(design, options).field);
  const std::vector<Rung> rungs{scene_rung(table, "rigid"), scene_rung(live, "rigid")};
  const auto a = run_rung(rungs, 0, c, 0.014, 1e-4, no_clock);
  const auto b = run_rung(rungs, 1, c, 0.014, 1e-4, no_clock);
  CHECK(time_error(a, b)[0] < 0.005 * b.times[0]);
  CHECK(time_error(a, b)[0] > 0);  // the interpolation is there
}

TEST_CASE("three errors: step, model and input, and an unknown one is no number") {
  // every rung: 1 ms of touch for 100 % of the voltage
  SceneAxes axes = known_axes(3, 2);
  const auto inner = axes.rung;
  axes.rung = [inner](std::size_t f, std::size_t m) {
    Rung r = inner(f, m);
    const auto run = r.run;
    r.run = [run](const Case& c, double duration, double tolerance, double dt) {
      Trajectory t = run(c, duration, tolerance, dt);
      if (t.truth.touch) *t.truth.touch += 1e-3 * (c.conditions.supply_volts / 230 - 1);
      return t;
    };
    return r;
  };
  const InputUncertainty volts[] = {{"supply_volts", 2.3}, {"ambient_degC", 2}};
  const auto c = choose_scene(axes, at(0), {0.06, unwanted, unwanted}, 0.08, volts, no_clock);
  CHECK(c.input_error[0] == Approx(1e-5).epsilon(1e-6));  // 1 % of 1 ms; temperature moves nothing
  const auto& last = c.steps.back();
  const auto stand = [&](const AxisError& e) { return std::isnan(e.above[0]) ? e.below[0] : e.above[0]; };
  CHECK(last.model_error[0] == Approx(stand(last.fields) + stand(last.mechanics)));
  // nothing to compare with, no input stated: not known, never zero
  const auto alone = choose_scene(known_axes(1, 1), at(0), {0.06, unwanted, unwanted}, 0.08, {}, no_clock);
  CHECK(std::isnan(alone.steps.back().model_error[0]));
  CHECK(std::isnan(alone.input_error[0]));
  CHECK(alone.reached() == Reached::not_known);
}
