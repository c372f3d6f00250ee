// What stands beside a held-out value: the same angle, and what was known of the others.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "host/study/fit_text.h"
#include "sim/models/closing.h"
#include "sim/study/parameter.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

/// Touches of 10, 12, 20 and 30 ms at 0, 30, 60 and 90 degrees.
std::vector<sim::MeasuredClosing> four_angles() {
  std::vector<sim::MeasuredClosing> list;
  for (const double touch : {10e-3, 12e-3, 20e-3, 30e-3}) {
    sim::MeasuredClosing m;
    m.conditions.closing_angle = radians(30.0 * static_cast<double>(list.size()));
    m.touch = {touch, 1e-4};
    m.seat = {touch + 2e-3, 1e-4};
    m.bounce = {5e-3, 1e-4};
    list.push_back(m);
  }
  return list;
}

}  // namespace

TEST_CASE(
    "an angle that no fit has seen is not fitted, is no one's neighbour, and is judged against the others",
    "[study]") {
  FitJob job;
  job.problem.parameters = {sim::parameter("core.mass_g", 100, 160)};
  job.problem.closings = four_angles();
  FitReport report;
  report.file.names = {"core.mass_g"};
  report.file.folds = {{60.0, 1, {{130}}, {}}, {{}, 1, {{130}}, {}}};
  const std::vector<double> unseen{radians(60)};
  const auto cells = fit_cells(report.file, four_angles(), unseen);
  const auto touch = [&](double theta) {
    for (const auto& c : cells)
      if (c.quantity == "t_ct1" && c.theta_deg == Approx(theta)) return c;
    FAIL("no cell");
    return FitCell{};
  };
  CHECK(std::isnan(touch(60).fitted));
  CHECK(std::isfinite(touch(60).held_out.median));
  CHECK(std::isfinite(touch(0).fitted));
  CHECK(touch(60).others_percent == Approx(100 * 8.0 / 20));   // median of 10, 12 and 30 ms
  CHECK(touch(90).others_percent == Approx(100 * 19.0 / 30));  // of 10 and 12: 20 is not known to anybody
  // the mean of the medians is over what is held out alone
  CHECK_THAT(fit_text(job, report, cells), Contains("40.00 / 40.00"));
  // nothing held out: every angle has its median
  report.file.folds.erase(report.file.folds.begin());
  const auto all = fit_cells(report.file, four_angles());
  CHECK(std::isfinite(all.front().fitted));
  CHECK_THAT(fit_text(job, report, all), !Contains("40.00 / 40.00"));
}
