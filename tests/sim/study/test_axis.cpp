// What a sweep visits, and the numbers of a search as coordinates.

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/units.h"
#include "sim/study/axis.h"
#include "sim/study/parameter.h"

using namespace powbench::sim;
using Catch::Contains;

TEST_CASE("latin hypercube: every slice of every variable exactly once, for sizes that are no power of two") {
  for (const std::int64_t n : {1, 7, 100, 1000}) {
    const Design d({uniform_axis("angle_deg", 0, 1), uniform_axis("supply_volts", 0, 1)}, Sampling::latin, n,
                   5);
    for (std::size_t k = 0; k < 2; ++k) {
      std::set<std::int64_t> slices;
      for (std::int64_t i = 0; i < n; ++i)
        slices.insert(static_cast<std::int64_t>(std::floor(d.point(i)[k] * static_cast<double>(n))));
      CHECK(static_cast<std::int64_t>(slices.size()) == n);
    }
  }
}

TEST_CASE("grid: all combinations, ends included; points do not depend on one another") {
  const Design d({uniform_axis("angle_deg", 0, 90, 4), uniform_axis("supply_volts", 220, 240, 3)},
                 Sampling::grid, 1, 1);
  REQUIRE(d.size() == 12);
  std::set<std::vector<double>> all;
  for (std::int64_t i = 11; i >= 0; --i) all.insert(d.point(i));
  CHECK(all.size() == 12);
  CHECK(all.begin()->at(0) == 0);
  CHECK(all.rbegin()->at(0) == 90);
  CHECK(d.point(5) == d.point(5));
}

TEST_CASE("a normal variable has its mean and deviation, and ends at three of them") {
  const Design d({normal_axis("supply_volts", 230, 2)}, Sampling::latin, 4000, 2);
  double sum = 0, squares = 0, low = 1e9, high = 0;
  for (std::int64_t i = 0; i < d.size(); ++i) {
    const double v = d.point(i)[0];
    sum += v;
    squares += (v - 230) * (v - 230);
    low = std::min(low, v);
    high = std::max(high, v);
  }
  CHECK(sum / 4000 == Approx(230).margin(0.005));
  // cut at three deviations: 0.9866 of the deviation
  CHECK(std::sqrt(squares / 4000) == Approx(2 * 0.9866).epsilon(0.005));
  CHECK((low >= 224 && high <= 236));
}

TEST_CASE("variables: conditions in their units, numbers of the specimen by their keys") {
  Case c;
  variable("angle_deg").set(c, 90);
  CHECK(c.conditions.closing_angle == Approx(powbench::pi / 2));
  variable("ambient_degC").set(c, 40);
  CHECK(c.conditions.ambient == Approx(313.15));
  variable("core.mass_g").set(c, 150);
  CHECK(c.specimen.core.mass == Approx(0.15));
  CHECK(variable("core.mass_g").get(c) == Approx(150));
  CHECK_THROWS_WITH(variable("core.weight"), Contains("core.weight") && Contains("angle_deg"));
  CHECK_THROWS_WITH(uniform_axis("core.mass_g", 5, 1), Contains("core.mass_g") && Contains("ascending"));
  CHECK_THROWS_WITH(normal_axis("base.damping", 0.02, 0.02), Contains("base.damping"));
  CHECK_THROWS_AS(Design({}, Sampling::latin, 10, 1), std::invalid_argument);
  CHECK_THROWS_AS(Design({uniform_axis("angle_deg", 0, 1)}, Sampling::latin, 0, 1), std::invalid_argument);
}

TEST_CASE("parameters: value and coordinate are inverse, bounds are checked with names and ranges") {
  for (const bool logarithmic : {false, true}) {
    const Parameter p = parameter("core.stop_stiffness_N_per_m", 1e6, 1e8, logarithmic);
    for (const double u : {0.0, 0.3, 1.0}) CHECK(p.coordinate_of(p.value_at(u)) == Approx(u).margin(1e-12));
    CHECK(p.value_at(0.5) == Approx(logarithmic ? 1e7 : 5.05e7));
    CHECK(p.value_at(2) == p.value_at(1));
  }
  CHECK_THROWS_WITH(parameter("core.mass_g", 3, 2), Contains("core.mass_g") && Contains("ascending"));
  CHECK_THROWS_WITH(parameter("core.mass_g", -1, 2), Contains("allowed 5"));
  CHECK_THROWS_WITH(parameter("core.friction_N", 0, 2, true), Contains("logarithmic"));
  for (const auto& p : catalogue_parameters(true)) CHECK(p.low < p.high);
}
