#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "host/compare/compare.h"
#include "host/report/number.h"
#include "host/report/report.h"

/// What page 1 says beside its numbers: why a verdict is what it is, what a simulation is of, what no U holds.

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

Events closing(double touch, double reached_deg) {
  Events e;
  e.contact_voltage.present = true;
  Contact c;
  c.touch = {touch, 2e-6};
  e.contact_voltage.contacts = {c};
  e.contact_voltage.settled = c.touch;
  e.contact_voltage.bounce_time = {1e-3, 3e-6};
  e.core.seat = {touch + 2e-3, 10e-6};
  e.coil.closing_angle = {radians(reached_deg), radians(0.02)};
  return e;
}

ReportInput campaign(std::initializer_list<double> reached) {
  ReportInput in;
  in.campaign = "pages";
  in.planned = reached.size();
  in.angle_tolerance = radians(1.5);
  for (const double angle : reached) {
    ReportShot s;
    s.index = static_cast<int>(in.shots.size()) + 11;
    s.conditions.closing_angle = radians(60);
    s.conditions.seed = 0xabc123;
    s.events = closing(12e-3, angle);
    s.outcome = Outcome::not_judged;
    if (std::fabs(angle - 60) > 1.5) {
      s.events->coil.flags |= flag_angle_off;
      s.outcome = Outcome::fail;
      s.reason = "closing angle " + std::to_string(static_cast<int>(angle)) + " deg, commanded 60 deg";
    }
    in.shots.push_back(s);
  }
  return in;
}

std::string page(ReportInput in) {
  std::vector<AngleGroup> groups;
  for (const auto& s : in.shots)
    group_at(groups, effective_angle(s.conditions)).measured.push_back(*s.events);
  for (const auto& s : in.simulated) group_at(groups, s.closing_angle).simulated.push_back(s.events);
  in.comparison = compare(groups, {}, in.limits);
  return render_html(in);
}

}  // namespace

TEST_CASE("a FAIL by the closing angle says so on page 1, with the shot and the limit", "[report]") {
  const std::string off = page(campaign({60.1, 63, 64, 57}));
  CHECK_THAT(off, Contains("Why: shot 12: closing angle 63 deg, commanded 60 deg (and 2 more)."));
  CHECK_THAT(off, Contains("closing angle reached, less the one asked for"));
  CHECK_THAT(off, Contains(" shots 12, 13, 14"));
  CHECK_THAT(off, Contains("+4.00\xC2\xB0"));
  CHECK_THAT(off, !Contains("so nothing was judged"));
  CHECK_THAT(off, !Contains("Behaviour over the closing angle"));  // there is one
  const std::string kept = page(campaign({60.1, 59.9}));
  CHECK_THAT(kept, Contains("kept by all 2"));
  CHECK_THAT(kept, !Contains("Why:"));
  CHECK_THAT(kept, !Contains("badge pass"));  // not judged is never green
}

TEST_CASE("who stopped a campaign stands on page 1 and in JUnit, its course beside the provenance",
          "[report]") {
  ReportInput in = campaign({60.1, 60.2});
  in.planned = 4;
  in.course = {{"2030-12-30T09:00:00Z", "stopped by the operator, 1 of 4 shots recorded"},
               {"2030-12-31T10:20:30Z", "stopped because the rig did not come back, 2 of 4 shots recorded"}};
  const std::string html = page(in);
  CHECK_THAT(html,
             Contains("Why: stopped because the rig did not come back, 2 of 4 shots recorded (2030-12-31 "
                      "10:20:30 UTC)."));
  CHECK_THAT(html,
             Contains("2030-12-30 09:00:00 UTC: stopped by the operator, 1 of 4 shots recorded; 2030-12-31"));
  CHECK_THAT(render_junit(in), Contains("2 of 4 planned shots fired; stopped because the rig"));
  in.course.push_back({"2030-12-31T11:00:00Z", "gone on with, 2 of 4 shots recorded before"});
  CHECK_THAT(page(in),
             Contains("Why: gone on with, 2 of 4 shots recorded before (2030-12-31 11:00:00 UTC); how that "
                      "ended is not noted."));
  in.course.clear();
  CHECK_THAT(page(in), !Contains("Why:") && !Contains("Course"));
}

TEST_CASE("an instrument whose calibration had expired is skipped in JUnit, never passed", "[report]") {
  ReportInput in = campaign({60.1});
  in.provenance.started = "2030-12-31T10:20:30Z";
  CHECK_THAT(render_junit(in), !Contains("calibrations of the instruments"));
  in.test.instruments = {"laser LK-2; L-9; 2030-12-31"};
  CHECK_THAT(render_junit(in), Contains("calibrations of the instruments in force\"></testcase>") ||
                                   Contains("calibrations of the instruments in force\"/>"));
  in.test.instruments = {"laser LK-2; L-9; 2030-12-30"};
  CHECK_THAT(
      render_junit(in),
      Contains("<skipped message=\"expired: laser LK-2, certificate L-9, was valid until 2030-12-30\""));
  in.test.instruments = {"charge amplifier; K-1", "laser LK-2; L-9; 2030-12-31"};
  CHECK_THAT(render_junit(in),
             Contains("<skipped message=\"validity not stated: charge amplifier, certificate K-1\""));
  in.test.instruments = {"laser LK-2; L-9; 2030-12-30"};
  in.origin = Origin::import;
  CHECK(expired_then(in).empty());
  CHECK_THAT(render_junit(in), Contains("<skipped message=\"when the records were taken is not known\""));
}

TEST_CASE("each calibration is judged at the last day on which a shot was fired under it", "[report]") {
  ReportInput in = campaign({60.1, 60.2, 59.9});
  in.provenance.started = "2030-12-30T10:20:30Z";
  in.provenance.finished = "2031-01-05T10:20:30Z";
  in.provenance.calibrations = {{"LAB-1", "11", "2030-12-30"}, {"LAB-2", "12, 13", "2031-01-05"}};
  in.test.instruments = {"rig; LAB-1; 2030-12-31", "rig; LAB-2; 2031-12-31", "laser; L-9; 2031-12-31"};
  CHECK_THAT(page(in),
             Contains("<dd>LAB-1 (shot 11), LAB-2 (shots 12, 13)</dd>") && !Contains("Calibration expired"));
  CHECK_THAT(render_junit(in), !Contains("was valid until") && !Contains("validity not stated"));
  in.test.instruments[2] = "laser; L-9; 2031-01-04";
  CHECK_THAT(page(in),
             Contains("laser, certificate L-9, was valid until 2031-01-04; used until 2031-01-05."));
  in.test.instruments = {"rig; LAB-1; 2030-12-31"};  // nobody noted the other
  CHECK_THAT(render_junit(in),
             Contains("<skipped message=\"validity not stated: calibration LAB-2 of shots 12, 13\""));
}

TEST_CASE("shots that were fired again are counted with how they had ended", "[report]") {
  ReportInput in = campaign({60.1, 60.2, 59.9});
  CHECK_THAT(page(in), !Contains("fired again"));
  in.shots[1].earlier = {Outcome::error};
  CHECK_THAT(page(in), Contains("1 shot was fired again after an error: 12 (ERROR)."));
  in.shots[2].earlier = {Outcome::timeout, Outcome::error};
  CHECK_THAT(page(in), Contains("2 shots were fired again after an error: 12 (ERROR), 13 (TIMEOUT, ERROR)."));
}

TEST_CASE("the k of U is told, and each time in the list of shots has its U", "[report]") {
  const std::string html = page(campaign({60.1, 60.2}));
  CHECK_THAT(html, Contains("k by their degrees of freedom, here "));
  CHECK_THAT(html, Contains("<td class=\"nowrap\">12.0000 \xC2\xB1 0.0040</td>"));
}

TEST_CASE("a simulation of other conditions than the closings had says so on page 1", "[report]") {
  ReportInput in = campaign({60.1, 60.2});
  in.simulated.push_back({radians(60), closing(12.1e-3, 60), {}});
  CHECK_THAT(page(in), !Contains("asks for, not those of the closings") && !Contains("older than closings"));
  in.simulated[0].nominal = true;
  CHECK_THAT(page(in),
             Contains("Simulated at the conditions that the plan asks for, not those of the closings"));
  in.simulated[0].nominal = false;
  in.simulated[0].outdated = true;
  CHECK_THAT(page(in), Contains("1 of 1 simulations is older than closings of its angle"));
}

TEST_CASE("records without a valid calibration say so beside their U", "[report]") {
  ReportInput in = campaign({60.1, 60.2});
  CHECK_THAT(page(in), !Contains("No valid calibration"));
  in.shots[0].events->flags |= flag_no_calibration;
  CHECK_THAT(page(in), Contains("No valid calibration for 1 of 2 records"));
  in.shots[1].events->flags |= flag_no_calibration;
  CHECK_THAT(page(in), Contains("No valid calibration for these records"));
}

TEST_CASE("an import has no seed, and its angle may be unknown", "[report]") {
  ReportInput in = campaign({60.1});
  CHECK_THAT(page(in), Contains("abc123"));
  in.origin = Origin::import;
  CHECK_THAT(page(in), !Contains("abc123"));
  CHECK(at_angle(radians(359.999)) == "at 0\xC2\xB0");
  CHECK(at_angle(radians(60)) == "at 60\xC2\xB0");
  CHECK(at_angle(std::nan("")) == "at an angle not known");
  CHECK(range_of(12.371, 12.373, 2) == "12.37");
  CHECK(range_of(12.371, 12.383, 2) == "12.37 to 12.38");
}

TEST_CASE("guarded acceptance holds for the closing angle too", "[report]") {
  const double tolerance = radians(0.1);
  const auto judged = [&](double off_deg, double u_deg, Decision rule) {
    return judge_angle({radians(360 + off_deg), radians(u_deg)}, radians(0), tolerance, rule);
  };
  CHECK(judged(0.046, 0.037, Decision::simple) == Outcome::pass);
  CHECK(judged(0.046, 0.037, Decision::guarded) == Outcome::fail);
  CHECK(judged(-0.046, 0.02, Decision::guarded) == Outcome::pass);
  CHECK(judged(-0.12, 0.001, Decision::simple) == Outcome::fail);
  CHECK(judge_angle({}, 0, tolerance, Decision::simple) == Outcome::not_observed);
  ReportInput in = campaign({60.1});
  in.angle_tolerance = radians(0.12);
  CHECK_THAT(page(in), Contains("kept"));
  in.decision = Decision::guarded;
  CHECK_THAT(page(in), Contains(" shot 11"));
}

TEST_CASE("an import names its source and its calibration by the day of the record", "[report]") {
  ReportInput in = campaign({60.1});
  in.origin = Origin::import;
  in.shots[0].events->flags |= flag_no_calibration;
  CHECK_THAT(page(in), Contains("What they were taken from is not said."));
  in.test.source = "SIMULATED RIG, measured shot 1 of campaign 1";
  CHECK_THAT(page(in), Contains("Taken from: SIMULATED RIG, measured shot 1 of campaign 1."));
  in.test.instruments = {std::string(waveform_calibration) + "; films 3; 2026-03-01"};
  in.test.recorded = "2026-05-04";
  CHECK_THAT(page(in), Contains("Calibration expired: " + std::string(waveform_calibration)));
  CHECK_THAT(page(in), Contains("No valid calibration"));
  in.test.recorded = "2026-02-04";
  CHECK_THAT(page(in), !Contains("Calibration expired") && !Contains("No valid calibration"));
}

TEST_CASE("a limit and what was measured read on the sides on which they are", "[report]") {
  ReportInput in = campaign({60.1});
  in.shots[0].events = closing(12.004e-3, 60.1);
  in.limits = {{"t_ct1", std::nan(""), 12e-3}};
  in.shots[0].outcome = Outcome::fail;
  CHECK_THAT(page(in), Contains("12.004 ms"));
}

TEST_CASE("every page on paper says what it is of", "[report]") {
  ReportInput in = campaign({60.1});
  in.campaign = "a \"}</style> b";
  in.origin = Origin::simulated_rig;
  CHECK_THAT(page(in), Contains("content: \"a \\22 \\7d \\3c /style\\3e  b, SIMULATED RIG, \""));
}

TEST_CASE("a difference to one side at every angle is told, whether within U or not", "[report]") {
  ReportInput in;
  in.campaign = "bias";
  in.planned = 6;
  for (int i = 0; i < 6; ++i) {
    ReportShot s;
    s.index = i + 1;
    s.conditions.closing_angle = radians(20.0 * i);
    s.events = closing(12e-3, 20.0 * i);
    in.shots.push_back(s);
    in.simulated.push_back({radians(20.0 * i), closing(11.4e-3, 20.0 * i), {}});
  }
  CHECK_THAT(page(in), Contains("t_ct1 is simulated lower at all 6 angles, by 0.60 ms on average."));
  in.simulated[3].events = closing(12.1e-3, 60);
  CHECK_THAT(page(in), !Contains("t_ct1 is simulated lower"));
}

TEST_CASE("of more differences than page 1 lists it tells how many there are", "[report]") {
  ReportInput in;
  in.campaign = "many";
  in.planned = 4;
  for (int i = 0; i < 4; ++i) {
    ReportShot s;
    s.index = i + 1;
    s.conditions.closing_angle = radians(20.0 * i);
    s.events = closing(12e-3, 20.0 * i);
    in.shots.push_back(s);
    in.simulated.push_back({radians(20.0 * i), closing(15e-3, 20.0 * i), {}});
  }
  CHECK_THAT(page(in), Contains("The 5 largest; "));
}
