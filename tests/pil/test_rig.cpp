#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdio>

#include "core/units.h"
#include "rigs/iio_rig.h"
#include "rigs/iiod_server.h"
#include "rigs/registry.h"
#include "tests/pil/emulated.h"

/// The emulated board as a rig like any other: through libiio, and through Debian's own tools.

using namespace powbench;
using namespace powbench::rigs;
using namespace powbench::test;
using namespace std::chrono_literals;

namespace {

std::string run(const std::string& command) {
  FILE* pipe = popen(("( " + command + " ) 2>&1").c_str(), "r");
  REQUIRE(pipe);
  std::string output;
  char bytes[4096];
  while (const std::size_t n = std::fread(bytes, 1, sizeof bytes, pipe)) output.append(bytes, n);
  pclose(pipe);
  return output;
}

}  // namespace

TEST_CASE("a qemu: shot is the sim: shot, to the last bit of the record", "[pil]") {
  if (!emulator_wanted()) return;
  const auto emulated = open("qemu:", {}, {});
  const auto in_process = open("sim:", {}, {});
  CHECK(emulated->info().kind == "qemu");
  CHECK(emulated->info().channels.size() == channel_count);
  for (const double angle_deg : {0.0, 77.7, 210.0}) {
    INFO(angle_deg << " deg");
    Conditions c;
    c.closing_angle = radians(angle_deg);
    c.seed = 21;
    const Shot a = in_process->fire(c, 20s), b = emulated->fire(c, 20s);
    REQUIRE(a.outcome == Outcome::pass);
    REQUIRE(b.outcome == Outcome::pass);
    CHECK(a.record.crc32 == b.record.crc32);
    CHECK(a.record.fire_sample == b.record.fire_sample);
    CHECK(a.record.fire_offset == b.record.fire_offset);
    REQUIRE(a.record.channels.size() == b.record.channels.size());
    for (std::size_t i = 0; i < channel_count; ++i) {
      CHECK((a.record.channels[i].raw == b.record.channels[i].raw));
      CHECK(a.record.channels[i].scale == b.record.channels[i].scale);
    }
  }
}

TEST_CASE("Debian's tools talk to the emulated board", "[pil]") {
  if (!emulator_wanted()) return;
  LocalRig rig({}, {}, emulated_board);
  const std::string uri = " -u ip:" + rig.address() + " ";
  const auto attr = [&](const std::string& what) { return run("timeout 20 iio_attr" + uri + what); };

  const std::string info = run("timeout 20 iio_info" + uri);
  for (const char* bad : {"WARN", "ERROR", "invalid", "Unable", "UNKNOWN"}) {
    INFO(bad << "\n" << info);
    CHECK(info.find(bad) == std::string::npos);
  }
  CHECK(info.find("contactor-daq (label: record) (buffer capable)") != std::string::npos);
  CHECK(info.find("bench,kind: qemu") != std::string::npos);

  attr("-d contactor-ctl lease 'k7 30000 anna'");
  attr("-c contactor-ctl phase0 raw '9000 k7'");
  attr("-d contactor-ctl arm '1 k7'");
  attr("-d contactor-ctl fire '1 k7'");
  for (int i = 0; i < 200 && attr("-d contactor-ctl state") != "captured\n"; ++i) {
  }
  REQUIRE(attr("-d contactor-ctl state") == "captured\n");
  CHECK(run("timeout 20 iio_readdev" + uri + "-b 256 -s 512 contactor-daq voltage0 voltage1 | wc -c") ==
        "2048\n");
  CHECK(run("timeout 20 iio_readdev" + uri + "-b 1000 -s 14000 contactor-daq | wc -c") == "336000\n");
  CHECK(attr("-c contactor-ctl phase0 raw '36000 k7'").find("(34)") != std::string::npos);
}

TEST_CASE("more clients than the board has memory for are turned away, and the others served", "[pil]") {
  if (!emulator_wanted()) return;
  LocalRig rig({}, {}, emulated_board);
  std::vector<std::unique_ptr<Rig>> clients;
  CHECK_THROWS_AS(
      [&] {
        for (int i = 0; i < 20; ++i) clients.push_back(connect_iio("ip:" + rig.address()));
      }(),
      RigError);
  REQUIRE(clients.size() >= 5);
  clients.resize(3);  // a record is read over a connection of its own
  CHECK(clients.front()->fire({}, 20s).outcome == Outcome::pass);
}
