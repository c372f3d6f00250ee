// The rules that the bounce evidence compares: against values by hand.

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/study/bounce_rules.h"
#include "core/units.h"

using namespace powbench::bench;

namespace {

constexpr double half_turn = powbench::pi;

std::vector<Known> at(const std::vector<double>& degrees, double (*log_bounce)(double)) {
  std::vector<Known> list;
  for (const double d : degrees)
    list.push_back({d * half_turn / 180, log_bounce(d * half_turn / 180), {std::sin(d)}});
  return list;
}

double wave(double theta) {
  return -5 + 0.3 * std::cos(2 * theta) - 0.1 * std::sin(2 * theta);
}

}  // namespace

TEST_CASE("median, nearest and interpolated bounce; 180 degrees are 0") {
  const std::vector<Known> list{{0.1, -5.0, {}}, {1.1, -4.0, {}}, {2.1, -4.5, {}}};
  CHECK(median_rule(list, 9, {}) == -4.5);
  CHECK(nearest_rule(list, 0.5, {}) == -5.0);
  CHECK(nearest_rule(list, 3.0, {}) == -5.0);  // 3.0 is 0.14 before pi: 0.24 from 0.1, 0.9 from 2.1
  CHECK(nearest_rule(list, 1.7, {}) == -4.5);
  CHECK(interpolation_rule(list, 0.6, {}) == Approx(-4.5));
  CHECK(interpolation_rule(list, 1.35, {}) == Approx(-4.125));
  CHECK(interpolation_rule(list, 1.1, {}) == Approx(-4.0));
  const double gap = half_turn - 2.0;  // from 2.1 to 0.1 of the next period
  CHECK(interpolation_rule(list, 2.1 + gap / 4, {}) == Approx(-4.625));
  CHECK(interpolation_rule(list, 0.1 - gap / 4, {}) == Approx(-4.875));
}

TEST_CASE("harmonics: the second from three angles on, the fourth from ten") {
  const auto three = at({0, 40, 110}, wave);
  for (const double d : {20.0, 75.0, 160.0})
    CHECK(harmonic_rule(three, d * half_turn / 180, {}) == Approx(wave(d * half_turn / 180)));
  const auto steeper = [](double theta) { return wave(theta) + 0.2 * std::sin(4 * theta); };
  std::vector<double> degrees;
  for (int k = 0; k < 10; ++k) degrees.push_back(18.0 * k);
  const auto ten = at(degrees, steeper);
  CHECK(harmonic_rule(ten, 0.4, {}) == Approx(steeper(0.4)));
  const std::vector<Known> nine(ten.begin(), ten.end() - 1);
  CHECK(std::fabs(harmonic_rule(nine, 0.4, {}) - steeper(0.4)) > 0.05);
}

TEST_CASE("a line on a feature is shortened by one closing of one deviation, and ends at three deviations") {
  const std::vector<Known> list{{0, -5, {1}}, {0.5, -4, {3}}, {1, -5, {1}}, {1.5, -4, {3}}};
  // mean 2, deviation 1: slope 2 / (4 + 1) of the 0.5 a deviation that the points have
  const double slope = 0.5 * 4 / 5.0;
  CHECK(feature_rule(list, 0, {2}) == Approx(-4.5));
  CHECK(feature_rule(list, 0, {3}) == Approx(-4.5 + slope));
  CHECK(feature_rule(list, 0, {100}) == Approx(-4.5 + 3 * slope));
}

TEST_CASE("a process believes a model that tells the pattern, and none that contradicts it") {
  const auto list = at({0, 25, 60, 80, 110, 140, 165}, wave);
  std::vector<double> right, wrong;
  for (const auto& k : list) {
    right.push_back(k.log_bounce + 0.4);  // a factor is no fault of a model
    wrong.push_back(-10 - k.log_bounce);
  }
  const double angle = 0.8;
  const auto alone = blended(list, {}, angle, 0), with = blended(list, right, angle, wave(angle) + 0.4),
             against = blended(list, wrong, angle, -10 - wave(angle));
  CHECK(std::fabs(alone.log_bounce - wave(angle)) < 0.1);
  CHECK(with.share > 0.9);
  CHECK(std::fabs(with.log_bounce - wave(angle)) < 0.01);
  CHECK(with.deviation < alone.deviation);
  CHECK(against.share < 0.1);
  CHECK(alone.share == 0);
}
