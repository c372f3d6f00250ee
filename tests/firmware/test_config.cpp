#include <catch2/catch.hpp>
#include <limits>

#include "bench/fault_bench.h"
#include "firmware/config_guard.h"

using namespace powbench;
using bench::FaultBench;
using firmware::config_error;
using firmware::ControllerConfig;

TEST_CASE("a configuration that cannot protect the coil is refused with its reason", "[fault]") {
  const std::size_t room = 9000 * channel_count;
  CHECK(config_error(FaultBench::make_config(), room).empty());
  const auto error = [&](void (*change)(ControllerConfig&)) {
    ControllerConfig c = FaultBench::make_config();
    change(c);
    return std::string(config_error(c, room));
  };
  CHECK(error([](auto& c) { c.sample_rate = 0; }).find("sample_rate") == 0);
  CHECK(error([](auto& c) { c.fire.sample_rate = 50'000; }).find("sample rates") == 0);
  CHECK(error([](auto& c) {
          c.phase.nominal_amplitude = std::numeric_limits<float>::quiet_NaN();
        }).find("nominal_amplitude") == 0);
  CHECK(error([](auto& c) { c.record_length = 9001; }).find("record_length") == 0);
  CHECK(error([](auto& c) { c.pretrigger = -1; }).find("pretrigger") == 0);
  CHECK(error([](auto& c) { c.fire.hold_limit_ms = 10'001; }).find("hold_limit_ms") == 0);
  CHECK(error([](auto& c) { c.fire.gate_delay_samples_256 = -1; }).find("gate delay") == 0);
  CHECK(error([](auto& c) { c.interlocks.overcurrent_counts = 32'768; }).find("current thresholds") == 0);
  CHECK(error([](auto& c) { c.interlocks.no_current_counts = 0; }).find("current thresholds") == 0);
  CHECK(error([](auto& c) { c.interlocks.mains_lost_counts = 0; }).find("mains_lost") == 0);
  CHECK(error([](auto& c) { c.interlocks.stuck_on_samples = 0; }).find("coil time") == 0);
  CHECK(error([](auto& c) { c.interlocks.heartbeat_samples = 0; }).find("heartbeat") == 0);
  CHECK(error([](auto& c) { c.fire.budget.operations_per_minute = 65; }).find("operations") == 0);
  CHECK(error([](auto& c) { c.fire.budget.duty_per_mille = 1001; }).find("budget") == 0);
}

TEST_CASE("a refused configuration never leaves fault", "[fault]") {
  ControllerConfig c = FaultBench::make_config();
  c.interlocks.heartbeat_samples = 0;
  std::vector<std::int16_t> storage(9000 * channel_count);
  firmware::Controller controller(c, storage);
  controller.fire_control().abort();
  CHECK(controller.fire_control().fault() == firmware::Fault::config_corrupt);
  CHECK(controller.fire_control().arm() == firmware::Refusal::faulted);
}

TEST_CASE("every single flipped bit of guarded bytes is found within two passes", "[fault]") {
  std::array<std::uint8_t, 70> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(31 * i);
  firmware::ConfigGuard guard(bytes);
  const int pass = 5;  // 70 bytes in steps of 16
  int found = 0;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
    bytes[bit / 8] ^= mask;
    for (int i = 0; i < 2 * pass; ++i) guard.step();
    found += guard.intact() ? 0 : 1;
    bytes[bit / 8] ^= mask;
    for (int i = 0; i < 2 * pass; ++i) guard.step();
    REQUIRE(guard.intact());
  }
  CHECK(found == 560);
}
