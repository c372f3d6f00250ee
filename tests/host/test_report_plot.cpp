#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "host/report/decimate.h"
#include "host/report/plot.h"
#include "tests/host/report_xml_check.h"

using namespace powbench;
using namespace powbench::host;

TEST_CASE("ticks are round and inside the range", "[report]") {
  const Ticks t = nice_ticks({-2, 30}, 10);
  CHECK(t.at == std::vector<double>{0, 5, 10, 15, 20, 25, 30});
  CHECK(nice_ticks({-2, 30}, 14).at.size() == 17);
  CHECK(nice_ticks({-2, 30}, 14).at.front() == -2);
  CHECK(t.decimals == 0);
  CHECK(nice_ticks({0, 0.3}, 3).at == std::vector<double>{0, 0.1, 0.2, 3 * 0.1});
  CHECK(nice_ticks({0, 0.3}, 3).decimals == 1);
  CHECK(nice_ticks({1e-6, 4e-6}, 4).decimals == 6);
  for (const double span : {1e-12, 3.3e-5, 0.7, 42.0, 9.9e8}) {
    const Ticks n = nice_ticks({1.5 * span, 2.5 * span}, 5);
    CHECK(n.at.size() >= 3);
    CHECK(n.at.size() <= 11);
    CHECK(n.at.front() >= 1.5 * span * (1 - 1e-8));
    CHECK(n.at.back() <= 2.5 * span * (1 + 1e-8));
  }
}

TEST_CASE("ticks of a degenerate range are none", "[report]") {
  CHECK(nice_ticks({}, 5).at.empty());
  CHECK(nice_ticks({2, 2}, 5).at.empty());
  CHECK(nice_ticks({0, std::numeric_limits<double>::infinity()}, 5).at.empty());
  CHECK(ticks_every({0, 1}, 0).at.empty());
  CHECK(ticks_every({0, 1e9}, 1e-3).at.empty());  // a million labels help nobody
}

TEST_CASE("a range ignores what is not finite and never has zero width after padding", "[report]") {
  Range r;
  r.include(std::nan(""));
  CHECK(r.empty());
  CHECK(r.padded(0.1).span() == 1);
  r.include(3);
  r.include(std::numeric_limits<double>::infinity());
  CHECK(r.low == 3);
  CHECK(r.high == 3);
  CHECK(r.padded(0.1, 0.5).span() == 1);
}

TEST_CASE("decimation keeps every extreme", "[report]") {
  Random random(11);
  std::vector<float> v(20000);
  for (auto& x : v) x = static_cast<float>(random.normal());
  v[12345] = 99.0F;  // a single-sample spike each way
  v[777] = -77.0F;
  const auto points = decimate(v, -5e-3, 1e-6, -1, 1, 500);
  CHECK(points.size() <= 1000);
  const auto by_value = [](const TracePoint& a, const TracePoint& b) { return a.value < b.value; };
  const auto [low, high] = std::minmax_element(points.begin(), points.end(), by_value);
  CHECK(low->value == -77.0);
  CHECK(high->value == 99.0);
  CHECK(high->t == Approx(-5e-3 + 12345e-6));
  CHECK(std::is_sorted(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.t < b.t; }));
  // in every bucket, against the plain definition
  for (std::size_t b = 0; b < 500; ++b) {
    const auto part = std::minmax_element(v.begin() + static_cast<long>(b * 40),
                                          v.begin() + static_cast<long>((b + 1) * 40));
    const auto has = [&](float x) {
      return std::any_of(points.begin(), points.end(),
                         [&](const TracePoint& p) { return p.value == static_cast<double>(x); });
    };
    REQUIRE(has(*part.first));
    REQUIRE(has(*part.second));
  }
}

TEST_CASE("decimation: short, cut, broken and impossible traces", "[report]") {
  const std::vector<float> v{0, 1, 2, 3, 4, 5};
  CHECK(decimate(v, 0, 1, -10, 10, 100).size() == 6);
  const auto cut = decimate(v, 0, 1, 1.5, 4, 100);
  REQUIRE(cut.size() == 3);
  CHECK(cut.front().t == 2);
  CHECK(cut.back().t == 4);
  CHECK(decimate(v, 0, 1, 50, 60, 100).empty());
  CHECK(decimate(v, 0, 1, -60, -50, 100).empty());
  CHECK(decimate(v, 0, 0, -1, 1, 100).empty());
  CHECK(decimate({}, 0, 1, -1, 1, 100).empty());
  CHECK(decimate(v, 0, 1, 0, 5, 0).empty());

  const float hole = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> broken{1, hole, hole, 2, 3};
  const auto points = decimate(broken, 0, 1, 0, 10, 100);
  REQUIRE(points.size() == 3);
  CHECK(points[0].starts);
  CHECK(points[1].starts);
  CHECK_FALSE(points[2].starts);
}

TEST_CASE("a plot survives values that are not finite or far outside", "[report]") {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  Plot plot({60, 20, 800, 200}, {0, 10}, {5, 5});
  plot.line({{0, 1}, {nan, 2}, {3, inf}, {4, 1e300}, {5, -1e300}}, {});
  plot.point({nan, 0}, {});
  plot.point({1, inf}, {});
  plot.error_bar({1, 5}, nan, {});
  plot.error_bar({1, 5}, -1, {});
  plot.vertical(nan, {});
  plot.bar(0, inf, 0, 1, colour::measured, 1);
  plot.trace({{0, nan, true}, {1, 5, false}}, 1, {});
  plot.note(nan, "x", colour::ink, 0);
  const std::string svg = figure(900, 260, "a < b", {plot.finish()}).str();
  CHECK(test::xml_error(svg).empty());
  for (const char* bad : {"nan", "inf", "e+"}) CHECK(svg.find(bad) == std::string::npos);
  CHECK(svg.find("<title>a &lt; b</title>") != std::string::npos);
}

TEST_CASE("points are drawn where they belong", "[report]") {
  Plot plot({100, 10, 200, 100}, {0, 10}, {-1, 1});
  plot.line({{0, -1}, {10, 1}}, {});
  CHECK(plot.finish().str().find("d=\"M100 110L300 10\"") != std::string::npos);
}
