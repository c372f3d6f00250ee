#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "host/compare/curves.h"

using namespace powbench::host;

namespace {

struct Sampled {
  double t0 = -5e-3, dt = 1e-6;
  std::vector<float> values;
  template <class F>
  Sampled(F f, double start, double step, double end) : t0(start), dt(step) {
    for (double t = t0; t < end; t = t0 + dt * static_cast<double>(values.size()))
      values.push_back(static_cast<float>(f(t)));
  }
  Curve curve() const { return {t0, dt, values}; }
};

double hump(double t) {
  return t < 0 ? 0 : 3.0 * std::sin(100 * t) * std::sin(100 * t);
}

}  // namespace

TEST_CASE("curves: the largest difference, where it is, and its share of the measured value", "[compare]") {
  const Sampled measured([](double t) { return t < 0 ? 0.0 : 80 * t; }, -5e-3, 2e-6, 0.04);
  // a dent of 0.2 between 12 and 13 ms; sampled at another rate from another start
  const Sampled simulated(
      [](double t) { return t < 0 ? 0.0 : 80 * t - (t > 12e-3 && t < 13e-3 ? 0.2 : 0.0); }, -3e-3, 1e-6,
      0.05);
  const CurveDeviation d = curve_deviation(measured.curve(), simulated.curve(), 0.03);
  CHECK(d.largest == Approx(0.2).epsilon(1e-3));
  CHECK(d.at > 12e-3);
  CHECK(d.at < 13e-3);
  CHECK(d.measured == Approx(80 * d.at).epsilon(1e-3));
  CHECK(d.share() == Approx(0.2 / d.measured).epsilon(1e-3));
  CHECK(d.rms_share == Approx(0.2 * std::sqrt(10.0 / 300) / (80 * 0.0299)).epsilon(1e-2));
}

TEST_CASE("curves: a late curve is told as late, to second order of the delay", "[compare]") {
  const Sampled measured(hump, -5e-3, 1e-6, 0.06);
  for (const double late : {-0.2e-3, 0.05e-3, 0.2e-3}) {
    const Sampled simulated([&](double t) { return hump(t - late); }, -5e-3, 1e-6, 0.06);
    const CurveDeviation d = curve_deviation(measured.curve(), simulated.curve(), 0.05);
    CHECK(d.late == Approx(late).epsilon(2e-3));
    CHECK(d.largest == Approx(3.0 * 100 * std::fabs(late)).epsilon(2e-2));  // steepest slope: 300 a second
  }
}

TEST_CASE("curves: rest levels do not count, nor what was not measured; too little in common is unknown",
          "[compare]") {
  const Sampled measured(hump, -5e-3, 1e-6, 0.06);
  Sampled simulated([](double t) { return hump(t) + 0.7; }, -5e-3, 1e-6, 0.06);
  CHECK(curve_deviation(measured.curve(), simulated.curve(), 0.05).largest < 1e-5);
  for (std::size_t i = 20'000; i < 25'000; ++i) simulated.values[i] = std::nanf("");
  CHECK(curve_deviation(measured.curve(), simulated.curve(), 0.05).largest < 1e-5);
  CHECK(std::isnan(curve_deviation(measured.curve(), simulated.curve(), 0.9e-3).largest));
  CHECK(std::isnan(curve_deviation(measured.curve(), Curve{0, 1e-6, {}}, 0.05).largest));
  CHECK(std::isnan(curve_deviation(measured.curve(), simulated.curve(), -1).largest));
  CHECK_THROWS_AS(curve_deviation(Curve{0, 0, measured.values}, simulated.curve(), 0.05),
                  std::invalid_argument);
}

TEST_CASE("curves: repeats are shown by the shot in the middle", "[compare]") {
  const auto of = [](double largest) {
    CurveDeviation d;
    d.largest = largest;
    d.at = largest * 10;
    return d;
  };
  const CurveRow row = curve_row("x_m", "m", 1, {of(5), of(1), of(CurveDeviation::none), of(3), of(2)});
  CHECK(row.repeats == 4);
  CHECK(row.median.largest == 2);
  CHECK(row.median.at == 20);
  CHECK(curve_row("x_m", "m", 1, {}).repeats == 0);
}
