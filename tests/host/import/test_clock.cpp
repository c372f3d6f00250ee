#include "host/import/clock.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace powbench;
using namespace powbench::host;

namespace {

std::vector<double> stamps(std::size_t n, auto&& at) {
  std::vector<double> t;
  for (std::size_t i = 0; i < n; ++i) t.push_back(at(static_cast<double>(i)));
  return t;
}

}  // namespace

TEST_CASE("stamps that are not finite, repeated or falling are named by their row") {
  CHECK(check_stamps(std::vector<double>{0, 1, 2}).what.empty());
  CHECK(check_stamps(std::vector<double>{0, 1, 1}).row == 2);
  CHECK(check_stamps(std::vector<double>{0, 2, 1}).row == 2);
  CHECK(check_stamps(std::vector<double>{0, NAN, 1}).row == 1);
  CHECK_FALSE(check_stamps(std::vector<double>{INFINITY, 1}).what.empty());
}

TEST_CASE("even stamps are taken as they are, at the round rate behind their digits") {
  for (const double rate : {1e6, 200e3, 20e3, 44.1e3, 12.5e6, 2500.0}) {
    const UniformClock c = find_clock(stamps(5000, [&](double i) { return -0.02 + 1.7e-6 + i / rate; }));
    INFO(rate);
    CHECK(c.even);
    CHECK(c.rate == rate);
    CHECK(c.n == 5000);
    CHECK(c.t0 == Approx(-0.02 + 1.7e-6).margin(1e-12));
    CHECK(c.error < 1e-12);
    CHECK(c.gaps.empty());
  }
}

TEST_CASE("stamps rounded to few digits still make an even clock") {
  // 2.5 us apart, written with one digit too few: 0, 2, 5, 8, 10 us ..
  const auto t = stamps(8000, [](double i) { return std::round(2.5 * i) * 1e-6; });
  const UniformClock c = find_clock(t);
  CHECK(c.even);
  CHECK(c.rate == Approx(400e3).epsilon(1e-6));
  CHECK(c.error <= 0.55e-6);
  CHECK(c.n == 8000);
}

TEST_CASE("dropped ticks are gaps, and the clock goes on behind them") {
  std::vector<double> t;
  for (int i = 0; i < 1000; ++i)
    if (i < 300 || (i > 400 && i != 777)) t.push_back(i * 1e-5);
  const UniformClock c = find_clock(t);
  REQUIRE(c.even);
  CHECK(c.n == 1000);
  REQUIRE(c.gaps.size() == 2);
  CHECK(c.gaps[0].first == 300);
  CHECK(c.gaps[0].count == 101);
  CHECK(c.gaps[1].first == 777);
  CHECK(c.gaps[1].count == 1);
  CHECK(c.tick.back() == 999);
}

TEST_CASE("uneven stamps are resampled: a curve within the correction that is stated") {
  Random random(4);
  const auto t = stamps(4000, [&](double i) { return 1e-5 * (i + 0.4 * random.uniform()); });
  const UniformClock c = find_clock(t);
  REQUIRE_FALSE(c.even);
  CHECK(c.rate == Approx(1e5).epsilon(0.03));
  std::vector<double> v;
  const auto curve = [](double x) { return 10 * std::sin(2 * 3.14159265 * 800 * x); };
  for (const double x : t) v.push_back(curve(x));
  double correction = 0, worst = 0;
  const auto y = resample(c, t, v, correction);
  REQUIRE(y.size() == c.n);
  for (std::size_t k = 2; k + 2 < c.n; ++k) worst = std::max(worst, std::abs(y[k] - curve(c.time(k))));
  CHECK(worst < 1e-3);  // a straight line is wrong by up to 7e-3
  CHECK(correction > worst);
  CHECK(correction < 3e-2);
}

TEST_CASE("a rest between bursts is a gap") {
  std::vector<double> t;
  Random random(5);
  for (int i = 0; i < 500; ++i) t.push_back(1e-6 * (i + 0.3 * random.uniform()));
  for (int i = 0; i < 500; ++i) t.push_back(2e-3 + 1e-6 * (i + 0.3 * random.uniform()));
  const UniformClock c = find_clock(t);
  REQUIRE(c.gaps.size() == 1);
  CHECK(static_cast<double>(c.gaps[0].first) / c.rate == Approx(500e-6).margin(5e-6));
  CHECK(static_cast<double>(c.gaps[0].first + c.gaps[0].count) / c.rate == Approx(2e-3).margin(5e-6));
}

TEST_CASE("values that are not finite take no part in resampling") {
  const std::vector<double> t{0, 1, 2.4, 3, 4.2, 5};
  UniformClock c;
  c.rate = 1;
  c.n = 6;
  double correction = 0;
  for (const double v : resample(c, t, std::vector<double>{1, NAN, 1, 1, NAN, 1}, correction))
    CHECK(v == 1.0);
  for (const double v : resample(c, t, std::vector<double>{NAN, NAN, 7, NAN, NAN, NAN}, correction))
    CHECK(v == 7.0);
}
