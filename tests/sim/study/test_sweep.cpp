// Modes, sweeps, sensitivities and the best closing angle.

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/random.h"
#include "core/units.h"
#include "sim/study/modes.h"
#include "tests/sim/study/points.h"

using namespace powbench::sim;
using powbench::radians;
using powbench::Random;

TEST_CASE("modes: one for a uniform and for a normal sample, two for two hills, three for three") {
  Random random(8);
  std::vector<double> uniform, normal, two, three;
  for (int k = 0; k < 400; ++k) {
    uniform.push_back(random.uniform());
    normal.push_back(random.normal());
    two.push_back((k % 4 == 0 ? 6 : 0) + 0.5 * random.normal());
    three.push_back(4 * (k % 3) + 0.3 * random.normal());
  }
  CHECK(modes(uniform).size() == 1);
  CHECK(modes(normal).size() == 1);
  const auto m = modes(two);
  REQUIRE(m.size() == 2);
  CHECK(m[0].share == Approx(0.75));
  CHECK(m[0].mean == Approx(0).margin(0.1));
  CHECK(m[1].mean == Approx(6).margin(0.2));
  CHECK(modes(three).size() == 3);
  CHECK(modes(std::vector<double>(50, 3.0)).size() == 1);
  CHECK(modes({}).empty());
  CHECK(modes(std::vector<double>{std::nan(""), 1}).front().share == 1);
  // a few strays are no mode
  std::vector<double> strays(200, 1.0);
  strays[7] = 9;
  CHECK(modes(strays).size() == 1);
}

TEST_CASE("a sweep in parts and on several threads gives the bits of one in a piece") {
  const Case base;
  const Design d({uniform_axis("angle_deg", 0, 180), normal_axis("supply_volts", 230, 3)}, Sampling::latin,
                 24, 9);
  Team one(1), two(2);
  MetricOptions options;
  std::vector<std::int64_t> all(24);
  std::iota(all.begin(), all.end(), 0);
  const auto whole = run_points(d, base, all, options, one);
  const std::vector<std::int64_t> some{23, 10, 11, 4, 5, 6};
  const auto part = run_points(d, base, some, options, two);
  REQUIRE(part.size() == some.size());
  for (std::size_t k = 0; k < some.size(); ++k) {
    CHECK(part[k].touch == whole[static_cast<std::size_t>(some[k])].touch);
    CHECK(part[k].bounce == whole[static_cast<std::size_t>(some[k])].bounce);
  }
}

TEST_CASE("a sweep that is stopped ends what it has begun, and hands over each point once") {
  const Case base;
  const Design d({uniform_axis("angle_deg", 0, 180)}, Sampling::latin, 200, 9);
  std::vector<std::int64_t> all(200);
  std::iota(all.begin(), all.end(), 0);
  for (const double sample_dt : {0.0, 5e-6}) {
    Team two(2);
    MetricOptions options;
    options.sample_dt = sample_dt;
    std::vector<int> seen(all.size(), 0);
    std::atomic<int> handed = 0;
    stream_points(
        d, base, all, options, two,
        [&](std::size_t place, const ClosingMetrics& m) {
          CHECK(m.closed == 1);
          ++seen[place], ++handed;
        },
        [&] { return handed < 20; });
    CHECK(handed >= 20);
    CHECK(handed <= 20 + 2 * 8);  // what was in the lanes of two threads
    CHECK(*std::max_element(seen.begin(), seen.end()) == 1);
  }
}

TEST_CASE("metrics: what does not close has no times; forces come with samples") {
  Case c;
  c.conditions.supply_volts = 100;
  const auto none = closing_metrics(c, {});
  CHECK(none.closed == 0);
  CHECK(std::isnan(none.touch));
  c.conditions.supply_volts = 230;
  MetricOptions forces;
  forces.sample_dt = 5e-6;
  const auto m = closing_metrics(c, forces);
  CHECK(m.closed == 1);
  CHECK(m.settled == Approx(m.touch + m.bounce));
  CHECK(m.open_time <= m.bounce);
  CHECK(m.first_peak > 5);
  CHECK(m.impulse > 0);
  CHECK(std::isnan(closing_metrics(c, {}).first_peak));
}

TEST_CASE(
    "sensitivities have the signs of physics: more voltage is earlier, a hotter coil or a longer gap later") {
  Team team(2);
  const std::vector<double> angles{radians(0), radians(45)};
  const auto steps = usual_steps();
  for (const auto& row : sensitivities({}, angles, steps, *find_metric("touch"), {}, team)) {
    CAPTURE(row.name);
    if (row.name == "supply_volts") CHECK(row.high < row.low);
    if (row.name == "ambient_degC" || row.name == "bridges.gap_mm" || row.name == "core.mass_g" ||
        row.name == "core.friction_N")
      CHECK(row.high > row.low);
  }
}

TEST_CASE("best closing angle: between the extremes it was made of, with a gain over random closing") {
  Team team(2);
  BestAngleOptions options;
  options.angles = 12;
  options.draws = 4;
  options.bootstraps = 200;
  const std::vector<Axis> tolerances{normal_axis("supply_volts", 230, 1)};
  const auto b = best_angle({}, tolerances, *find_metric("bounce"), {}, options, team);
  REQUIRE(b.mean.size() == 12);
  for (std::size_t k = 0; k < 12; ++k) {
    CHECK(b.mean[k] >= b.mean[b.best]);
    CHECK((b.low[k] <= b.mean[k] + 1e-12 && b.mean[k] <= b.high[k] + 1e-12));
  }
  CHECK(b.gain > 0);
  CHECK((b.gain_low <= b.gain && b.gain <= b.gain_high));
  CHECK((b.confidence > 0 && b.confidence <= 1));
  CHECK((b.first <= b.angles[b.best] && b.angles[b.best] <= b.last));
  // reproducible
  CHECK(best_angle({}, tolerances, *find_metric("bounce"), {}, options, team).mean == b.mean);
}

TEST_CASE("devices that do not close are counted, and make no angle the best", "[sweep]") {
  Team team(2);
  BestAngleOptions options;
  options.angles = 6;
  options.draws = 40;
  options.bootstraps = 50;
  Case weak;
  weak.conditions.supply_volts = 150;
  const auto none =
      best_angle(weak, {normal_axis("core.mass_g", 200, 2)}, *find_metric("bounce"), {}, options, team);
  REQUIRE(none.closed.size() == 6);
  for (const std::size_t n : none.closed) CHECK(n == 0);
  for (const double m : none.mean) CHECK(std::isnan(m));
  options.angles = 12;
  for (const char* metric : {"bounce", "seat_velocity"}) {
    const auto some =
        best_angle({}, {normal_axis("supply_volts", 177, 4)}, *find_metric(metric), {}, options, team);
    const auto [least, most] = std::minmax_element(some.closed.begin(), some.closed.end());
    CAPTURE(metric, *least, *most);
    CHECK(*least < *most);
    CHECK(some.closed[some.best] == *most);
    for (std::size_t a = 0; a < some.angles.size(); ++a)
      if (some.closed[a] > 0) CHECK((some.low[a] <= some.mean[a] && some.mean[a] <= some.high[a]));
  }
}
