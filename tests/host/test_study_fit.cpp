#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "host/store/maintain.h"
#include "host/study/fit_file.h"
#include "host/study/fit_job.h"
#include "host/study/fit_point.h"
#include "host/study/fit_text.h"
#include "host/study/held_out.h"
#include "host/study/next_measurement.h"
#include "host/study/problem.h"
#include "sim/models/closing.h"
#include "tests/host/store_samples.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

/// A quick problem: two free numbers, closings of a device that is a little off.
FitJob small_job() {
  sim::Specimen device;
  device.coil.resistance *= 1.03;
  FitJob job;
  job.problem.parameters = {sim::parameter("coil.resistance_ohm", 220, 270),
                            sim::parameter("core.return_preload_N", 8, 10.5)};
  job.problem.prior_deviation = 0;
  job.problem.edge = 0;
  for (const double deg : {20.0, 110.0, 160.0, 60.0}) {
    sim::MeasuredClosing m;
    m.conditions.closing_angle = radians(deg);
    const auto t = sim::simulate(device, m.conditions, 0.05, 0, 1e-6).truth;
    m.touch = {*t.touch, 50e-6};
    m.seat = {*t.core_seat, 50e-6};
    m.bounce = {*t.settled - *t.touch, 0.5e-3};
    job.problem.closings.push_back(m);
  }
  job.held_out = {radians(110)};
  job.options.evaluations = 120;
  job.posterior.evaluations = 60;
  job.posterior.starts = 2;
  job.posterior.samples = 6;
  job.options.ensemble = 1;
  job.options.polished = 1;
  job.searches = 2;
  return job;
}

bool same(const sim::BounceCalibration& a, const sim::BounceCalibration& b) {
  return a.factors == b.factors && a.deviation == b.deviation && a.median == b.median &&
         a.median_deviation == b.median_deviation && a.line == b.line;
}

std::string hash(const std::string& store) {
  return check_store(store).hash;
}

bool always(std::size_t, std::size_t, long, long, double, const FitState&) {
  return true;
}

FitReport fits(const FitJob& job, sim::Team& team, const FitProgress& progress, const FitState& state = {}) {
  Points none;
  return run_fits(job, team, progress, state, none);
}

}  // namespace

TEST_CASE("published closings: six angles; the core row of 90 deg takes no part", "[study]") {
  const auto list = published_closings();
  REQUIRE(list.size() == 6);
  for (const auto& m : list) {
    CHECK(m.touch.known());
    CHECK(m.bounce.known());
    CHECK(m.seat.known() == (std::fabs(degrees(m.conditions.closing_angle) - 90) > 1));
  }
  CHECK(list[0].touch.value == Approx(11.86e-3));
  CHECK(list[5].bounce.value == Approx(8.55e-3));
  const double angle = radians(90);
  CHECK(without(list, std::span(&angle, 1)).size() == 5);
  const double turned = radians(90.005 - 360);
  CHECK(without(list, std::span(&turned, 1)).size() == 5);
}

TEST_CASE(
    "a campaign's closings are means with the deviation of the mean; angles without a shot are left out",
    "[study]") {
  AngleGroup g;
  g.closing_angle = radians(60);
  for (const double t : {12.0e-3, 12.2e-3, 12.4e-3}) {
    Events e;
    e.contact_voltage.present = true;
    Contact c;
    c.touch = {t, 1e-6};
    e.contact_voltage.contacts.push_back(c);
    g.measured.push_back(e);
  }
  const AngleGroup empty;
  const std::vector<AngleGroup> groups{empty, g};
  const auto list = campaign_closings(groups, {}, {0, 0, 0, 0});
  REQUIRE(list.size() == 1);
  CHECK(list[0].touch.value == Approx(12.2e-3));
  CHECK(list[0].touch.u == Approx(std::hypot(0.2e-3 / std::sqrt(3.0), 20e-6)));
  CHECK_FALSE(list[0].bounce.known());
}

TEST_CASE("scatter of single shots: about the mean of their angle, over all angles; unknown without repeats",
          "[study]") {
  const auto shot = [](double touch) {
    Events e;
    e.contact_voltage.present = true;
    e.contact_voltage.contacts.emplace_back().touch = {touch, 1e-6};
    return e;
  };
  std::vector<AngleGroup> groups(3);
  groups[0].measured = {shot(9.9e-3), shot(10.1e-3)};
  groups[1].measured = {shot(19.6e-3), shot(20e-3), shot(20.4e-3)};
  groups[2].measured = {shot(15e-3)};
  const ShotScatter s = shot_scatter(groups);
  CHECK(s.touch == Approx(std::sqrt((2 * 0.01 * 0.01 + 2 * 0.02 * 0.02) / 3)));
  CHECK(std::isnan(s.seat));
  CHECK(std::isnan(shot_scatter(std::span(groups).last(1)).touch));
}

TEST_CASE("what to measure next: best first, nothing that was measured, and no change of the fit",
          "[study]") {
  sim::Team team(1);
  FitJob job = small_job();
  const FitReport plain = fits(job, team, always);
  CHECK_FALSE(plain.posterior);
  job.problem.closings[3].conditions.closing_angle = radians(240);  // 60 deg of the other half-wave
  job.next = 5;
  job.granted = {0.003, 0.003, 0.1, 0.6e-3, 1e-3};
  job.scatter = {2 * 0.003, unknown, 0, 2e-3};
  const FitReport report = fits(job, team, always);
  CHECK(report.file.folds.size() == plain.file.folds.size());
  REQUIRE(report.posterior);
  CHECK_FALSE(report.posterior->held_out);
  const NextMeasurements next = next_measurements(job, report.file, *report.posterior, team);
  REQUIRE(next.list.size() == 5);
  double bits = 1e9, bounce = next.bounce_spread, overtravel = 0;
  for (const auto& n : next.list) {
    CHECK(n.bits <= bits);
    CHECK(n.bounce_left <= bounce * (1 + 1e-9));
    bits = n.bits, bounce = n.bounce_left;
    overtravel += n.quantity == "t_ot";
    if (n.quantity != "v_core" && n.quantity != "t_ot") CHECK(n.theta_deg != 60);
    CHECK(n.shots.has_value() == (n.quantity != "t_ct_bon" && n.quantity != "v_core"));
    // scatter of twice the deviation of a closing: 4 / 0.21
    if (n.quantity == "t_ct1" || n.quantity == "t_ot") CHECK(*n.shots == 20);
    if (n.quantity == "t_xt1") CHECK(*n.shots == 1);
  }
  CHECK(overtravel > 0);
  CHECK_THAT(next_text(next),
             Contains("what to measure next") && Contains("by 6 of 6 posterior samples") && !Contains("nan"));
  const auto cells = fit_cells(report.file, job.problem.closings);
  CHECK_THAT(fit_json(job, report, cells, next), Contains("bounce_spread_then"));

  // samples that do not close everywhere tell nothing here
  FitFold one = *report.posterior;
  one.members.resize(1), one.bounce->factors.resize(1);
  const NextMeasurements none = next_measurements(job, report.file, one, team);
  CHECK(none.list.empty());
  CHECK_THAT(next_text(none), Contains("not known"));

  // a posterior of all closings is another problem than none: its state is not gone on from
  CHECK_THROWS_WITH(fits(job, team, always, plain.state), Contains("another problem"));
}

TEST_CASE("a fit never uses the angle it holds out: another value there changes nothing", "[study]") {
  sim::Team team(1);
  FitJob job = small_job();
  const FitReport a = fits(job, team, always);
  job.problem.closings[1].touch.value += 3e-3;
  job.problem.closings[1].bounce.value += 3e-3;
  job.problem.closings[1].seat.value += 3e-3;
  const FitReport b = fits(job, team, always);
  REQUIRE(a.file.folds.size() == 2);
  CHECK(*a.file.folds[0].held_out == Approx(110));
  CHECK(a.file.folds[0].members == b.file.folds[0].members);
  REQUIRE(a.file.folds[0].bounce);
  CHECK(same(*a.file.folds[0].bounce, *b.file.folds[0].bounce));
  CHECK(a.file.folds[0].bounce->deviation < a.file.folds[0].bounce->median_deviation);
  CHECK_FALSE(a.file.folds[1].bounce);
  CHECK(a.file.folds[1].members != b.file.folds[1].members);
  // and predicts it: the device is of the model's kind
  const auto cells = fit_cells(a.file, small_job().problem.closings);
  REQUIRE(cells.size() == 20);
  CHECK((cells[5].held_out_percent < 2 && cells[9].quantity == "t_ot" && cells[9].held_out_percent < 5));
  CHECK(std::isnan(cells[0].held_out_percent));
  CHECK(cells[0].fitted_percent < 1);
  CHECK(cells[5].others_percent > cells[5].held_out_percent);
}

TEST_CASE(
    "an interrupted fit goes on from its state to the same result; a state of another problem is refused",
    "[study]") {
  sim::Team team(1);
  const FitJob job = small_job();
  const FitReport whole = fits(job, team, always);
  int generations = 0;
  FitReport part = fits(job, team, [&](auto...) { return ++generations < 5; });
  REQUIRE(part.stopped);
  CHECK(part.state.done.empty());  // a posterior is short: it begins anew
  const auto interrupting = [&](std::size_t fit, auto...) { return fit == 0 || ++generations < 5; };
  int interruptions = 1;
  while (part.stopped) {
    const FitState kept = parse_fit_state(to_json(part.state), "state");
    generations = 0;
    part = fits(job, team, interrupting, kept);
    ++interruptions;
  }
  CHECK(interruptions > 2);
  REQUIRE(part.file.folds.size() == 2);
  for (std::size_t k = 0; k < 2; ++k) CHECK(part.file.folds[k].members == whole.file.folds[k].members);
  CHECK(same(*part.file.folds[0].bounce, *whole.file.folds[0].bounce));
  FitJob other = job;
  other.options.seed = 2;
  CHECK_THROWS_WITH(fits(other, team, always, part.state), Contains("another problem"));
}

TEST_CASE("the last search starts from what the others found, ends nearer in absolute terms, and is resumed",
          "[study]") {
  sim::Team team(1);
  FitJob job = small_job();
  const FitReport without_finish = fits(job, team, always);
  job.finish = 120;
  const FitReport whole = fits(job, team, always);
  // the fold that holds an angle out knows nothing of it
  CHECK(whole.file.folds[0].members == without_finish.file.folds[0].members);
  const auto& all = whole.file.folds.back().members;
  REQUIRE(all.size() > 1);
  sim::FitProblem absolute =
      job.problem;  // half of what is wanted on average: 2 % of the core times, 8 %, 3 %
  absolute.absolute = true;
  absolute.tolerance = 1e-5;
  for (auto& m : absolute.closings) {
    m.touch.u = 0.01 * m.touch.value;
    m.seat.u = 0.01 * m.seat.value;
    m.bounce.u = 0.04 * m.bounce.value;
    m.settled.u = 0.015 * (m.touch.value + m.bounce.value);
  }
  const sim::Misfit misfit(absolute);
  const auto distance = [&](const std::vector<double>& values) {
    FitFold one;
    one.members = {values};
    return misfit.value(sim::point_of(specimens(whole.file, one).front(), job.problem.parameters));
  };
  for (const auto& values : all) CHECK(distance(all[0]) <= distance(values) * (1 + 1e-4));
  int generations = 0;
  const auto interrupting = [&](std::size_t fit, auto...) { return fit == 0 || ++generations < 9; };
  FitReport part = fits(job, team, interrupting);
  while (part.stopped) {
    const FitState kept = parse_fit_state(to_json(part.state), "state");
    generations = 0;
    part = fits(job, team, interrupting, kept);
  }
  for (std::size_t k = 0; k < 2; ++k) CHECK(part.file.folds[k].members == whole.file.folds[k].members);
}

TEST_CASE("a fit in parts, merged in any order, is the fit of one run, word for word and digit for digit",
          "[study]") {
  const Folder folder;
  sim::Team team(1);
  FitJob job = small_job();
  job.finish = 100;
  const auto text = [](const FitJob& j, const FitReport& r) {
    const auto cells = fit_cells(r.file, j.problem.closings);
    return fit_text(j, r, cells) + fit_json(j, r, cells) + to_json(r.file);
  };
  const std::string serial = text(job, fits(job, team, always));
  std::vector<std::string> parts;  // a posterior and two searches; the last search is no point
  for (int i = 1; i <= 3; ++i) {
    parts.push_back(folder.file(std::to_string(i) + ".db"));
    Points points(parts.back(), "fit", {i, 3});
    const FitReport r = run_fits(job, team, always, {}, points);
    CHECK(r.part);
    CHECK(r.file.folds.empty());
    CHECK(points.computed() == 1);
    run_fits(job, team, always, {}, points);  // once more: it is there
    CHECK(points.computed() == 1);
  }
  const auto collected = [&](const FitJob& j, const std::string& name,
                             const std::vector<std::string>& sources, std::int64_t missing) {
    const std::string all = folder.file(name);
    if (!sources.empty()) merge_stores(all, sources);
    Points points(all, "fit");
    const std::string out = text(j, run_fits(j, team, always, {}, points));
    CHECK(points.computed() == missing);
    CHECK(points.found() == 3 - missing);
    return out;
  };
  CHECK(collected(job, "forth.db", parts, 0) == serial);
  CHECK(collected(job, "back.db", {parts[2], parts[0], parts[1], parts[0]}, 0) == serial);
  CHECK(collected(job, "rest.db", {parts[2], parts[0]}, 1) == serial);
  CHECK(hash(folder.file("forth.db")) == hash(folder.file("rest.db")));
  // another device, seed or condition finds none
  const auto found = [&](const FitJob& j) {
    Points points(folder.file("forth.db"), "fit", {1, 3});
    run_fits(j, team, always, {}, points);
    return points.found();
  };
  CHECK(found(job) == 1);
  FitJob other = job;
  other.problem.base.core.mass *= 1.01;
  CHECK(found(other) == 0);
  other = job, other.options.seed = 2;
  CHECK(found(other) == 0);
  other = job;
  for (auto& m : other.problem.closings) m.conditions.ambient += 5;
  CHECK(found(other) == 0);
}

TEST_CASE("a fit file is read back as it was written; what is no fit file is told in one sentence",
          "[study]") {
  FitFile f;
  f.base = resolved_text(sim::Specimen{});
  f.names = {"core.mass_g", "coil.turns"};
  f.folds = {{30.0, 1.5, {{180.25, 2100}, {181, 2200}}, sim::BounceCalibration{{1.25, 0.5}, 0.25, 6e-3}},
             {std::nullopt, 2.5, {{190, 2300}}}};
  f.folds[0].bounce->line = {{0.25, 5e-3}, {1.5, 7e-3}};
  f.folds[0].bounce->line_deviation = 0.125;
  const FitFile g = parse_fit_file(to_json(f), "f.json");
  CHECK(g.names == f.names);
  CHECK(*g.folds[0].held_out == 30);
  CHECK_FALSE(g.folds[1].held_out);
  CHECK(g.folds[0].members == f.folds[0].members);
  REQUIRE(g.folds[0].bounce);
  CHECK(g.folds[0].bounce->factors == f.folds[0].bounce->factors);
  CHECK(g.folds[0].bounce->deviation == 0.25);
  CHECK(g.folds[0].bounce->median == 6e-3);
  CHECK(std::isnan(g.folds[0].bounce->median_deviation));
  CHECK(g.folds[0].bounce->line == f.folds[0].bounce->line);
  CHECK(g.folds[0].bounce->line_deviation == 0.125);
  const FitFold through_bytes = fold_of_bytes(bytes_of(f.folds[0]));
  CHECK(through_bytes.bounce->line == f.folds[0].bounce->line);
  CHECK(through_bytes.bounce->line_deviation == 0.125);
  CHECK_FALSE(g.folds[1].bounce);
  const auto list = specimens(g, g.folds[0]);
  REQUIRE(list.size() == 2);
  CHECK(list[0].core.mass == Approx(0.18025));
  CHECK(list[1].coil.turns == 2200);
  CHECK(list[1].core.travel == sim::Specimen{}.core.travel);
  CHECK_THROWS_AS(parse_fit_file("{", "f.json"), BadInput);
  CHECK_THROWS_WITH(parse_fit_file(R"({"kind":"other"})", "f.json"), Contains("f.json"));
  FitFile light = f;
  light.folds[0].bounce->factors = {1};
  CHECK_THROWS_WITH(parse_fit_file(to_json(light), "f.json"), Contains("bounce factors"));
  FitState state;
  state.done = light.folds;
  CHECK_THROWS_WITH(parse_fit_state(to_json(state), "f.state"), Contains("bounce factors"));
  light.folds[0].bounce->factors = {1, -1};
  CHECK_THROWS_WITH(parse_fit_file(to_json(light), "f.json"), Contains("above 0"));
  light.folds[0].bounce->factors = {1, 1};
  light.folds[0].bounce->line = {{0.25, 5e-3}};
  CHECK_THROWS_WITH(parse_fit_file(to_json(light), "f.json"), Contains("fewer than two angles"));
  light.folds[0].bounce->line = {{0.25, 5e-3}, {-1, 5e-3}};
  CHECK_THROWS_WITH(parse_fit_file(to_json(light), "f.json"), Contains("angle_rad"));
  light.folds[0].bounce->line.clear();
  light.folds[0].bounce->median = 0;
  CHECK_THROWS_WITH(parse_fit_file(to_json(light), "f.json"), Contains("median_s"));
  f.names[0] = "core.weight";
  CHECK_THROWS_WITH(parse_fit_file(to_json(f), "f.json"), Contains("core.weight"));
  f.names = {"core.mass_g"};
  CHECK_THROWS_WITH(parse_fit_file(to_json(f), "f.json"), Contains("too few or too many"));
  CHECK_THROWS_AS(parse_fit_state(to_json(g), "f.json"), BadInput);
}

TEST_CASE("texts of a fit name every number, mark what lies at a bound, and never print nan", "[study]") {
  sim::Team team(1);
  FitJob job = small_job();
  job.problem.parameters = {sim::parameter("coil.resistance_ohm", 256, 270)};  // the device has 252
  FitReport r = fits(job, team, always);
  const auto texts = [&] {
    const auto cells = fit_cells(r.file, job.problem.closings);
    return std::pair(fit_text(job, r, cells), fit_json(job, r, cells));
  };
  const auto [text, json] = texts();
  CHECK_THAT(text, Contains("coil.resistance_ohm") && Contains("at a bound") && Contains("t_ct_bon") &&
                       Contains("inrush") && Contains("weight of samples"));
  CHECK(text.find("nan") == std::string::npos);
  CHECK_THAT(json, Contains("held_out_error_percent") && Contains("samples_deviation"));
  CHECK(json.find("line_deviation") == std::string::npos);
  CHECK_THAT(text, !Contains("error of line"));
  r.file.folds[0].bounce->line = {{0.0, 5e-3}, {1.0, 6e-3}};
  r.file.folds[0].bounce->line_deviation = 0.0625;
  const auto [line_text, line_json] = texts();
  CHECK_THAT(line_json, Contains("\"line_deviation\": 0.0625"));
  CHECK_THAT(line_text, Contains("error of line") && Contains("0.06"));
  r.file.folds[0].bounce->line.clear();
  r.file.folds[0].bounce->median_deviation = sim::BounceCalibration::nan;
  const auto [unknown_text, unknown_json] = texts();
  CHECK(unknown_text.find("nan") == std::string::npos);
  CHECK(unknown_text.find("weight of samples") == std::string::npos);
  CHECK(unknown_json.find("nan") == std::string::npos);
}
