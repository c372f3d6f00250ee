#include "host/import/calibration.h"

#include <catch2/catch.hpp>

#include "core/units.h"
#include "host/config/bad_input.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

std::string complaint(const std::string& text) {
  try {
    parse_calibration(text, "shot.toml");
    return "";
  } catch (const BadInput& e) {
    return e.what();
  }
}

}  // namespace

TEST_CASE("a calibration file reads into SI") {
  const Calibration k = parse_calibration(
      "calibration = \"films\"\nvalid_until = \"2030-01-31\"\nswitch_on_s = 0.25\nhold_ms = 80\n"
      "[pvdf_a]\ngain_N_per_V = -10\ncorner_hertz = 0.5\ndelay_us = 7.5\ncrosstalk_percent = 3\n"
      "[laser]\ngain_mm_per_V = 2\nclip_high = 4.9\n",
      "shot.toml");
  CHECK(k.id == "films");
  CHECK(k.switch_on == 0.25);
  CHECK(k.hold_time == Approx(0.08));
  CHECK(k.of(Channel::pvdf_a).gain == -10);
  CHECK(k.of(Channel::pvdf_a).delay == Approx(7.5e-6));
  CHECK(k.of(Channel::pvdf_a).crosstalk == Approx(0.03));
  CHECK(k.of(Channel::laser).gain == Approx(2e-3));
  CHECK(k.of(Channel::laser).clip_high == 4.9);
  CHECK(std::isnan(k.of(Channel::pvdf_b).gain));
}

TEST_CASE("mistakes are named with line, key and range, all at once") {
  const std::string said = complaint(
      "calibraton = \"x\"\nvalid_until = \"31.1.2030\"\n[pvdf_a]\ngain_N_per_V = 0\ncrosstalk_percent = 80\n"
      "[laser]\ngain_N_per_V = 1\nclip_low = 2\nclip_high = 1\n");
  CHECK_THAT(said, Contains("shot.toml:1") && Contains("did you mean 'calibration'"));
  CHECK_THAT(said, Contains("shot.toml:2") && Contains("2030-12-31"));
  CHECK_THAT(said, Contains("makes every value zero"));
  CHECK_THAT(said, Contains("crosstalk_percent = 80") && Contains("-50..50"));
  CHECK_THAT(said, Contains("clip_low"));
  CHECK_THAT(complaint("[lazer]\n"), Contains("lazer"));
  CHECK_THAT(complaint("[pvdf_a\n"), Contains("shot.toml:1"));
}

TEST_CASE("a decimal comma is named as what is wrong, and only one") {
  for (const char* number : {"0,1", "-12,5 # A/V", "+0,001"})
    CHECK_THAT(complaint(std::string("hold_ms = 80\n[coil_current]\ngain_A_per_V = ") + number + "\n"),
               Contains("shot.toml:3: not TOML") && Contains("write a decimal point, not a comma"));
  CHECK_THAT(complaint("[coil_current]\ngain_A_per_V = = 1\n"), Contains("not TOML") && !Contains("decimal"));
  CHECK_THAT(complaint("[coil_current]\ngain_A_per_V = 1, 2\n"),
             Contains("not TOML") && !Contains("decimal"));
}

TEST_CASE("a calibration without a name, or past its last day, is not in force") {
  Calibration k;
  CHECK_FALSE(in_force(k, "2026-01-01"));
  k.id = "films";
  CHECK(in_force(k, "2026-01-01"));
  k.valid_until = "2026-01-01";
  CHECK(in_force(k, "2026-01-01"));
  CHECK_FALSE(in_force(k, "2026-01-02"));
  k.recorded = "2025-12-31";
  CHECK(in_force(k, "2026-01-02"));  // the day of the record counts, not that of the evaluation
}

TEST_CASE("the template and an exported calibration read back") {
  CHECK_NOTHROW(parse_calibration(calibration_template(), "template"));
  Record r;
  r.calibration = "bench 7";
  r.conditions.closing_angle = radians(60);
  r.channels.push_back(
      {.channel = Channel::pvdf_b, .raw = {}, .scale = -0.01, .delay = 12e-6, .corner_hertz = 0.5});
  r.channels.back().clip_high = 2000;
  const Calibration k = parse_calibration(calibration_of(r, ""), "shot.toml");
  CHECK(k.id == "bench 7");
  CHECK(k.closing_angle == Approx(radians(60)));
  CHECK(k.of(Channel::pvdf_b).delay == 12e-6);
  CHECK(k.of(Channel::pvdf_b).corner_hertz == 0.5);
  CHECK(k.of(Channel::pvdf_b).clip_low == Approx(-20));
}
