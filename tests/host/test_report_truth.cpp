// What a lab signs: a verdict counts every limit, "agree" what one side alone has seen, times count from the step of
// the coil voltage, and a mean tells how many closings it is of.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/quantities.h"
#include "host/report/best_angle.h"
#include "tests/host/report_samples.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

constexpr double not_set = std::numeric_limits<double>::quiet_NaN();

SimulatedClosing simulation(double touch) {
  SimulatedClosing s;
  s.closing_angle = radians(30);
  s.events = some_events(touch);
  return s;
}

/// Two closings at 30 deg, a simulation of each of the given touches; a limit that both keep.
ReportInput campaign(std::initializer_list<double> simulated, double most, Decision rule = Decision::simple) {
  ReportInput in;
  in.campaign = "truth";
  in.planned = 2;
  in.shots = {some_shot(1), some_shot(2)};
  in.shots[1].events = some_events(12.1e-3);
  for (const double touch : simulated) in.simulated.push_back(simulation(touch));
  in.limits = {{"t_ct1", 0, 20e-3}};
  in.most_from_simulation = most;
  in.decision = rule;
  std::vector<AngleGroup> groups;
  for (const auto& s : in.shots)
    group_at(groups, effective_angle(s.conditions)).measured.push_back(*s.events);
  for (const auto& s : in.simulated) group_at(groups, s.closing_angle).simulated.push_back(s.events);
  in.comparison = compare(groups, {}, in.limits, rule, most);
  return in;
}

}  // namespace

TEST_CASE("the overtravel time is from the first touch to the seat, and needs both", "[report]") {
  const Quantity& overtravel = *find_quantity("t_ot");
  Events e = some_events(12e-3);
  e.core.seat = {14e-3, 30e-6};
  e.contact_voltage.contacts.front().touch = {12e-3, 40e-6};
  CHECK(overtravel.of(e).value == Approx(2e-3));
  CHECK(overtravel.of(e).u == Approx(50e-6));
  // a step of the coil voltage after time zero moves both instants, not what lies between them
  e.coil.switch_on = {1e-3, 1e-6};
  CHECK(overtravel.of(e).value == Approx(2e-3));
  Events unseated = e;
  unseated.core.seat = {};
  CHECK_FALSE(overtravel.of(unseated).known());
  e.contact_voltage.contacts.clear();
  CHECK_FALSE(overtravel.of(e).known());
}

TEST_CASE("a limit on the difference from the simulation that nothing was held against is no PASS",
          "[report]") {
  CHECK(verdict(campaign({}, not_set)) == Outcome::pass);
  const ReportInput unjudged = campaign({}, 0.01);
  CHECK(verdict(unjudged) == Outcome::not_judged);
  CHECK_THAT(render_html(unjudged), Contains("judged for 0 of"));
  CHECK_THAT(render_junit(unjudged), Contains("nothing simulated to compare with"));
  const ReportInput kept = campaign({12.05e-3}, 0.01);
  CHECK(verdict(kept) == Outcome::pass);
  CHECK_THAT(render_html(kept), Contains("\xE2\x89\xA4 1 %"));
  CHECK(verdict(campaign({12.5e-3}, 0.01)) == Outcome::fail);
}

TEST_CASE("a FAIL by a guarded difference names the U that made it one", "[report]") {
  // 0.2 % apart, which alone is allowed
  const std::string reason = verdict_reason(campaign({12.074e-3}, 0.01, Decision::guarded));
  CHECK_THAT(reason,
             Contains("differ by 0.2 %, with U = ") && Contains(" % more, allowed 1 % of the measured mean"));
  CHECK_THAT(verdict_reason(campaign({12.5e-3}, 0.01)), Contains("differ by 3.7 %, allowed 1 %"));
}

TEST_CASE("a simulation that never touches does not agree with closings that do", "[report]") {
  ReportInput in = campaign({12.05e-3}, not_set);
  CHECK_THAT(render_html(in), !Contains("measured and not simulated"));
  in.simulated[0].events.contact_voltage.contacts.clear();
  in.simulated[0].events.contact_voltage.settled = in.simulated[0].events.contact_voltage.bounce_time = {};
  compare_into(in);
  const std::string html = render_html(in);
  CHECK_THAT(html, Contains("t_ct1 at 30\xC2\xB0 is measured and not simulated"));
  CHECK_THAT(html, !Contains(">agree<"));
  CHECK_THAT(html, !Contains("Nowhere: "));
  // a channel that was not simulated has nothing to differ
  in.simulated[0].events.contact_voltage.present = false;
  compare_into(in);
  CHECK_THAT(render_html(in), !Contains("measured and not simulated"));
}

TEST_CASE("an angle at which a closing did not settle is not the best one", "[report]") {
  Comparison all;
  for (int k = 0; k < 3; ++k) {
    ComparisonRow row;
    row.quantity = "t_ct_bon";
    row.closing_angle = radians(30 * k);
    row.repeats = row.closings = 5;
    row.measured = {(6 - k) * 1e-3, 10e-6};
    row.dof = 4;
    row.coverage = 2.87;
    all.rows.push_back(row);
  }
  CHECK(degrees(best_angle(all).angle) == Approx(60));
  CHECK(best_angle(all).unsettled == 0);
  all.rows[2].repeats = 1;  // of five closings there, one settled
  const BestAngle best = best_angle(all);
  CHECK(degrees(best.angle) == Approx(30));
  CHECK(best.angles == 2);
  CHECK(best.unsettled == 1);
  // half the difference of two means of equal u: the effective degrees of freedom of both, 8
  CHECK(best.gain.value == Approx(0.5e-3));
  CHECK(best.gain.u == Approx(std::sqrt(0.5) * 10e-6));
  CHECK(best.gain_coverage == Approx(2.366).epsilon(1e-3));
}

TEST_CASE("times count from the step of the coil voltage where the record tells it from its zero",
          "[report]") {
  Events e = some_events(12e-3);
  const auto touch = [&] { return find_quantity("t_ct1")->of(e); };
  CHECK(touch().value == 12e-3);
  for (const double step : {2e-3, -3e-3}) {  // a relay; a record whose zero is the first touch
    e.coil.switch_on = {step, 1.5e-6};
    CHECK(touch().value == Approx(12e-3 - step));
    CHECK(touch().u == Approx(2.5e-6));
    CHECK(find_quantity("t_ct2")->of(e).value == Approx(15e-3 - step));
    CHECK(find_quantity("t_xt1")->of(e).value == Approx(14e-3 - step));
    CHECK(find_quantity("t_ct_bon")->of(e).value == 3e-3);
  }
  for (const Measured near : {Measured{15e-6, 1e-6}, Measured{200e-6, 80e-6}, Measured{}}) {
    e.coil.switch_on = near;
    CHECK(touch().value == 12e-3);
    CHECK(touch().u == 2e-6);
  }
}

TEST_CASE("without contact voltage the pole is closed while both breaks are", "[report]") {
  Events e;
  e.pvdf_a.present = true;
  e.pvdf_a.contacts.resize(1);
  e.pvdf_a.contacts[0].touch = {10e-3, 1e-6};
  CHECK(find_quantity("t_ct1")->of(e).value == 10e-3);
  e.pole.by_force.present = true;
  e.pole.by_force.contacts.resize(1);
  e.pole.by_force.contacts[0].touch = {12e-3, 1e-6};
  CHECK(find_quantity("t_ct1")->of(e).value == 12e-3);
}
