// Global search, least squares and identifiability on functions with known answers.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "sim/study/evolution.h"
#include "sim/study/least_squares.h"

using namespace powbench::sim;
using powbench::pi;

namespace {

/// Many minima: the smallest, 0, at 0.7 in every coordinate.
double rough(std::span<const double> p, double) {
  double sum = 0;
  for (const double u : p) {
    const double x = 10 * (u - 0.7);
    sum += x * x + 10 * (1 - std::cos(2 * pi * x));
  }
  return sum;
}

Evolution::Settings settings(long evaluations) {
  Evolution::Settings s;
  s.dimension = 4;
  s.evaluations = evaluations;
  s.seed = 3;
  return s;
}

bool same(const std::vector<Candidate>& a, const std::vector<Candidate>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].point != b[k].point || a[k].value != b[k].value) return false;
  return true;
}

/// Of a problem by itself.
Refined near_alone(const Residuals& f, const std::vector<double>& start, const Jacobian& at_start,
                   int evaluations) {
  const auto one = [&](std::span<const PointOf> points) {
    return std::vector<std::vector<double>>{f(points.front().point)};
  };
  return refine_near(one, 1, start, at_start, evaluations).front();
}

}  // namespace

TEST_CASE("the search leaves local minima behind and ends in the smallest") {
  Team team(1);
  Evolution search(settings(8000), rough);
  while (search.step(team)) {
  }
  CHECK(search.best().value < 1e-6);
  for (const double u : search.best().point) CHECK(u == Approx(0.7).margin(1e-4));
  CHECK(search.state().used >= 8000);
}

TEST_CASE("the search is the same on one thread and on three, and when it is interrupted and gone on with") {
  Team one(1);
  Team three(3);
  Evolution a(settings(2000), rough);
  Evolution b(settings(2000), rough);
  while (a.step(one)) {
  }
  for (int k = 0; k < 7; ++k) b.step(three);
  Evolution c(settings(2000), rough);
  c.resume(b.state());
  while (c.step(one)) {
  }
  CHECK(same(a.state().population, c.state().population));
  CHECK(a.state().used == c.state().used);
}

TEST_CASE("points to start from are tried, and every point stays in the cube") {
  Team team(1);
  Evolution search(settings(400), [](std::span<const double> p, double) { return -p[0] - p[1]; },
                   {{1, 1, 0, 0}});
  search.step(team);
  CHECK(search.best().value == -2);
  while (search.step(team))
    for (const auto& c : search.state().population)
      for (const double u : c.point) CHECK((u >= 0 && u <= 1));
}

TEST_CASE("least squares: a linear problem in one or two steps, bounds kept, never worse than the start") {
  Team team(2);
  // r = A (u - u0) with u0 inside
  const auto linear = [](std::span<const double> u) {
    const double a = u[0] - 0.3;
    const double b = u[1] - 0.6;
    return std::vector<double>{2 * a + b, a - b, 0.5 * a + 3 * b};
  };
  RefineOptions options;
  options.damping = 1e-8;
  const Refined r = refine(linear, {0.9, 0.1}, options, team);
  CHECK(r.point[0] == Approx(0.3).margin(1e-7));
  CHECK(r.point[1] == Approx(0.6).margin(1e-7));
  CHECK(r.iterations <= 4);
  const auto beyond = [](std::span<const double> u) { return std::vector<double>{u[0] - 3, u[1] + 2}; };
  const Refined edge = refine(beyond, {0.5, 0.5}, options, team);
  CHECK(edge.point == std::vector<double>{1, 0});
  const auto flat = [](std::span<const double>) { return std::vector<double>{1, 1}; };
  CHECK(refine(flat, {0.5, 0.5}, options, team).sum == 2);
}

TEST_CASE(
    "least squares near a known Jacobian: the same minimum for a fraction of the evaluations, within its "
    "budget") {
  Team team(1);
  int evaluations = 0;
  // curved, four coordinates, rank-one updates have to follow it; the shift moves the minimum
  double shift = 0;
  const auto curved = [&](std::span<const double> u) {
    ++evaluations;
    return std::vector<double>{5 * (u[1] - u[0] * u[0]) + shift, 2 * (u[0] - 0.5) - shift,
                               3 * std::sin(u[2] + u[3]) - 2, u[2] - 0.3 + 0.5 * u[0] * u[3], u[3] - 0.5};
  };
  const std::vector<double> middle(4, 0.5);
  RefineOptions options;
  options.iterations = 50;
  options.step = 1e-6;
  options.enough = 1e-10;
  const Refined base = refine(curved, middle, options, team);
  const Jacobian at_base = jacobian(curved, base.point, base.residuals, 1e-6, team);
  shift = 0.15;
  evaluations = 0;
  const Refined whole = refine(curved, base.point, options, team);
  const int of_whole = evaluations;
  evaluations = 0;
  const Refined near = near_alone(curved, base.point, at_base, 24);
  CHECK(evaluations == near.iterations);
  CHECK(2 * evaluations < of_whole);
  CHECK(near.sum < whole.sum * 1.001);
  for (std::size_t i = 0; i < 4; ++i) CHECK(near.point[i] == Approx(whole.point[i]).margin(5e-3));
  evaluations = 0;
  CHECK(near_alone(curved, base.point, at_base, 3).iterations == 3);
  CHECK(evaluations == 3);
  // several side by side, each with a shift of its own, are each alone
  const auto shifted = [&](std::span<const PointOf> points) {
    std::vector<std::vector<double>> all;
    for (const auto& p : points) {
      shift = 0.05 * static_cast<double>(p.problem);
      all.push_back(curved(p.point));
    }
    return all;
  };
  const auto together = refine_near(shifted, 4, base.point, at_base, 24);
  REQUIRE(together.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    shift = 0.05 * static_cast<double>(k);
    const Refined alone = near_alone(curved, base.point, at_base, 24);
    CHECK(together[k].point == alone.point);
    CHECK(together[k].iterations == alone.iterations);
  }
  shift = 0.15;
  // a Jacobian of the wrong sign: nothing is gained, nothing is lost
  Jacobian wrong = at_base;
  for (double& v : wrong.values) v = -v;
  CHECK(near_alone(curved, base.point, wrong, 24).sum <= near_alone(curved, base.point, wrong, 1).sum);

  const auto beyond = [](std::span<const double> u) { return std::vector<double>{u[0] - 3, u[1] + 2}; };
  CHECK(near_alone(beyond, {0.5, 0.5}, {2, 2, {1, 0, 0, 1}}, 24).point == std::vector<double>{1, 0});
  const auto flat = [](std::span<const double>) { return std::vector<double>{1, 1}; };
  const Refined still = near_alone(flat, {0.5, 0.5}, {2, 2, {0, 0, 0, 0}}, 24);
  CHECK(still.sum == 2);
  CHECK(still.point == std::vector<double>{0.5, 0.5});
}

TEST_CASE("identifiability: deviations and correlation of a known covariance, and what the data do not see") {
  // J^T J = [[4, 2], [2, 5]]: covariance = inverse = [[5, -2], [-2, 4]] / 16
  const Jacobian j{2, 2, {2, 1, 0, 2}};
  const Identifiability free = identifiability(j, 0);
  CHECK(free.deviation[0] == Approx(std::sqrt(5.0 / 16)));
  CHECK(free.deviation[1] == Approx(std::sqrt(4.0 / 16)));
  CHECK(free.correlation[1] == Approx(-2 / std::sqrt(20.0)));
  // with the flat prior of the unit interval: inverse of [[16, 2], [2, 17]], 12 times its diagonal taken from 1
  CHECK(free.data_share[0] == Approx(1 - 12 * 17.0 / 268));
  CHECK(free.data_share[1] == Approx(1 - 12 * 16.0 / 268));
  CHECK(identifiability({1, 2, {1e3, 0}}, 0).data_share[1] == Approx(0).margin(1e-12));
  const Jacobian blind{1, 2, {1e3, 0}};
  const Identifiability told = identifiability(blind, 0.5);
  CHECK(told.data_share[0] == Approx(1).margin(1e-5));
  CHECK(told.data_share[1] == Approx(0).margin(1e-9));
  CHECK(told.deviation[1] == Approx(0.5));
  CHECK(told.singular[0] == Approx(1e3));
}
