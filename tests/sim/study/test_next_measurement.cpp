#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "sim/study/next_measurement.h"

using namespace powbench;
using namespace powbench::sim;

TEST_CASE("the most informative measurement first; what another told already adds nothing") {
  // two independent numbers a, b of a device; values a, 2 a, b, and one that is the same for all
  Random random(7);
  std::vector<std::vector<double>> samples;
  for (int k = 0; k < 4000; ++k) {
    const double a = random.normal(), b = random.normal();
    samples.push_back({a, 2 * a, b, 5.0});
  }
  const std::vector<double> u{0.5, 0.5, 0.5, 0.5};
  const auto list = most_informative(samples, u, 4);
  REQUIRE(list.size() == 3);  // the last one tells nothing
  CHECK(list[0].candidate == 1);
  CHECK(list[0].bits == Approx(0.5 * std::log2(1 + 4 / 0.25)).epsilon(0.02));
  CHECK(list[0].spread == Approx(2).epsilon(0.05));
  CHECK(list[1].candidate == 2);
  CHECK(list[1].bits == Approx(0.5 * std::log2(1 + 1 / 0.25)).epsilon(0.05));
  // a once 2 a is known to 0.5: variance 1 - 4 / 4.25
  CHECK(list[2].candidate == 0);
  CHECK(list[2].spread == Approx(std::sqrt(1 - 4 / 4.25)).epsilon(0.05));
  CHECK(list[0].left[0] == Approx(1 - 4 / 4.25).epsilon(0.05));
  // together they tell what a measurement of all at once tells: 1/2 log2 det(1 + C / u^2), C of a, 2 a and b
  double sum = 0;
  for (const auto& one : list) sum += one.bits;
  CHECK(sum == Approx(0.5 * std::log2((1 + 5 / 0.25) * (1 + 1 / 0.25))).epsilon(0.02));
  CHECK(most_informative(samples, u, 1).size() == 1);
  // one that is only watched is not chosen
  const std::vector<double> watched{0.5, std::numeric_limits<double>::infinity(), 0.5, 0.5};
  const auto two = most_informative(samples, watched, 4);
  REQUIRE(two.size() == 2);
  CHECK(two[0].candidate + two[1].candidate == 2);
  CHECK(two[1].left[1] == Approx(4 - 4 / 1.25).epsilon(0.05));
}
