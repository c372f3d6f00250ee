// The lines below the tables that say how far bounces can be believed.

#include "host/study/bounce_text.h"
#include "sim/models/mechanics.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "sim/models/rigid_closing.h"

using namespace powbench;
using namespace powbench::host;

namespace {

BounceRow shaky() {
  BounceRow row{"k x 100", {}};
  row.study.error = {100, 1058, 2e-6, 30.29e-3, 3.11e-3};
  row.study.condition = {36.8, true, 29.93e-3};
  row.study.ensemble = {64, {28.8e-3, 28.7e-3, 28.8e-3, 28.9e-3}, {5e-3, 4e-3, 5e-3, 6e-3}, {}};
  return row;
}

}  // namespace

TEST_CASE("bounce lines: a computable closing has no ensemble, one that is not has it below", "[host]") {
  BounceRow calm{"60 degrees", {}};
  calm.study.error = {21, 21, 1.6e-11, 0.06, 6e-11};
  calm.study.condition = {0.0104, false, 0.06};
  calm.study.computable = true;
  const std::string text = bounce_text({calm, shaky()}, {});
  INFO(text);
  CHECK_THAT(text, Catch::Contains("21/21") && Catch::Contains("1.6e-05") && Catch::Contains("0.0104"));
  CHECK_THAT(text, Catch::Contains("100/1058") && Catch::Contains("twin leaves at 29.93 ms"));
  CHECK_THAT(text, Catch::Contains("64 runs, ms: first touch 28.800 (28.700 .. 28.900)"));
  CHECK(text.find("64 runs") > text.find("k x 100"));
  const std::string without = bounce_text({calm}, {});
  CHECK(without.find("runs") == std::string::npos);

  const auto json = nlohmann::json::parse(bounce_json({calm, shaky()}));
  CHECK_FALSE(json[0].contains("ensemble"));
  CHECK(json[1]["ensemble"]["open_time"]["q95_s"] == 6e-3);
  CHECK(json[1]["condition_s"] == 36.8);
}

TEST_CASE("a closing with its times: they stand above the lines, and agree with the simulation", "[host]") {
  sim::BounceStudyOptions o;
  o.end = 0.03;
  const auto rung = sim::closing_rungs().front();
  const BounceRow row = bounce_row(rung, "0 degrees", {}, o);
  REQUIRE(row.times.has_value());
  const auto closing = rung.run({}, o.end, 1e-10, 0);
  int opened = 0;
  double first = 0;
  for (const auto& e : sim::contact_events(closing.events)) {
    if (e.contact != 0) continue;
    if (first == 0) first = e.time;
    opened += !e.closes;
  }
  CHECK(row.times->touch == Approx(first).margin(1e-9));
  CHECK(row.times->bounces == opened);
  CHECK(row.times->last >= row.times->touch + row.times->open);
  const std::string text = bounce_text({row}, o);
  INFO(text);
  CHECK(text.find("touch ms") < text.find("events agree"));
  CHECK(nlohmann::json::parse(bounce_json({row}))[0]["bounces"] == opened);
}

TEST_CASE("bounces of every rung of a case", "[host]") {
  sim::BounceStudyOptions o;
  o.end = 0.03;
  const auto rungs = sim::closing_rungs();
  const auto rows = bounces_of(rungs, {}, o);
  REQUIRE(rows.size() == rungs.size());
  CHECK(rows[0].name == "circuit+plant");
  for (const auto& row : rows) {
    CHECK(row.study.error.reference > 4);
    CHECK(row.study.error.all());
    CHECK(row.study.condition.per_input > 1e-4);
  }
  CHECK(rows[0].study.condition.per_input == Approx(rows[1].study.condition.per_input).epsilon(0.1));
}
