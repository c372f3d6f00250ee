// What measured bounces tell of samples made without them: against values by hand.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "sim/study/bounce_calibration.h"

using namespace powbench::sim;

namespace {

constexpr double missing = BounceCalibration::nan;

double squared_log(double ratio) {
  return std::pow(std::log(ratio), 2);
}

}  // namespace

TEST_CASE("a draw whose bounces are all off by one factor is calibrated by it and has no deviation") {
  const std::vector<double> measured{5e-3, 6e-3, 7e-3, 10e-3};
  std::vector<double> simulated;
  for (const double m : measured) simulated.push_back(m / 1.3);
  const auto c = calibrate_bounce(std::vector<std::vector<double>>{simulated}, measured);
  REQUIRE(c.factors.size() == 1);
  CHECK(c.factors[0] == Approx(1.3));
  CHECK(c.deviation == Approx(0).margin(1e-12));
  CHECK(c.median == Approx(std::sqrt(6e-3 * 7e-3)));
  // each against the median of the other three: 5 and 7, 6 and 7, 7 and 6, 10 and 6
  const double mean =
      (squared_log(7.0 / 5) + squared_log(7.0 / 6) + squared_log(6.0 / 7) + squared_log(0.6)) / 4;
  CHECK(c.median_deviation == Approx(std::sqrt(mean)));
  CHECK(pooled_bounce(8e-3, c, 0).value == Approx(8e-3));  // a model without a fault stands alone
  CHECK(pooled_bounce(8e-3, c, 0).deviation == Approx(0).margin(1e-12));
}

TEST_CASE("samples and plain median are pooled by the inverse of their squared deviations") {
  BounceCalibration c{{1}, 0.3, 5e-3, 0.1};
  const auto p = pooled_bounce(8e-3, c, 0);
  const double w = 0.01 / (0.01 + 0.09);
  CHECK(weight_of_samples(c) == Approx(w));
  CHECK(std::log(p.value) == Approx(w * std::log(8e-3) + (1 - w) * std::log(5e-3)));
  CHECK(1 / (p.deviation * p.deviation) == Approx(1 / 0.09 + 1 / 0.01));
  c.median_deviation = 0;  // the others agree to the last digit
  CHECK(pooled_bounce(8e-3, c, 0).value == Approx(5e-3));
  CHECK(weight_of_samples(c) == 0);
  c.deviation = 0;
  CHECK(weight_of_samples(c) == 1);
  CHECK(pooled_bounce(8e-3, c, 0).value == Approx(8e-3));
}

TEST_CASE("not measured: left out; does not close or bounce: far off; two closings: no deviation") {
  const std::vector<double> measured{5e-3, missing, 6e-3, 7e-3, 8e-3};
  const auto one = [&](std::vector<double> simulated) {
    return calibrate_bounce(std::vector<std::vector<double>>{std::move(simulated)}, measured);
  };
  CHECK(one({2.5e-3, 9e-3, 3e-3, 3.5e-3, 4e-3}).factors[0] == Approx(2));
  CHECK(one({2.5e-3, 9e-3, 3e-3, 3.5e-3, 4e-3}).deviation == Approx(0).margin(1e-12));
  for (const double none : {missing, 0.0, 1e-9}) {
    const auto c = one({5e-3, 1e-3, 6e-3, 7e-3, none});
    CHECK(c.factors[0] == Approx(1));
    CHECK(c.deviation == Approx(0.5 * std::log(8e-3 / 20e-6)));
  }
  const std::vector<double> two{5e-3, 6e-3};
  const auto few = calibrate_bounce(std::vector<std::vector<double>>{{4e-3, 5e-3}}, two);
  CHECK(few.factors[0] == Approx(std::sqrt(1.25 * 1.2)));
  CHECK(std::isnan(few.deviation));
  CHECK(std::isnan(few.median_deviation));
  const std::vector<double> none(3, missing);
  const auto blind = calibrate_bounce(std::vector<std::vector<double>>{{4e-3, 5e-3, 6e-3}}, none);
  CHECK(blind.factors[0] == 1);
  CHECK(std::isnan(blind.median));
  for (const auto& c :
       {few, blind, BounceCalibration{{1}, 0.2, 6e-3}, BounceCalibration{{1}, missing, 6e-3, 0.2}}) {
    CHECK(pooled_bounce(8e-3, c, 0).value == 8e-3);
    CHECK(std::isnan(pooled_bounce(8e-3, c, 0).deviation));
    CHECK(std::isnan(weight_of_samples(c)));
  }
  // a median draw without bounce turns the pooled bounce neither into none nor into no number
  CHECK(pooled_bounce(0, {{1}, 0.3, 5e-3, 0}, 0).value == Approx(5e-3));
  CHECK(pooled_bounce(0, {{1}, 0.3, 5e-3, 0.1}, 0).value > 2e-3);
}

TEST_CASE(
    "a sixth closing, many times: a model that knows the pattern is believed, one that knows nothing is "
    "not") {
  powbench::Random random(3);
  double knowing = 0, ignorant = 0, plain = 0;
  constexpr int times = 400, angles = 6, samples = 20;
  for (int t = 0; t < times; ++t) {
    std::vector<double> truth;
    for (int i = 0; i < angles; ++i) truth.push_back(6e-3 * std::exp(0.2 * random.normal()));
    const std::vector<double> seen(truth.begin(), truth.end() - 1);
    const auto error = [&](double share_known) {
      std::vector<std::vector<double>> simulated;
      std::vector<double> unseen;
      for (int k = 0; k < samples; ++k) {
        const double scale = std::exp(0.3 * random.normal());  // restitution: every draw has its own
        std::vector<double> b;
        for (const double v : truth)
          b.push_back(scale * std::pow(v / 6e-3, share_known) * 6e-3 * std::exp(0.05 * random.normal()) *
                      (share_known > 0 ? 1 : std::exp(0.2 * random.normal())));
        unseen.push_back(b.back());
        b.pop_back();
        simulated.push_back(b);
      }
      const auto c = calibrate_bounce(simulated, seen);
      for (int k = 0; k < samples; ++k) unseen[std::size_t(k)] *= c.factors[std::size_t(k)];
      std::sort(unseen.begin(), unseen.end());
      return squared_log(pooled_bounce(unseen[samples / 2], c, 0).value / truth.back()) / times;
    };
    knowing += error(1);
    ignorant += error(0);
    std::vector<double> sorted = seen;
    std::sort(sorted.begin(), sorted.end());
    plain += squared_log(sorted[2] / truth.back()) / times;
  }
  CHECK(std::sqrt(plain) == Approx(0.22).epsilon(0.15));
  CHECK(knowing < 0.1 * plain);
  CHECK(ignorant < 1.1 * plain);
}

namespace {

/// Bounces that change smoothly with the angle of the mains, each off by `scatter` of its logarithm.
BounceCalibration of_angles(int count, double scatter, double swing = 0.4, int repeats = 1) {
  powbench::Random random(7);
  std::vector<double> angles, measured;
  for (int r = 0; r < repeats; ++r)
    for (int k = 0; k < count; ++k) {
      angles.push_back(powbench::pi * k / count + (r % 2) * powbench::pi);  // of the other polarity
      measured.push_back(5e-3 * std::exp(swing * std::sin(2 * angles.back()) + scatter * random.normal()));
    }
  return calibrate_bounce(std::vector<std::vector<double>>{std::vector<double>(measured.size(), 6e-3)},
                          measured, angles);
}

}  // namespace

TEST_CASE("from twelve angles on the line between the neighbours stands in the place of the median") {
  CHECK(of_angles(11, 0.01).line.empty());
  CHECK(of_angles(12, 0.01).line.size() == 12);
  const auto c = of_angles(18, 0.01);
  REQUIRE(c.line.size() == 18);
  CHECK(c.line_deviation < 0.05);
  CHECK(c.median_deviation > 0.2);
  for (const double angle : {0.02, 0.9, 1.6, 2.3, powbench::pi - 0.02, powbench::pi + 0.9, -0.5}) {
    const auto told = without_model(c, angle);
    CHECK(std::log(told.value / 5e-3) == Approx(0.4 * std::sin(2 * angle)).margin(0.04));
    CHECK(told.deviation == c.line_deviation);
  }
  // exactly at a measured angle: its own bounce
  CHECK(without_model(c, c.line[4].angle).value == Approx(c.line[4].bounce));
  // a constant model is worse than the line, which has most of the weight
  CHECK(weight_of_samples(c) < 0.1);
  CHECK(pooled_bounce(5e-3, c, powbench::pi / 4).value > 6.5e-3);
}

TEST_CASE(
    "bounces that follow no line keep their median, repeats count once for an angle and all for the error") {
  CHECK(of_angles(12, 0.2, 0).line.empty());
  CHECK(without_model(of_angles(12, 0.2, 0), 1).value == of_angles(12, 0.2, 0).median);
  const auto c = of_angles(12, 0.05, 0.4, 4);
  CHECK(c.line.size() == 12);
  CHECK(c.line_deviation > 0.05);  // of single closings, not of the medians
  CHECK(c.line_deviation < 0.11);
}
