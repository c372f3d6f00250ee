// A fit through another model than the plant: the same numbers where both are one physics, and devices that the plant
// cannot be.

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "sim/models/mechanics.h"
#include "sim/study/closings_in_lanes.h"
#include "sim/study/posterior.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

ClosingModel rigid_model() {
  return closing_model(closing_rungs().back());
}

/// Closings of `device` at four angles as `model` has them, worth 20 us each.
FitProblem problem_of(const Specimen& device, const ClosingModel& model) {
  FitProblem p;
  p.base = device;
  p.model = model;
  p.parameters = {parameter("core.mass_g", 170, 220), parameter("core.return_preload_N", 8, 10.5)};
  p.prior_deviation = p.edge = 0;
  for (const double deg : {20.0, 60.0, 110.0, 160.0}) {
    MeasuredClosing m;
    m.conditions.closing_angle = radians(deg);
    const auto t = model.run(device, m.conditions, p.duration, 1e-7);
    REQUIRE((t.touch && t.core_seat && t.settled));
    m.touch = {*t.touch, 20e-6};
    m.seat = {*t.core_seat, 20e-6};
    m.bounce = {*t.settled - *t.touch, 1e-3};
    p.closings.push_back(m);
  }
  return p;
}

}  // namespace

TEST_CASE("the misfit through the rigid rung is that through the plant, at one point and at many",
          "[study]") {
  const FitProblem rigid = problem_of({}, rigid_model());
  FitProblem plant = rigid;
  plant.model = {};
  const Misfit a(rigid), b(plant);
  const std::vector<std::vector<double>> points{{0.5, 0.5}, {0.2, 0.7}, {0.9, 0.1}};
  const std::vector<double> give_up(points.size(), 1e300);
  Team one(1), two(2);
  const auto of_rigid = a.values(points, give_up, two), of_plant = b.values(points, give_up, one);
  CHECK(of_rigid == a.values(points, give_up, one));
  const auto rows = a.residuals(points, 1e-7, two), plain = b.residuals(points, 1e-7, one);
  for (std::size_t k = 0; k < points.size(); ++k) {
    CHECK(of_rigid[k] == a.value(points[k]));
    CHECK(std::sqrt(of_rigid[k]) == Approx(std::sqrt(of_plant[k])).epsilon(0.02));  // steps of 1e-4
    REQUIRE(rows[k].size() == plain[k].size());
    for (std::size_t i = 0; i < rows[k].size(); ++i) CHECK(rows[k][i] == Approx(plain[k][i]).margin(0.01));
  }
}

TEST_CASE("a device of another contact law is found by the model that knows it; to the plant it never closes",
          "[study]") {
  Specimen device;
  device.bridges.contact_exponent = 1.5;
  device.core.mass *= 0.93;
  FitProblem p = problem_of(device, rigid_model());
  Team team(2);
  const auto found =
      sample_posterior(Misfit(p), {.evaluations = 60, .starts = 1, .further_starts = 0, .samples = 4}, team,
                       [](double, double) { return true; });
  REQUIRE_FALSE(found.stopped);
  CHECK(found.misfit < 0.1);
  for (const auto& point : found.samples)
    CHECK(Misfit(p).specimen(point).core.mass == Approx(device.core.mass).epsilon(0.02));
  p.model = {};
  CHECK(Misfit(p).value({{0.5, 0.5}}) > 1e3);
}
