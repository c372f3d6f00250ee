#include <catch2/catch.hpp>

#include "tests/pil/emulated.h"

/// Software in the loop against processor in the loop: the same firmware, compiled for this machine and for
/// the Cortex-M4F, must take every decision alike, to the last bit.

using namespace powbench;
using namespace powbench::rigs;
using namespace powbench::test;

namespace {

/// What a run leaves behind: the state hash after every slice of time, every answer, every edge.
struct Trace {
  std::vector<std::uint32_t> hashes;
  std::string answers, context;
  std::vector<std::int64_t> edges;  ///< sample, fraction, level; one after the other
  bool operator==(const Trace&) const = default;
};

Trace shoot(BoardOptions options, const SimRigConfig& config, int centi_degrees) {
  options.boot_id = "alike";  // it stands in every sealed shot
  Client client(options, config);
  Trace trace;
  const auto note = [&](const std::string& answer) {
    trace.answers += answer;
    trace.hashes.push_back(client.world.board().report().state_hash);
  };
  for (int shot = 0; shot < 2; ++shot) {
    note(client.control("OUTPUT phase0 raw", std::to_string(10000 + centi_degrees)));
    note(client.control("hold_time_ms", "60"));
    note(client.control("arm", "1"));
    note(client.ask("READ iio:device0 sealed_shot\r\n"));
    note(client.control("fire", "1"));
    while (client.world.busy()) {
      client.world.run(0.002);
      note({});
    }
    for (const auto& e : client.world.scheduled())
      trace.edges.insert(trace.edges.end(), {e.at.sample, e.at.fraction, e.on});
    note(
        client.ask("READ iio:device1 state\r\nREAD iio:device1 last_error\r\nREAD iio:device0\r\n"
                   "READ iio:device2\r\n"));
    note(client.ask("OPEN iio:device0 14000 1ff\r\nREADBUF iio:device0 280000\r\n"));
    client.world.board().close(0);
    note(client.control("abort", "1"));
  }
  trace.context = client.ask("PRINT\r\n");
  trace.context.erase(0, trace.context.find('\n'));  // its length: the two say differently who they are
  for (std::size_t i; (i = trace.context.find("\"qemu\"")) != std::string::npos;)
    trace.context.replace(i, 6, "\"sim\"");
  return trace;
}

}  // namespace

TEST_CASE("states, edges, answers and records equal those of the native firmware", "[pil]") {
  if (!emulator_wanted()) return;
  SimRigConfig config;
  int angle = 0;
  std::string ends_in = "fault";
  SECTION("a shot") {
    angle = 4567;
    ends_in = "captured";
  }
  SECTION("a shot with scatter") {
    angle = 12345;
    config.scatter = {.supply = 0.01, .coil_temperature = 3.0, .friction = 0.1, .gap = 1e-5};
    ends_in = "captured";
  }
  SECTION("a coil that is interrupted") {
    config.faults.coil_open = true;
  }
  SECTION("samples that are lost") {
    config.faults.lost_samples = 3;
  }
  SECTION("a mains far too low") {
    config.faults.mains_dip = 0.4;
  }

  const Trace wanted = shoot(native, config, angle);
  CHECK(wanted.answers.find(ends_in) != std::string::npos);
  for (const BoardOptions& options : {emulated_board, counting}) {
    INFO((options.count_instructions ? "with" : "without") << " instruction counting");
    const Trace got = shoot(options, config, angle);
    CHECK(got.hashes == wanted.hashes);
    CHECK(got.edges == wanted.edges);
    CHECK((got.answers == wanted.answers));  // in parentheses: they are long, and not text
    CHECK(got.context == wanted.context);
  }
}

TEST_CASE("the state hash notices a single decision that differs", "[pil]") {
  const Trace one = shoot(native, {}, 4567), other = shoot(native, {}, 4568);
  CHECK(one.hashes != other.hashes);
  CHECK(one.hashes == shoot(native, {}, 4567).hashes);
}
