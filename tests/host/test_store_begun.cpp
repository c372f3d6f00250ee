#include <catch2/catch.hpp>
#include <future>

#include "host/store/begun_rows.h"
#include "host/store/maintain.h"
#include "host/store/open.h"
#include "host/store/rows.h"
#include "tests/host/store_samples.h"
#include "tests/other_process.h"

/// What becomes of a shot whose program ends while it is fired.

using namespace powbench;
using namespace powbench::host;
using powbench::test::in_another_process;

namespace {

const ExtractionInfo nothing_extracted{"", "0.1.0"};

}  // namespace

TEST_CASE("a shot whose program ended while it was fired is an ERROR of its campaign", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    store.create_campaign(sample_campaign());
  }
  REQUIRE(in_another_process([&] {
            Store store(folder.file());
            store.begin_shot(sample_shot(1, 0));
            store.store_shot(sample_shot(1, 0), nullptr, nullptr, nothing_extracted);  // it came to its end
            store.begin_shot(sample_shot(1, 1));                                       // this one did not
          }) == 0);
  Store store(folder.file());
  CHECK(store.shots(1).size() == 1);  // whoever only reads changes nothing
  const auto closed = store.close_begun();
  REQUIRE(closed.size() == 1);
  const StoredShot left = store.shot(closed[0].id);
  CHECK(left.number == 1);
  CHECK(left.attempt == 1);
  CHECK(left.outcome == Outcome::error);
  CHECK_THAT(left.reason, Catch::Contains("the program ended while this shot was fired"));
  CHECK(left.conditions.closing_angle == sample_shot(1, 1).conditions.closing_angle);
  CHECK(left.angle_deg == sample_shot(1, 1).angle_deg);
  CHECK(store.close_begun().empty());         // said once
  REQUIRE(store.annotations(1).size() == 1);  // and kept where the shot is fired again
  CHECK(store.annotations(1)[0].key == course_key);
  CHECK_THAT(store.annotations(1)[0].text, Catch::Contains("the program ended while shot 2 of the plan"));
  const Record record = sample_record(1);
  store.store_shot(sample_shot(1, 1), &record, nullptr, nothing_extracted);  // fired again: the next attempt
  CHECK(store.shots(1)[1].attempt == 2);
}

TEST_CASE("what another program fires is not closed, what an earlier shot of this one left is", "[store]") {
  const Folder folder;
  Store store(folder.file());
  store.create_campaign(sample_campaign());
  store.begin_shot(sample_shot(1, 0));
  CHECK(in_another_process([&] {
          if (!Store(folder.file()).close_begun().empty()) _exit(2);
        }) == 0);
  CHECK(store.close_begun().size() == 1);
}

TEST_CASE("what another thread of this program fires is not closed, what it left is", "[store]") {
  const Folder folder;
  Store store(folder.file());
  store.create_campaign(sample_campaign());
  {
    Store other(folder.file());
    other.begin_shot(sample_shot(1, 0));
    std::async(std::launch::async, [&] { CHECK(store.close_begun().empty()); }).get();
    const Record record = sample_record(1);
    other.store_shot(sample_shot(1, 0), &record, nullptr, nothing_extracted);
    other.begin_shot(sample_shot(1, 1));
    CHECK(store.close_begun().empty());
  }  // closed with a shot that came to no end
  const auto closed = store.close_begun();
  REQUIRE(closed.size() == 1);
  CHECK(closed[0].number == 1);
  CHECK(store.shots(1).size() == 2);
}

TEST_CASE("a mark is closed after a day, whatever has its process id then, here or on another machine",
          "[store]") {
  const Folder folder;
  Store store(folder.file());
  store.create_campaign(sample_campaign());
  StoredShot old = sample_shot(1, 0), fresh = sample_shot(1, 1);
  old.started = "2020-01-01T00:00:00Z", fresh.started = utc_now();
  const auto elsewhere = [&](StoredShot shot) {
    auto db = open_store(folder.file(), Store::Mode::read_write);
    insert_begun(db, shot, {"another", 1});
  };
  elsewhere(old), elsewhere(fresh);
  const auto closed = store.close_begun();
  REQUIRE(closed.size() == 1);
  CHECK(closed[0].number == 0);
  auto db = open_store(folder.file(), Store::Mode::read_write);
  insert_begun(db, old, {this_program().machine, getppid()});  // a process that runs
  CHECK(store.close_begun().size() == 1);
}

TEST_CASE("a damaged mark of a begun shot is damage", "[store]") {
  const Folder folder;
  Store store(folder.file());
  store.create_campaign(sample_campaign());
  store.begin_shot(sample_shot(1, 0));
  CHECK(check_store(folder.file()).damage.empty());
  open_store(folder.file(), Store::Mode::read_write).run("UPDATE begun SET angle_deg = angle_deg + 1");
  CHECK_THAT(check_store(folder.file()).damage.at(0), Catch::Contains("the shot begun in campaign 1"));
  CHECK_THROWS_AS(store.close_begun(), StoreError);
}
