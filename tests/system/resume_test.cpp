#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/random.h"
#include "host/store/store.h"
#include "rigs/iiod_server.h"
#include "tests/rigs/proxy.h"
#include "tests/system/program.h"

using namespace powbench;
using namespace powbench::test;
using namespace std::chrono_literals;

namespace {

/// Every shot of the newest campaign is there once, in order, with a record that loads.
void check_complete(const std::string& db, std::size_t expected) {
  const host::Store store(db, host::Store::Mode::read_only);
  const auto campaigns = store.campaigns();
  REQUIRE(campaigns.size() == 1);
  CHECK(campaigns[0].finished);
  const auto shots = store.shots(campaigns[0].id, host::ShotKind::measured);
  REQUIRE(shots.size() == expected);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    CHECK(shots[i].number == static_cast<int>(i));
    CHECK(store.load_record(shots[i].id).samples() == 14'000);
    CHECK(store.load_events(shots[i].id).has_value());
  }
}

std::vector<std::string> hashes(const std::string& db) {
  const host::Store store(db, host::Store::Mode::read_only);
  std::vector<std::string> list;
  for (const auto& s : store.shots(store.campaign().id, host::ShotKind::measured))
    list.push_back(s.record_hash);
  return list;
}

const char* const plan_text = "angles_deg = [0, 30, 60, 90]\nrepeats = 2\nseed = 3\n";

}  // namespace

TEST_CASE(
    "killed at 50 random moments, then resumed: every shot is there once and is what it would have been",
    "[system][.slow]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", plan_text);
  const std::string whole = folder.file("whole.db");
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(run(folder, {"run", plan, "--db", whole, "--progress", "none"}).status == 0);
  const auto duration =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start);
  const auto reference = hashes(whole);

  Random random(50);
  int interrupted = 0;
  for (int i = 0; i < 50; ++i) {
    const std::string db = folder.file("run" + std::to_string(i) + ".db");
    {
      Program program(folder, {"run", plan, "--db", db, "--resume", "--progress", "none"});
      std::this_thread::sleep_for(duration * random.uniform());
      program.send(SIGKILL);
      interrupted += program.wait() == -SIGKILL;
    }
    const Finished resumed = run(folder, {"run", plan, "--db", db, "--resume", "--progress", "none"});
    INFO("kill " << i << ": " << resumed.err);
    REQUIRE(resumed.status == 0);
    check_complete(db, reference.size());
    CHECK(hashes(db) == reference);
  }
  CHECK(interrupted > 25);
}

TEST_CASE("killed once and resumed", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", plan_text);
  const std::string db = folder.file("a.db");
  {
    Program program(folder, {"run", plan, "--db", db, "--progress", "none"});
    // until the first shots are there
    for (int i = 0; i < 500; ++i) {
      std::this_thread::sleep_for(10ms);
      try {
        const host::Store store(db, host::Store::Mode::read_only);
        if (store.campaigns().size() == 1 && store.shots(1).size() >= 2) break;
      } catch (const host::StoreError&) {
      }
    }
    program.send(SIGKILL);
    program.wait();
  }
  REQUIRE(run(folder, {"run", plan, "--db", db, "--resume"}).status == 0);
  check_complete(db, 8);
}

TEST_CASE("Ctrl-C ends after the shot in flight, with exit 130, and the rest can be resumed", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", std::string(plan_text) + "pause_s = 0.2\n");
  const std::string db = folder.file("a.db");
  Program program(folder, {"run", plan, "--db", db, "--progress", "none"});
  std::this_thread::sleep_for(500ms);
  program.send(SIGINT);
  CHECK(program.wait() == 130);
  REQUIRE(run(folder, {"run", plan, "--db", db, "--resume"}).status == 0);
  check_complete(db, 8);
}

TEST_CASE("a rig that vanishes in mid-campaign: the shot is an ERROR, the rest is resumed later",
          "[system]") {
  rigs::LocalRig server({}, {});
  Folder folder;
  const std::string plan = folder.write("p.toml", std::string(plan_text) + "pause_s = 0.1\n");
  const std::string db = folder.file("a.db");
  Proxy line(server.address());
  const std::string rig = "ip:" + line.address();
  SECTION("and stays away") {
    Program program(folder, {"run", plan, "--rig", rig, "--db", db, "--progress", "none"});
    std::this_thread::sleep_for(400ms);
    line.cut(true);
    CHECK(program.wait() == 3);
    CHECK(program.err().find("--resume") != std::string::npos);
    line.cut(false);
  }
  SECTION("and comes back") {
    Program program(folder, {"run", plan, "--rig", rig, "--db", db, "--progress", "none"});
    std::this_thread::sleep_for(400ms);
    line.cut(true);
    std::this_thread::sleep_for(300ms);
    line.cut(false);
    CHECK(program.wait() == 3);  // one shot is an ERROR, the others are recorded
  }
  REQUIRE(run(folder, {"run", plan, "--rig", rig, "--db", db, "--resume", "--progress", "none"}).status == 0);
  check_complete(db, 8);
}
