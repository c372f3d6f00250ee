#include <catch2/catch.hpp>
#include <future>
#include <set>

#include "core/random.h"
#include "host/store/store.h"
#include "rigs/iiod_server.h"
#include "tests/rigs/proxy.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

using namespace powbench;
using namespace powbench::test;

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

/// A simulated rig at the end of a line that the test holds in its hand.
struct Bench {
  std::string uri() const { return "ip:" + line.address(); }
  std::vector<std::string> command(const std::string& plan, const std::string& db, bool resume = true) const {
    std::vector<std::string> words{"run", plan, "--rig", uri(), "--db", db, "--progress", "none"};
    if (resume) words.push_back("--resume");
    return words;
  }
  /// Bytes that a whole campaign takes from the rig.
  std::uint64_t length_of(const Folder& folder, const std::string& plan, const std::string& db) const {
    const std::uint64_t before = line.answered();
    REQUIRE(run(folder, command(plan, db)).status == 0);
    return line.answered() - before;
  }

  rigs::LocalRig rig{{}, {}};
  Proxy line{rig.address()};
};

}  // namespace

TEST_CASE(
    "killed at 50 random bytes of the line, then resumed: every shot is there once and is what it would have "
    "been",
    "[system][.slow]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", plan_text);
  const std::string whole = folder.file("whole.db");
  const std::uint64_t length = Bench().length_of(folder, plan, whole);
  const auto reference = hashes(whole);

  Random random(50);
  for (int i = 0; i < 50; ++i) {
    Bench bench;  // without the lease of the one killed before
    const std::string db = folder.file("run" + std::to_string(i) + ".db");
    {
      std::promise<const Program*> started;
      // the number of looks at `state` differs from run to run, by far less than the twentieth that is left out
      bench.line.at_answer_byte(1 + random.below(length * 95 / 100),
                                [program = started.get_future().share()] { program.get()->send(SIGKILL); });
      Program program(folder, bench.command(plan, db));
      started.set_value(&program);
      REQUIRE(program.wait() == -SIGKILL);
    }
    // once on the same rig, which waits for the dead owner's lease to end; then on fresh ones
    const Finished resumed =
        run(folder, i == 0 ? bench.command(plan, db)
                           : std::vector<std::string>{"run", plan, "--rig", "sim:", "--db", db, "--resume",
                                                      "--progress", "none"});
    INFO("kill " << i << ": " << resumed.err);
    REQUIRE(resumed.status == 0);
    check_complete(db, reference.size());
    CHECK(hashes(db) == reference);
  }
}

TEST_CASE("killed once and resumed", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", std::string(plan_text) + "pause_s = 0.2\n");
  const std::string db = folder.file("a.db");
  {
    Program program(folder, {"run", plan, "--rig", "sim:", "--db", db, "--progress", "none"});
    wait_until("two stored shots", [&] {
      try {
        const host::Store store(db, host::Store::Mode::read_only);
        return store.campaigns().size() == 1 && store.shots(1).size() >= 2;
      } catch (const host::StoreError&) {
        return false;  // not made yet
      }
    });
    program.send(SIGKILL);
    program.wait();
  }
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--resume"}).status == 0);
  check_complete(db, 8);
}

TEST_CASE("a campaign is not resumed with another configuration of the rig", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", std::string(plan_text) + "pause_s = 0.3\n"),
                    slow = folder.write("slow.rig.toml", "sample_rate_hertz = 50000\n"),
                    db = folder.file("a.db");
  const auto begun = [&] {
    try {
      const host::Store store(db, host::Store::Mode::read_only);
      return store.campaigns().size() == 1 && !store.shots(1).empty();
    } catch (const host::StoreError&) {
      return false;  // not made yet
    }
  };
  {
    Program program(folder, {"run", plan, "--rig", "sim:", "--db", db, "--progress", "none"});
    wait_until("a stored shot", begun);
    program.send(SIGKILL);
    program.wait();
  }
  const Finished other = run(folder, {"run", plan, "--rig", "sim:" + slow, "--db", db, "--resume"});
  CHECK(other.status == 3);
  CHECK_THAT(other.err, Catch::Contains("was begun with the rig's configuration"));
  CHECK(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--resume"}).status == 0);
  check_complete(db, 8);
}

TEST_CASE("Ctrl-C ends after the shot in flight, with exit 130, and the rest can be resumed", "[system]") {
  Folder folder;
  Bench bench;
  const std::string plan = folder.write("p.toml", plan_text);
  const std::uint64_t length = bench.length_of(folder, plan, folder.file("whole.db"));
  const std::string db = folder.file("a.db");
  {
    std::promise<const Program*> started;
    bench.line.at_answer_byte(length * 45 / 100,  // in the record of the fourth shot of eight
                              [program = started.get_future().share()] { program.get()->send(SIGINT); });
    Program program(folder, bench.command(plan, db));
    started.set_value(&program);
    CHECK(program.wait() == 130);
  }
  {
    const host::Store store(db, host::Store::Mode::read_only);
    CHECK(store.shots(store.campaign().id).size() == 4);  // the one in flight is stored
  }
  const Finished report = run(folder, {"report", "--db", db, "-o", folder.file("out"), "--json"});
  CHECK(report.status == 1);
  CHECK_THAT(report.out, Catch::Contains("\"verdict\": \"ABORTED\"") &&
                             Catch::Contains("stopped by the operator, 4 of 8 shots recorded") &&
                             Catch::Contains("\"best_angle\""));
  REQUIRE(run(folder, bench.command(plan, db)).status == 0);
  check_complete(db, 8);
}

TEST_CASE("a rig that vanishes in mid-campaign costs at most the shot in flight; the rest is resumed later",
          "[system]") {
  Folder folder;
  Bench bench;
  const std::string plan = folder.write("p.toml", plan_text);
  const std::uint64_t length = bench.length_of(folder, plan, folder.file("whole.db"));
  const std::string db = folder.file("a.db");
  const std::uint64_t in_fourth_record = length * 45 / 100;
  SECTION("and stays away") {
    bench.line.at_answer_byte(in_fourth_record, [&] { bench.line.cut(true); });
    const Finished lost = run(folder, bench.command(plan, db, false));
    CHECK(lost.status == 3);
    CHECK_THAT(lost.err, Catch::Contains("the rig did not come back") && Catch::Contains("--resume"));
    bench.line.cut(false);
  }
  SECTION("and comes back") {
    bench.line.at_answer_byte(in_fourth_record, [&] { bench.line.cut_and_refuse(2); });
    const Finished found = run(folder, bench.command(plan, db, false));
    INFO(found.err);
    CHECK(found.status == 0);  // what was fired is fetched, and nothing is fired again
    const host::Store store(db, host::Store::Mode::read_only);
    const auto shots = store.shots(store.campaign().id);
    CHECK(shots.size() == 8);
    CHECK(store.earlier_attempts(store.campaign().id).empty());
    std::set<std::uint64_t> numbers;
    for (const auto& shot : shots) numbers.insert(store.load_record(shot.id).shot_id);
    CHECK(numbers.size() == 8);
    CHECK(*numbers.rbegin() - *numbers.begin() == 7);
  }
  REQUIRE(run(folder, bench.command(plan, db)).status == 0);
  check_complete(db, 8);
}
