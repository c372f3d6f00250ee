#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "firmware/math.h"

using namespace powbench;
using namespace powbench::firmware;

TEST_CASE("sine and cosine stay within the stated error of the exact ones", "[phase][math]") {
  double worst = 0;
  for (int i = -400000; i <= 400000; ++i) {
    const float x = static_cast<float>(i) * 1e-5F;
    const double exact = 2 * pi * static_cast<double>(x);
    worst = std::max(worst, std::abs(static_cast<double>(sin_turns(x)) - std::sin(exact)));
    worst = std::max(worst, std::abs(static_cast<double>(cos_turns(x)) - std::cos(exact)));
  }
  INFO("worst " << worst);
  CHECK(worst <= 2.5e-7);
  CHECK(worst > 0);
}

TEST_CASE("sine hits its landmarks", "[phase][math]") {
  CHECK(sin_turns(0.0F) == 0.0F);
  CHECK(sin_turns(0.25F) == Approx(1.0).margin(1e-7));
  CHECK(sin_turns(-0.25F) == Approx(-1.0).margin(1e-7));
  CHECK(cos_turns(0.5F) == Approx(-1.0).margin(1e-7));
}

TEST_CASE("arctangent stays within the stated error all around and at all sizes", "[phase][math]") {
  double worst = 0;
  for (const float size : {1e-20F, 1e-3F, 1.0F, 3e4F, 1e18F}) {
    for (int i = -200000; i < 200000; ++i) {
      const double turns = static_cast<double>(i) / 400000.0;
      const auto y = static_cast<float>(static_cast<double>(size) * std::sin(2 * pi * turns));
      const auto x = static_cast<float>(static_cast<double>(size) * std::cos(2 * pi * turns));
      const double exact = std::atan2(static_cast<double>(y), static_cast<double>(x)) / (2 * pi);
      const double error = static_cast<double>(atan2_turns(y, x)) - exact;
      worst = std::max(worst, std::abs(error - std::round(error)));
    }
  }
  INFO("worst " << worst);
  CHECK(worst <= 6e-8);
  CHECK(atan2_turns(0.0F, 0.0F) == 0.0F);
  CHECK(atan2_turns(0.0F, -1.0F) == 0.5F);
  CHECK(atan2_turns(1.0F, 0.0F) == 0.25F);
  CHECK(atan2_turns(-1.0F, 0.0F) == -0.25F);
}

TEST_CASE("wrapping lands in its interval", "[phase][math]") {
  for (const float x : {-1e6F, -2.5F, -1.0F, -1e-9F, 0.0F, 0.5F, 0.99999994F, 1.0F, 7.25F, 1e6F}) {
    const float wrapped = wrap_turns(x);
    CHECK(wrapped >= 0.0F);
    CHECK(wrapped < 1.0F);
    const float half = wrap_half(x);
    CHECK(half >= -0.5F);
    CHECK(half < 0.5F);
  }
  CHECK(wrap_turns(7.25F) == 0.25F);
  CHECK(wrap_half(7.75F) == -0.25F);
  CHECK(wrap_turns(-2.25F) == 0.75F);
}

TEST_CASE("the square root is the correctly rounded one", "[phase][math]") {
  for (int i = 1; i < 100000; ++i) {
    const float x = static_cast<float>(i) * 0.37F;
    REQUIRE(square_root(x) == static_cast<float>(std::sqrt(static_cast<double>(x))));
  }
  CHECK(square_root(0.0F) == 0.0F);
  CHECK(square_root(-4.0F) == 0.0F);
}
