#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/compare/repeats.h"
#include "host/compare/student.h"

using namespace powbench;
using namespace powbench::host;

namespace {

/// A closing whose contact voltage touches at `touch` with standard uncertainty u.
Events touching(double touch, double u) {
  Events e;
  e.contact_voltage.present = true;
  Contact c;
  c.touch = {touch, u};
  e.contact_voltage.contacts = {c};
  e.contact_voltage.settled = c.touch;
  e.contact_voltage.bounce_time = {0, u};
  return e;
}

const ComparisonRow& row(const Comparison& all, const std::string& quantity, double angle_deg) {
  for (const auto& r : all.rows)
    if (r.quantity == quantity && std::fabs(degrees(r.closing_angle) - angle_deg) < 1e-6) return r;
  FAIL("no row " << quantity);
  return all.rows.front();
}

}  // namespace

TEST_CASE("coverage factors of Student's t, against closed forms and tables", "[compare]") {
  const double p = 0.95;
  CHECK(coverage_factor(1, p) == Approx(std::tan(0.5 * pi * p)).epsilon(1e-10));  // Cauchy
  CHECK(coverage_factor(2, p) ==
        Approx(p * std::sqrt(2 / (1 - p * p))).epsilon(1e-10));  // closed form, 2 dof
  CHECK(coverage_factor(4, p) == Approx(2.7764451052).epsilon(1e-9));
  CHECK(coverage_factor(10, p) == Approx(2.2281388520).epsilon(1e-9));
  CHECK(coverage_factor(100, p) == Approx(1.9839715185).epsilon(1e-9));
  CHECK(coverage_factor(std::numeric_limits<double>::infinity(), p) == Approx(1.9599639845).epsilon(1e-9));
  CHECK(coverage_factor(9.9e6, p) ==
        Approx(coverage_factor(1.1e7, p)).epsilon(1e-6));  // no step where the normal takes over
  CHECK(coverage_factor(5, 0.99) == Approx(4.0321429836).epsilon(1e-9));
  // the default: 2 u of a normal distribution, and no other factor beside it
  CHECK(coverage_factor(std::numeric_limits<double>::infinity()) == Approx(2.0).epsilon(1e-12));
  CHECK(coverage_factor(1) == Approx(std::tan(0.5 * pi * std::erf(std::sqrt(2.0)))).epsilon(1e-10));
  CHECK(student_probability(0, 3) == Approx(0).margin(1e-12));
  CHECK_THROWS_AS(coverage_factor(0, p), std::invalid_argument);
  CHECK_THROWS_AS(coverage_factor(3, 1.0), std::invalid_argument);
}

TEST_CASE("repeats: numbers worked out by hand", "[compare]") {
  // 1, 2, 3, 4: mean 2.5, s^2 = 5/3, u_A^2 = 5/12; events' u 0.5 each, u_B = 0.5, u_B^2 = 1/4
  const Repeats r = repeats_of({{1, 0.5}, {2, 0.5}, {3, 0.5}, {4, 0.5}});
  CHECK(r.n == 4);
  CHECK(r.mean == 2.5);
  CHECK(r.scatter == Approx(std::sqrt(5.0 / 3)));
  CHECK(r.u == Approx(std::sqrt(5.0 / 12 + 1.0 / 4)));
  CHECK(r.dof == Approx(3 * std::pow((5.0 / 12 + 1.0 / 4) / (5.0 / 12), 2)));  // 7.68
  CHECK(r.coverage == Approx(2.38432).epsilon(2e-4));
  CHECK(r.lowest == 1);
  CHECK(r.highest == 4);
  CHECK_FALSE(r.two_modes);
}

TEST_CASE("repeats: none, one, equal, and without uncertainty", "[compare]") {
  const Repeats none = repeats_of({{}, {}});
  CHECK(none.n == 0);
  CHECK(std::isnan(none.mean));

  const Repeats one = repeats_of({{3, 0.2}, {}});
  CHECK(one.n == 1);
  CHECK(one.mean == 3);
  CHECK(one.u == Approx(0.2));
  CHECK(std::isinf(one.dof));
  CHECK(one.coverage == Approx(2.0).epsilon(1e-9));
  CHECK(std::isnan(one.scatter));

  const Repeats bare = repeats_of({{3, std::nan("")}});
  CHECK(bare.mean == 3);
  CHECK(std::isnan(bare.u));

  const Repeats equal = repeats_of({{3, 0.1}, {3, 0.1}, {3, 0.1}});
  CHECK(equal.scatter == 0);
  CHECK(equal.u == Approx(0.1));
  CHECK(std::isinf(equal.dof));

  const Repeats exact = repeats_of({{3, std::nan("")}, {3, std::nan("")}});
  CHECK(exact.u == 0);
}

TEST_CASE("two modes are found, one broad mode is not", "[compare]") {
  CHECK(splits_in_two({14.1, 17.6, 14.2, 17.7, 14.15}, 0.01));
  CHECK_FALSE(splits_in_two({14.1, 17.6, 14.2}, 0.01));              // too few
  CHECK_FALSE(splits_in_two({14.1, 14.2, 14.15, 17.6}, 0.01));       // one outlier is not a mode
  CHECK_FALSE(splits_in_two({14.0, 14.5, 15.0, 15.5, 16.0}, 0.01));  // evenly spread
  CHECK_FALSE(splits_in_two({14.1, 14.1, 14.2, 14.2}, 0.05));        // within the uncertainty
  CHECK(splits_in_two({1, 1, 2, 2}, 0));
}

TEST_CASE("groups: by hundredth of a degree, polarity included, in order", "[compare]") {
  std::vector<AngleGroup> groups;
  Conditions c;
  c.closing_angle = radians(90);
  group_at(groups, effective_angle(c)).measured.resize(1);
  c.polarity = -1;
  group_at(groups, effective_angle(c)).measured.resize(2);
  c.closing_angle = radians(210);
  group_at(groups, effective_angle(c)).measured.resize(3);
  group_at(groups, radians(90.004)).measured.push_back({});
  REQUIRE(groups.size() == 3);
  CHECK(degrees(groups[0].closing_angle) == Approx(30));
  CHECK(degrees(groups[1].closing_angle) == Approx(90));
  CHECK(degrees(groups[2].closing_angle) == Approx(270));
  CHECK(groups[1].measured.size() == 2);
  CHECK(groups[0].measured.size() == 3);
}

TEST_CASE("rows carry measurement, simulation and publication in SI", "[compare]") {
  std::vector<AngleGroup> groups;
  auto& g = group_at(groups, radians(30));
  g.measured = {touching(11.8e-3, 4e-6), touching(12.0e-3, 4e-6)};
  g.simulated = {touching(12.5e-3, 0)};
  group_at(groups, radians(45)).simulated = {touching(12.0e-3, 0)};
  Limit limit;
  limit.quantity = "t_ct1";
  limit.high = 11.9e-3;
  const Comparison all = compare(groups, published_rows(), {limit});
  CHECK(all.rows.size() == 2 * quantity_table.size());

  const ComparisonRow& r = row(all, "t_ct1", 30);
  CHECK(r.repeats == 2);
  CHECK(r.measured.value == Approx(11.9e-3));
  CHECK(r.scatter == Approx(0.2e-3 / std::sqrt(2.0)));
  CHECK(r.measured.u == Approx(std::hypot(0.1e-3, 4e-6)));
  CHECK(r.lowest == 11.8e-3);
  CHECK(r.highest == 12.0e-3);
  CHECK(r.simulated == 12.5e-3);
  CHECK(r.published_measurement == Approx(11.86e-3));
  CHECK(r.published_simulation == Approx(11.65e-3));
  CHECK(r.outcome == Outcome::fail);  // the mean is inside, one repeat is not

  CHECK(row(all, "t_ct2", 30).outcome == Outcome::not_judged);  // no limit
  CHECK(row(all, "t_xt1", 30).outcome == Outcome::not_judged);  // nor seen, which only a limit minds
  CHECK(r.against_simulation == Outcome::not_judged);
  CHECK(r.difference_over_U() == Approx(0.6e-3 / (r.coverage * r.measured.u)));
  const ComparisonRow& only_simulated = row(all, "t_ct1", 45);
  CHECK(only_simulated.repeats == 0);
  CHECK(only_simulated.outcome == Outcome::error);
  CHECK(only_simulated.simulated == 12.0e-3);
  CHECK(std::isnan(only_simulated.published_measurement));
}

TEST_CASE("limits: open ends, both ends, unknown values, wrong names", "[compare]") {
  Limit l;
  l.quantity = "t_ct1";
  CHECK(l.of({5, 0}) == Outcome::pass);
  CHECK(l.of({}) == Outcome::not_observed);
  CHECK(range_text(l) == "any value");
  l.high = 9e-3;
  CHECK(l.of({9e-3, 0}) == Outcome::pass);
  CHECK(l.of({9.0001e-3, 0}) == Outcome::fail);
  CHECK(range_text(l) == "\xE2\x89\xA4 9 ms");
  l.high = 12.3725e-3;  // what is signed is what is applied
  CHECK(range_text(l) == "\xE2\x89\xA4 12.3725 ms");
  l.high = 9e-3;
  l.low = 1e-3;
  CHECK(l.of({0.5e-3, 0}) == Outcome::fail);
  CHECK(range_text(l) == "1 to 9 ms");

  const Judgement bad = judge(touching(12.3456e-3, 1e-6), {l});
  CHECK(bad.outcome == Outcome::fail);
  CHECK(bad.reason == "t_ct1 = 12.346 ms, allowed 1 to 9 ms");
  const Judgement blind = judge(Events{}, {l});
  CHECK(blind.outcome == Outcome::not_observed);
  CHECK(blind.reason == "t_ct1 not observed, allowed 1 to 9 ms");
  CHECK(judge(touching(5e-3, 1e-6), {l}).outcome == Outcome::pass);
  CHECK(judge(Events{}, {}).outcome == Outcome::not_judged);
  l.quantity = "t_cta";
  CHECK_THROWS_AS(judge(Events{}, {l}), std::invalid_argument);
}

TEST_CASE("guarded acceptance takes U = 2 u off the limits; without an uncertainty nothing is judged",
          "[compare]") {
  Limit l;
  l.quantity = "t_ct1";
  l.low = 1e-3;
  l.high = 9e-3;
  CHECK(l.of({8.9e-3, 0.06e-3}) == Outcome::pass);
  CHECK(l.of({8.9e-3, 0.06e-3}, Decision::guarded) == Outcome::fail);
  CHECK(l.of({8.9e-3, 0.04e-3}, Decision::guarded) == Outcome::pass);
  CHECK(l.of({1.1e-3, 0.06e-3}, Decision::guarded) == Outcome::fail);
  CHECK(l.of({5e-3, std::nan("")}, Decision::guarded) == Outcome::not_judged);
  CHECK(judge(touching(8.9e-3, 0.06e-3), {l}, Decision::guarded).reason ==
        "t_ct1 = 8.9000 ms with U = 0.12 ms, allowed 1 to 9 ms");
}

TEST_CASE("a closing angle is judged at the tolerance itself", "[compare]") {
  const double tolerance = radians(0.1), asked = radians(30);
  const auto judged = [&](double off_deg, double u_deg, Decision rule) {
    return judge_angle({asked + radians(off_deg), radians(u_deg)}, asked, tolerance, rule);
  };
  for (const double side : {-1.0, 1.0}) {
    CHECK(judged(side * 0.099, 0, Decision::simple) == Outcome::pass);
    CHECK(judged(side * 0.101, 0, Decision::simple) == Outcome::fail);
    CHECK(judged(side * 0.05, 0.0249, Decision::guarded) == Outcome::pass);
    CHECK(judged(side * 0.05, 0.0251, Decision::guarded) == Outcome::fail);
  }
}

TEST_CASE("rows are ranked by difference over U, and those without it are left out", "[compare]") {
  Comparison all;
  for (const double off : {1e-3, 3e-3, std::nan(""), 2e-3}) {
    ComparisonRow r;
    r.measured = {10e-3, 0.5e-3};
    r.coverage = 2;
    r.simulated = 10e-3 + off;
    all.rows.push_back(r);
  }
  const auto rows = ranked(all);
  REQUIRE(rows.size() == 3);
  CHECK(rows[0] == &all.rows[1]);
  CHECK(rows[1] == &all.rows[3]);
  CHECK(rows[2] == &all.rows[0]);
}

TEST_CASE("difference over U, in a word", "[compare]") {
  ComparisonRow r;
  CHECK(agreement(r.difference_over_U()) == "not known");
  r.measured = {13.353e-3, 0.0015e-3};
  r.coverage = 2;
  r.simulated = 11.513e-3;
  CHECK(r.difference_over_U() == Approx(1.84 / 0.003).epsilon(1e-6));
  CHECK(agreement(r.difference_over_U()) == "differs");
  r.u_simulated = 1e-3;  // a simulation with an uncertainty of its own
  CHECK(r.difference_over_U() == Approx(1.84 / 2).epsilon(1e-4));
  CHECK(agreement(r.difference_over_U()) == "agrees");
}

TEST_CASE("of two outcomes the worse one stands, and nothing is as good as a pass", "[compare]") {
  for (const Outcome o : {Outcome::fail, Outcome::error, Outcome::timeout, Outcome::aborted,
                          Outcome::not_observed, Outcome::not_judged}) {
    CHECK(worse(o, Outcome::pass) == o);
    CHECK(worse(Outcome::pass, o) == o);
    CHECK(worse(Outcome::fail, o) == Outcome::fail);
  }
  CHECK(worse(Outcome::not_judged, Outcome::not_observed) == Outcome::not_observed);
}

TEST_CASE("an angle that is not known has a group of its own, behind all others", "[compare]") {
  std::vector<AngleGroup> groups;
  group_at(groups, std::nan("")).measured.resize(1);
  group_at(groups, radians(359)).measured.resize(1);
  group_at(groups, std::nan("")).measured.resize(2);
  REQUIRE(groups.size() == 2);
  CHECK(degrees(groups[0].closing_angle) == Approx(359));
  CHECK(std::isnan(groups[1].closing_angle));
  CHECK(groups[1].measured.size() == 2);
  Conditions c;
  c.closing_angle = std::nan("");
  CHECK(std::isnan(effective_angle(c)));
}
