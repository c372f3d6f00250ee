#include <catch2/catch.hpp>

#include "firmware/port/stm32g474/front_end.h"

/// One way from SI limits to counts, for every port.

using namespace powbench;
using namespace powbench::firmware;

TEST_CASE("limits in SI become counts and samples of the channel they are for", "[fault]") {
  CountScales scales;
  scales[index(Channel::coil_current)] = {1e-3, 40};
  scales[index(Channel::mains_voltage)] = {0.5, 0};
  scales[index(Channel::contact_a)] = {2e-3, -25};
  scales[index(Channel::laser)] = {1e-6, 300};
  const InterlockConfig c = interlock_config({}, scales, 50e3);
  CHECK(c.overcurrent_counts == 1800);
  CHECK(c.no_current_counts == 6);
  CHECK(c.current_zero_counts == 40);
  CHECK(c.no_current_samples == 240);
  CHECK(c.stuck_on_samples == 1250);
  CHECK(c.mains_lost_counts == 130);  // 0.2 sqrt(2) 230 V = 65.05 V
  CHECK(c.mains_lost_samples == 800);
  CHECK(c.heartbeat_samples == 12'500);
  CHECK(c.contact_open_counts == 1475);
  CHECK(c.contact_open_samples == 100);
  CHECK(c.weld_samples == 5000);
  CHECK(c.travel_least_counts == -500);  // the sensor's range has no zero to move with
  CHECK(c.travel_most_counts == 8000);
  CHECK(c.travel_open_counts == 800);
  CHECK(c.travel_closed_counts == 3500);
  CHECK(c.implausible_samples == 250);
}

TEST_CASE("a channel that exists and is not watched is no configuration", "[fault]") {
  ControllerConfig c = stm32g474::controller_config();
  const std::size_t room = 9000 * channel_count;
  REQUIRE(config_error(c, room).empty());
  const auto error = [&](void (*change)(ControllerConfig&)) {
    ControllerConfig changed = c;
    change(changed);
    return std::string(config_error(changed, room));
  };
  CHECK(error([](auto& x) { x.interlocks.contact_open_counts = 0; }).find("there is a contact") == 0);
  CHECK(error([](auto& x) {
          x.interlocks.travel_least_counts = x.interlocks.travel_most_counts = 0;
        }).find("there is a laser") == 0);
  CHECK(error([](auto& x) { x.interlocks.travel_closed_counts = 0; }).find("there are contact and laser") ==
        0);
  CHECK(error([](auto& x) { x.zero.quiet_counts = 0; }).find("zero capture") == 0);
  // without the channel there is nothing to watch
  CHECK(error([](auto& x) {
          x.calibration[index(Channel::contact_a)].scale_pico = 0;
          x.calibration[index(Channel::laser)].scale_pico = 0;
          x.interlocks.contact_open_counts = x.interlocks.travel_closed_counts = 0;
          x.interlocks.travel_least_counts = x.interlocks.travel_most_counts = 0;
        }).empty());
}

TEST_CASE("the board's thresholds are those of its circuit, worked out by hand", "[fault]") {
  constexpr ControllerConfig c = stm32g474::controller_config();
  // 1.8 A are 1.35 V, 6 mA 4.5 mV, 3 V of contact 0.9 V, 0.5 mm 0.15 V; 65536 counts over 3.3 V, half as many one-sided
  CHECK(c.interlocks.overcurrent_counts == 26'810);
  CHECK(c.interlocks.no_current_counts == 89);
  CHECK(c.interlocks.mains_lost_counts == 3230);
  CHECK(c.interlocks.contact_open_counts == 8937);
  CHECK(c.interlocks.travel_open_counts == 1489);
  CHECK(c.interlocks.travel_closed_counts == 9533);
  CHECK(c.interlocks.travel_least_counts == 298);
  CHECK(c.interlocks.travel_most_counts == 29'491);
}
