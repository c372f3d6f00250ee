#include <catch2/catch.hpp>
#include <cmath>

#include "host/study/held_out.h"
#include "sim/models/closing.h"

using namespace powbench;
using namespace powbench::host;

TEST_CASE("predictions: the median of the specimens that close, nothing where most do not", "[study]") {
  sim::Specimen dead;
  dead.core.return_preload = 500;
  const std::vector<sim::Specimen> two{{}, {}, dead};
  const Prediction p = predict(two, {});
  const auto t = sim::simulate({}, {}, 0.06, 0).truth;
  CHECK(p.touch.median == *t.touch);
  CHECK((p.touch.low == p.touch.high));
  const std::vector<sim::Specimen> mostly_dead{{}, dead, dead};
  CHECK(std::isnan(predict(mostly_dead, {}).touch.median));
}

TEST_CASE("a specimen that is not usable, as a search may try, is one that does not close", "[study]") {
  sim::Specimen wide;
  wide.bridges.gap = 1.1 * wide.core.travel;
  REQUIRE_THROWS(sim::simulate(wide, {}, 0.05, 0));
  CHECK_FALSE(sim::tried_closing(wide, {}, 0.05).touch);
  CHECK(sim::tried_closing({}, {}, 0.05).touch == sim::simulate({}, {}, 0.05, 0).truth.touch);
  CHECK(predict(std::vector<sim::Specimen>{{}, {}, wide}, {}).touch.median > 0);
}

TEST_CASE("a calibrated prediction: bounce by its factors and what the others say, settled time by adding up",
          "[study]") {
  std::vector<sim::Specimen> list(3);
  list[1].bridges.gap += 0.1e-3;
  list[2].bridges.gap += 0.2e-3;
  const Prediction plain = predict(list, {});
  sim::BounceCalibration c;
  c.factors = {2, 2, 2};
  const Prediction alone = predict(list, {}, c);  // no deviations: samples times factors, nothing pooled
  CHECK(alone.bounce.median == Approx(2 * plain.bounce.median));
  CHECK(alone.bounce.high == Approx(2 * plain.bounce.high));
  CHECK(alone.touch.median == plain.touch.median);
  CHECK(alone.seat.low == plain.seat.low);
  c.deviation = c.median_deviation = 0.2;
  c.median = 3e-3;
  const Prediction p = predict(list, {}, c);
  CHECK(p.bounce.median == Approx(std::sqrt(2 * plain.bounce.median * 3e-3)));
  // Student's quantile at 0.84 with 1.2 degrees of freedom, by adaptive quadrature and bisection
  constexpr double side = 0.63 * 1.6225308528;
  CHECK(p.bounce.high == Approx(p.bounce.median * std::exp(side * 0.2 / std::sqrt(2.0))));
  CHECK(p.settled.median == Approx(p.touch.median + p.bounce.median));
  CHECK(p.settled.high - p.settled.median ==
        Approx(std::hypot(p.touch.high - p.touch.median, p.bounce.high - p.bounce.median)));
}

TEST_CASE(
    "the band of a value that is measured is wider than that of the specimens by what one value deviates",
    "[study]") {
  const std::vector<sim::Specimen> same(5);
  const Prediction bare = predict(same, {}), p = predict(same, {}, {}, {0.03, 0.02});
  constexpr double one_sided = 0.99445788;  // normal quantile at 0.84
  CHECK(p.touch.median == bare.touch.median);
  CHECK(p.touch.high / p.touch.median == Approx(1 + 0.03 * one_sided).epsilon(1e-7));
  CHECK(p.touch.low / p.touch.median == Approx(1 - 0.03 * one_sided).epsilon(1e-7));
  CHECK(p.seat.high / p.seat.median == Approx(1 + 0.02 * one_sided).epsilon(1e-7));
  CHECK(p.bounce.high == bare.bounce.high);
  auto wide = same;
  wide[3].bridges.gap += 0.3e-3, wide[4].bridges.gap += 0.6e-3;
  const Prediction alone = predict(wide, {}), both = predict(wide, {}, {}, {0.03, 0});
  CHECK(both.touch.low < alone.touch.low);
  CHECK(both.touch.high > alone.touch.high);
  CHECK(both.seat.high == alone.seat.high);
}
