#include <catch2/catch.hpp>

#include "firmware/identity.h"
#include "firmware/port/stm32g474/front_end.h"
#include "tests/firmware/bench_fixture.h"

/// What every shot says about its maker.

using namespace powbench;
using namespace powbench::firmware;

TEST_CASE("the checksum of a configuration changes with every field that decides a shot", "[identity]") {
  const ControllerConfig base = stm32g474::controller_config();
  const std::uint32_t whole = config_crc32(base);
  CHECK(config_crc32(base) == whole);
  const auto changed = [&](void (*change)(ControllerConfig&)) {
    ControllerConfig c = base;
    change(c);
    return config_crc32(c) != whole;
  };
  CHECK(changed([](auto& c) { c.record_length += 1; }));
  CHECK(changed([](auto& c) { c.calibration[3].zero_counts = 1; }));
  CHECK(changed([](auto& c) { c.calibration[7].scale_pico += 1; }));
  CHECK(changed([](auto& c) { c.calibration_id = "nominam"; }));
  CHECK(changed([](auto& c) { c.phase.nominal_amplitude += 1.0F; }));
  CHECK(changed([](auto& c) { c.fire.gate_delay_samples_256 += 1; }));
  CHECK(changed([](auto& c) { c.fire.budget.duty_per_mille += 1; }));
  CHECK(changed([](auto& c) { c.interlocks.contact_open_counts += 1; }));
  CHECK(changed([](auto& c) { c.interlocks.saturation_counts += 1; }));
  // the same text elsewhere in memory is the same configuration
  const std::string copy = "nominal";
  ControllerConfig c = base;
  c.calibration_id = copy;
  CHECK(config_crc32(c) == whole);
}

TEST_CASE("a client can read who made a shot", "[identity]") {
  test::Bench b;
  CHECK(b.ask("READ contactor-daq fw_commit\r\n").find("none") == 2);
  b.controller.identify({.commit = "abc", .board_id = "17", .image_crc32 = 0x1234ABCD});
  CHECK(b.ask("READ contactor-daq image_crc32\r\n").find("1234abcd") == 2);
  CHECK(b.ask("READ contactor-daq board_id\r\n").find("17") == 2);
  TextOf<16> crc;
  crc.put_hex32(shot_identity(b.controller).config_crc32);
  CHECK(b.ask("READ contactor-daq config_crc32\r\n").find(std::string(crc.view())) == 2);
}
