#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/pil/emulated.h"
#include "tests/system/program.h"

/// The emulated board from the command line: what a user sees must be what the simulated rig gives.

using namespace powbench::test;
using nlohmann::json;

namespace {

/// What was measured, without what says where and when.
std::vector<json> shots(const Folder& folder, const std::string& database) {
  const json campaigns = json::parse(run(folder, {"campaigns", "--db", database, "--json"}).out);
  std::vector<json> list;
  for (const json& shot : campaigns.at(0).at("shots")) {
    const std::string id = std::to_string(shot.at("id").get<int>());
    list.push_back({{"record", shot.at("record_sha256")},
                    {"events", json::parse(run(folder, {"events", id, "--db", database, "--json"}).out)}});
  }
  return list;
}

}  // namespace

TEST_CASE("a campaign on qemu: gives the records and events of sim:", "[system]") {
  if (!emulator_wanted()) return;
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [15, 90]\nrepeats = 2\nseed = 5\n");
  for (const char* rig : {"sim:", "qemu:"}) {
    const auto done = run(folder, {"run", plan, "--rig", rig, "--db", folder.file(std::string(rig) + "db"),
                                   "--progress", "none"});
    INFO(done.err);
    REQUIRE(done.status == 0);
  }
  const auto wanted = shots(folder, folder.file("sim:db"));
  CHECK(wanted.size() == 4);
  CHECK(shots(folder, folder.file("qemu:db")) == wanted);
}

TEST_CASE("the demo on qemu: is the demo on sim:", "[.slow]") {
  if (!emulator_wanted()) return;
  Folder folder;
  for (const char* rig : {"sim", "qemu"}) {
    const auto done =
        run(folder, {"demo", "--rig", std::string(rig) + ":", "-o", folder.file(rig), "--progress", "none"});
    INFO(done.err);
    REQUIRE(done.status == 0);
  }
  const auto wanted = shots(folder, folder.file("sim/demo.db"));
  CHECK(wanted.size() == 28);
  CHECK(shots(folder, folder.file("qemu/demo.db")) == wanted);
}
