#include "host/import/counts.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/random.h"

using namespace powbench;
using namespace powbench::host;

namespace {

/// As a text of `digits` carries it.
double written(double v, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, v);
  return std::strtod(text, nullptr);
}

std::vector<bool> all(std::size_t n) {
  return std::vector<bool>(n, true);
}

}  // namespace

TEST_CASE("the grid of a converter is found behind the digits of a text") {
  Random random(1);
  for (const double step : {500.0 / 65536, 0.08, 2.5e-7, 1200.0 / 65536, 1.0}) {
    std::vector<double> v;
    for (int i = 0; i < 5000; ++i)
      v.push_back(written(step * (std::round(20 * random.normal() + (i % 7 == 0 ? 9000 : 0)) + 0.25), 9));
    ChannelRecord c;
    const CountsNote note = to_counts(v, all(v.size()), false, NAN, c);
    INFO(step);
    CHECK(note.grid);
    CHECK(c.scale == Approx(step).epsilon(1e-5));
    for (std::size_t i = 0; i < v.size(); i += 17) CHECK(c.value(i) == Approx(v[i]).margin(0.01 * step));
  }
}

TEST_CASE("numbers without a grid are rounded to a 64 000th of their range") {
  Random random(2);
  std::vector<double> v;
  for (int i = 0; i < 5000; ++i) v.push_back(3 + random.normal());
  ChannelRecord c;
  const CountsNote note = to_counts(v, all(v.size()), false, NAN, c);
  CHECK_FALSE(note.grid);
  for (std::size_t i = 0; i < v.size(); ++i) CHECK(std::abs(c.value(i) - v[i]) <= 0.5001 * c.scale);
  CHECK(c.scale < 1.3e-4);
}

TEST_CASE("one value, or none, makes a channel that is constant") {
  ChannelRecord c;
  to_counts(std::vector<double>(10, 2.5), all(10), true, NAN, c);
  for (std::size_t i = 0; i < 10; ++i) CHECK(c.value(i) == Approx(2.5));
  to_counts(std::vector<double>(10, 0.0), all(10), true, NAN, c);
  CHECK(c.value(3) == 0.0);
  to_counts(std::vector<double>(10, NAN), std::vector<bool>(10, false), true, NAN, c);
  CHECK(c.raw == std::vector<std::int16_t>(10, 0));
}

TEST_CASE("saturation is seen, a round peak and a plateau are not taken for it") {
  const auto pulse = [](double limit, double step) {
    std::vector<double> v;
    for (int i = 0; i < 4000; ++i) {
      const double s = i > 1000 && i < 2000 ? 10 * std::sin(3.14159265 * (i - 1000) / 1000) : 0.0;
      v.push_back(std::round(std::min(s, limit) / step) * step);
    }
    return v;
  };
  ChannelRecord c;
  CHECK(to_counts(pulse(5, 0.01), all(4000), true, NAN, c).clipped > 600);
  CHECK(c.value(1500) == Approx(5).margin(0.01));
  CHECK(c.raw[1500] >= c.clip_high);
  CHECK(c.raw[1050] < c.clip_high);
  CHECK(to_counts(pulse(20, 0.08), all(4000), true, NAN, c).clipped ==
        0);  // eight bits: a flat top is 127 samples wide
  std::vector<double> closed(4000, 0.0);
  std::fill(closed.begin() + 3500, closed.end(), 5.0);
  CHECK(to_counts(closed, all(4000), true, NAN, c).clipped == 0);
  std::vector<double> down = pulse(5, 0.01);
  for (double& v : down) v = -v;
  CHECK(to_counts(down, all(4000), true, NAN, c).clipped > 600);
  CHECK(c.raw[1500] <= c.clip_low);
}

TEST_CASE("a force that is saturated to the end of its record is told from one without noise") {
  Random random(3);
  for (const bool noise : {true, false}) {
    std::vector<double> v;
    for (int i = 0; i < 4000; ++i)
      v.push_back(std::min(10.0, (i > 1500 ? 12.0 : 0.0) + (noise ? 0.05 * random.normal() : 0)));
    ChannelRecord c;
    CHECK((to_counts(v, all(4000), true, NAN, c).clipped > 2400) == noise);
  }
}

TEST_CASE("stated limits are kept") {
  ChannelRecord c;
  std::vector<double> v;
  for (int i = 0; i < 100; ++i) v.push_back(0.1 * i);
  to_counts(v, all(100), false, NAN, c);
  set_clip(c, NAN, 8.0);
  CHECK(c.raw[79] < c.clip_high);
  CHECK(c.raw[80] >= c.clip_high);
  CHECK(c.raw[0] > c.clip_low);
}

TEST_CASE("counts of a known step come back as they were") {
  ChannelRecord c;
  const double step = 0.00762939453125;
  std::vector<double> v;
  for (const int k : {0, 3, -7, 26951, 12}) v.push_back(k * step * (1 + 1e-10));
  CHECK(to_counts(v, all(v.size()), false, step, c).grid);
  CHECK(c.scale == step);
  CHECK(c.offset == 0.0);
  CHECK(c.raw == std::vector<std::int16_t>{0, 3, -7, 26951, 12});
  v.push_back(0.4 * step);
  to_counts(v, all(v.size()), false, step, c);
  CHECK(c.scale != step);
}
