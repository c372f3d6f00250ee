// What is said about the bounces of a closing: error, condition, ensemble.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/mechanics/reference_closing.h"
#include "core/units.h"
#include "sim/mechanics/bounce_study.h"
#include "sim/models/rigid_closing.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

BounceRun contactor(double stiffness, double end) {
  return [=](double tolerance, const Factor& factor) {
    RigidOptions o;
    o.tolerance = tolerance;
    o.ledger = false;
    o.end = end;
    return run_rigid(varied(powbench::bench::reference_closing(stiffness), factor), {}, o).events;
  };
}

}  // namespace

TEST_CASE("a computable sequence gets an error and a condition, and no ensemble", "[mechanics]") {
  BounceStudyOptions o;
  o.tolerance = 1e-9;
  o.end = 0.06;
  const auto s = study_bounces(contactor(1, o.end), o);
  std::printf("  reference closing: %d/%d, largest dt %.1e s, condition %.3g s, computable %d\n",
              s.error.matched, s.error.reference, s.error.largest_dt, s.condition.per_input, s.computable);
  CHECK(s.computable);
  CHECK(s.error.reference == 170);
  CHECK(s.error.largest_dt < 1e-7);
  CHECK(s.condition.per_input > 1e-3);
  CHECK(s.ensemble.runs == 0);
}

TEST_CASE("a sequence that is not computable gets an ensemble of 64 runs", "[mechanics]") {
  BounceStudyOptions o;
  o.tolerance = 1e-6;
  o.truth = 1e-8;
  o.end = 0.034;
  const auto s = study_bounces(contactor(100, o.end), o);
  CHECK_FALSE(s.computable);
  REQUIRE(s.ensemble.runs == 64);
  const auto& e = s.ensemble;
  std::printf("  k x 100: first touch %.4f ms (%.4f .. %.4f), open %.3f ms (%.3f .. %.3f)\n",
              e.first_touch.mean * 1e3, e.first_touch.low * 1e3, e.first_touch.high * 1e3,
              e.open_time.mean * 1e3, e.open_time.low * 1e3, e.open_time.high * 1e3);
  CHECK(e.first_touch.high - e.first_touch.low < 2e-6);
  CHECK(e.open_time.high - e.open_time.low > 2e-6);
  CHECK(e.first_touch.low <= e.first_touch.median);
  CHECK(e.last_closing.mean > e.first_touch.mean);
  // the same seed gives the same ensemble
  CHECK(bounce_ensemble(contactor(100, o.end), o).open_time.mean == e.open_time.mean);
}

TEST_CASE("the first plant and the rigid rung get the same bounce error and condition", "[mechanics]") {
  Conditions c;
  c.closing_angle = radians(60.0);
  BounceStudyOptions o;
  o.tolerance = 1e-9;
  const auto study = [&](bool rigid) {
    return study_bounces(
        [&](double tolerance, const Factor& factor) {
          const auto s = varied(Specimen{}, factor);
          const auto t =
              rigid ? simulate_rigid(s, c, o.end, 0, tolerance, false) : simulate(s, c, o.end, 0, tolerance);
          return contact_events(t.events);
        },
        o);
  };
  const auto plant = study(false);
  const auto rigid = study(true);
  CHECK(plant.error.reference > 10);
  CHECK(plant.error.reference == rigid.error.reference);
  CHECK(plant.computable);
  CHECK(rigid.computable);
  CHECK(rigid.condition.per_input == Approx(plant.condition.per_input).epsilon(0.05));
}

TEST_CASE("bounce studies refuse impossible options", "[mechanics]") {
  const auto run = contactor(1, 0.01);
  BounceStudyOptions o;
  o.runs = 10;
  CHECK_THROWS_WITH(study_bounces(run, o), "runs: allowed 64 and above");
  o = {};
  o.truth = o.tolerance;
  CHECK_THROWS_WITH(study_bounces(run, o), "truth: allowed below tolerance");
  o = {};
  o.change = 0.5;
  CHECK_THROWS_WITH(study_bounces(run, o), "change: allowed above 0 .. 0.01");
}
