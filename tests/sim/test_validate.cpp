#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "sim/models/plant.h"
#include "sim/specimen/validate.h"

using namespace powbench::sim;

namespace {

bool reports(const Specimen& s, const std::string& key) {
  const auto errors = validate(s);
  return std::any_of(errors.begin(), errors.end(), [&](const auto& e) { return e.key == key; });
}

}  // namespace

TEST_CASE("the reference specimen is valid") {
  CHECK(validate(Specimen{}).empty());
}

TEST_CASE("every slip is named by its key") {
  Specimen s;
  s.core.mass = -0.1;
  CHECK(reports(s, "core.mass_g"));
  s = {};
  s.bridges.contact_stiffness = 0;
  CHECK(reports(s, "bridges.contact_stiffness_N_per_m"));
  s = {};
  s.bridges.gap = 2.51;  // mm given as m
  CHECK(reports(s, "bridges.gap_mm"));
  s = {};
  s.core.travel = s.bridges.gap;  // no overtravel
  CHECK(reports(s, "bridges.gap_mm"));
  s = {};
  s.bridges.tilt_gap = 2e-3;  // break B would never close
  CHECK(reports(s, "bridges.gap_mm"));
  s = {};
  s.magnet.shaded_share = 1.0;
  CHECK(reports(s, "magnet.shaded_share"));
  s.magnet.shaded_share = -0.1;
  CHECK(reports(s, "magnet.shaded_share"));
  s = {};
  s.bridges.poles = 0;
  CHECK(reports(s, "bridges.poles"));
  s = {};
  s.base.hertz = std::numeric_limits<double>::quiet_NaN();
  CHECK(reports(s, "base.mode_Hz"));
}

TEST_CASE("all errors come at once, each with value and range, and a plant refuses the specimen") {
  Specimen s;
  s.core.mass = 0;
  s.coil.turns = -5;
  s.magnet.residual_gap = 0;
  const auto errors = validate(s);
  REQUIRE(errors.size() == 3);
  for (const auto& e : errors) {
    CHECK_FALSE(e.value.empty());
    CHECK(e.range.find("..") != std::string::npos);
  }
  CHECK_THROWS_WITH(Plant(s, {}), Catch::Contains("core.mass_g") && Catch::Contains("coil.turns"));
}
