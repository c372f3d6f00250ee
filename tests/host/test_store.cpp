#include "host/store/store.h"

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "tests/host/bare_records.h"
#include "tests/host/store_samples.h"
#include "tests/places.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

const ExtractionInfo extraction{"cutoff = 1\n", "0.1.0"};

/// One statement on a file, past the store.
void sql(const std::string& path, const std::string& statement) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, statement.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

}  // namespace

TEST_CASE("campaign, shot, record and events come back as they went in", "[store]") {
  const Folder folder;
  std::int64_t campaign = 0;
  {
    Store store(folder.file());
    campaign = fill(store, 3);
  }
  Store store(folder.file());
  const CampaignInfo info = store.campaign();
  CHECK(info.id == campaign);
  CHECK(info.plan == sample_campaign().plan);
  CHECK(info.rig_identity == sample_campaign().rig_identity);
  CHECK(info.created.size() == 20);
  CHECK_FALSE(info.finished);

  const auto shots = store.shots(campaign, ShotKind::measured);
  REQUIRE(shots.size() == 3);
  CHECK(store.shots(campaign, ShotKind::simulated).empty());
  for (int i = 0; i < 3; ++i) {
    const StoredShot& s = shots[static_cast<std::size_t>(i)];
    const StoredShot asked = sample_shot(campaign, i);
    CHECK(s.number == i);
    CHECK(same(s.conditions, asked.conditions));
    CHECK(s.angle_deg == asked.angle_deg);
    CHECK(s.outcome == Outcome::pass);
    CHECK(s.record_hash.size() == 64);
    const auto seed = static_cast<std::uint64_t>(i);
    const Record record = store.load_record(s.id);
    CHECK(same(record, sample_record(seed)));
    CHECK(same(record.conditions, asked.conditions));
    CHECK(same(store.load_events(s.id).value(), sample_events(seed)));
  }
}

TEST_CASE("a record of pure noise takes 16 bytes a sample and little more", "[store]") {
  const Folder folder;
  constexpr int shots = 10;
  constexpr std::size_t samples = 14'000;
  {
    Store store(folder.file());
    fill(store, shots, samples);
  }
  const auto size = static_cast<double>(fs::file_size(folder.file()));
  CHECK(size / (shots * 16.0 * samples) < 1.1);
}

TEST_CASE("a shot with a valid record is there once; one without may be done again", "[store]") {
  const Folder folder;
  Store store(folder.file());
  const auto campaign = fill(store, 1);
  const Record other = sample_record(99);
  CHECK_THROWS_AS(store.store_shot(sample_shot(campaign, 0), &other, nullptr, extraction), StoreError);
  const auto kept = store.shots(campaign);
  REQUIRE(kept.size() == 1);
  CHECK(same(store.load_record(kept[0].id), sample_record(0)));

  store.store_shot(sample_shot(campaign, 1, Outcome::error), nullptr, nullptr, extraction);
  CHECK(store.shots(campaign)[1].reason == "the rig did not answer");
  CHECK(store.shots(campaign)[1].record_hash.empty());
  const auto id = store.store_shot(sample_shot(campaign, 1), &other, nullptr, extraction);
  REQUIRE(store.shots(campaign).size() == 2);
  CHECK(store.shot(id).outcome == Outcome::pass);
  CHECK_FALSE(store.load_events(id).has_value());

  StoredShot simulated = sample_shot(campaign, 0);
  simulated.kind = ShotKind::simulated;
  store.store_shot(simulated, &other, nullptr, extraction);
  CHECK(store.shots(campaign).size() == 3);
}

TEST_CASE("failed attempts stay as history, whatever comes of the shot later", "[store]") {
  const Folder folder;
  Store store(folder.file());
  const auto campaign = fill(store, 1);
  for (const char* reason : {"first", "second"}) {
    StoredShot failed = sample_shot(campaign, 1, Outcome::timeout);
    failed.reason = reason;
    store.store_shot(failed, nullptr, nullptr, extraction);
  }
  CHECK(store.shots(campaign)[1].reason == "second");
  CHECK(store.shots(campaign)[1].attempt == 2);
  const Record record = sample_record(1);
  store.store_shot(sample_shot(campaign, 1), &record, nullptr, extraction);
  CHECK_THROWS_AS(store.store_shot(sample_shot(campaign, 1), &record, nullptr, extraction), StoreError);
  const auto shots = store.shots(campaign);
  REQUIRE(shots.size() == 2);
  CHECK(shots[1].outcome == Outcome::pass);
  CHECK(shots[1].attempt == 3);
  std::map<Outcome, std::size_t> counted;
  for (const StoredShot& one : store.shots(campaign, ShotKind::measured)) ++counted[one.outcome];
  CHECK(store.outcomes(campaign, ShotKind::measured) == counted);  // the last attempts only
  CHECK(store.outcomes(campaign, ShotKind::simulated).empty());
  const auto earlier = store.earlier_attempts(campaign);
  REQUIRE(earlier.size() == 2);
  CHECK(earlier[0].reason == "first");
  CHECK(earlier[1].reason == "second");
  CHECK(earlier[1].outcome == Outcome::timeout);
}

TEST_CASE("a store of the schema before attempts is brought up to date, also by a reader", "[store]") {
  const Folder folder;
  // as the program before this one wrote it: its migrations, and one shot
  for (const char* file : {"0001_initial.sql", "0002_sweeps.sql"})
    sql(folder.file(), bytes_of(powbench::test::source_dir() + "/host/store/migrations/" + file));
  sql(folder.file(),
      "PRAGMA application_id = " + std::to_string(Store::application_id) + "; PRAGMA user_version = 2");
  {
    // rows of today without what is new in them have the seals of that time
    const Folder today;
    Store store(today.file());
    const auto campaign = store.create_campaign(sample_campaign());
    Record record = sample_record(0);
    record.sealed.clear();
    const Events events = sample_events(0);
    store.store_shot(sample_shot(campaign, 0), &record, &events, extraction);
    unpack_records(today.file());
    sql(folder.file(),
        "ATTACH '" + today.file() +
            "' AS today; INSERT INTO campaign SELECT id, created, name, plan, plan_hash, specimen, "
            "specimen_hash, rig_file, rig_uri, "
            "rig_identity, program_version, finished, seal FROM today.campaign;"
            "INSERT INTO shot SELECT id, campaign_id, kind, number, repeat, angle_deg, conditions, outcome, "
            "reason, started, seal FROM today.shot;"
            "INSERT INTO record SELECT id, shot_id, content_hash, sample_rate, samples, fire_sample, "
            "fire_offset, gaps, overruns, crc32, rig_shot_id, rig, firmware, calibration, seal, scans "
            "FROM today.record; INSERT INTO channel SELECT * FROM today.channel;"
            "INSERT INTO events SELECT * FROM today.events");
  }
  const Store reader(folder.file(), Store::Mode::read_only);
  const auto shots = reader.shots(1);
  REQUIRE(shots.size() == 1);
  CHECK(shots[0].attempt == 1);
  CHECK(reader.load_record(shots[0].id).crc32 == sample_record(0).crc32);
  CHECK(same(reader.load_events(shots[0].id).value(), sample_events(0)));
  CHECK(reader.earlier_attempts(1).empty());
}

TEST_CASE("what is not known is stored as such, annotations stand beside what is sealed, origin is kept",
          "[store]") {
  const Folder folder;
  Store store(folder.file());
  CampaignInfo info = sample_campaign();
  info.origin = Origin::board;
  const auto campaign = store.create_campaign(info);
  StoredShot shot = sample_shot(campaign, 0);
  shot.angle_deg = shot.conditions.closing_angle = shot.conditions.supply_volts = std::nan("");
  shot.outcome = Outcome::not_observed;
  const auto id = store.store_shot(shot, nullptr, nullptr, extraction);
  CHECK(store.campaign(campaign).origin == Origin::board);
  CHECK(std::isnan(store.shot(id).angle_deg));
  CHECK(std::isnan(store.shot(id).conditions.supply_volts));
  CHECK(store.shot(id).outcome == Outcome::not_observed);
  CHECK(store.annotations(campaign).empty());
  store.annotate(campaign, "operator", "A");
  store.annotate(campaign, "operator", "B");
  REQUIRE(store.annotations(campaign).size() == 2);
  CHECK(store.annotations(campaign)[1].text == "B");
  CHECK(store.prediction(id).empty());
  store.store_prediction(id, {{{"t_ct1", 2.5e-6}, {"v_core", std::nan("")}},
                              {{"laser", 0, 1e-4, {1e-6F, std::nanf(""), 3.25e-5F}}},
                              {{7, {{"t_ct1", -0.0005}, {"t_xt1", std::nan("")}}}}});
  const InputSpread back = store.prediction(id);
  CHECK(back.u.at("t_ct1") == 2.5e-6);
  CHECK(std::isnan(back.u.at("v_core")));
  REQUIRE(back.curves.size() == 1);
  CHECK(back.curves[0].channel == "laser");
  CHECK(back.curves[0].dt == 1e-4);
  REQUIRE(back.curves[0].u.size() == 3);
  CHECK(std::isnan(back.curves[0].u[1]));
  CHECK(back.curves[0].u[2] == 3.25e-5F);
  CHECK(back.moved.at(7).at("t_ct1") == -0.0005);
  CHECK(std::isnan(back.moved.at(7).at("t_xt1")));
  sql(folder.file(), "UPDATE annotation SET text = 'C'");
  CHECK_THROWS_AS(store.annotations(campaign), StoreError);
  sql(folder.file(), "UPDATE campaign SET origin = 'SIMULATED RIG'");
  CHECK_THROWS_AS(store.campaign(campaign), StoreError);
}

TEST_CASE("numbers that overflow are damage, like a wrong seal", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 1);
  }
  const std::string whole = bytes_of(folder.file());
  for (const char* change :
       {"samples = 9223372036854775807", "samples = -1", "samples = 1152921504606846976", "gaps = '[[1,2'",
        "gaps = '[[\"a\", 2]]'", "gaps = '[[-5, 9223372036854775807]]'", "sample_rate = 9e999",
        "sealed = 'other'", "scans = x'00'", "scans = x''"}) {
    INFO(change);
    write_bytes(folder.file(), whole);
    sql(folder.file(), std::string("UPDATE record SET ") + change);
    const Store store(folder.file(), Store::Mode::read_only);
    CHECK_THROWS_AS(store.load_record(1), StoreError);
  }
  for (const char* change :
       {"DELETE FROM channel", "UPDATE channel SET scale = 9e999", "UPDATE channel SET name = 'x'"}) {
    INFO(change);
    write_bytes(folder.file(), whole);
    sql(folder.file(), change);
    const Store store(folder.file(), Store::Mode::read_only);
    CHECK_THROWS_AS(store.load_record(1), StoreError);
  }
}

TEST_CASE("events of another extraction are kept beside the first", "[store]") {
  const Folder folder;
  Store store(folder.file());
  const auto campaign = fill(store, 1);
  const auto shot = store.shots(campaign)[0].id;
  Events other = sample_events(5);
  other.parameters_hash = "4567";
  store.store_events(shot, other, extraction);
  CHECK(same(store.load_events(shot).value(), other));
}

TEST_CASE("the newest campaign of a plan that was fired on a rig is found for resuming", "[store]") {
  const Folder folder;
  Store store(folder.file());
  CHECK_FALSE(store.find_campaign("plan-demo", "specimen-demo").has_value());
  CHECK_THROWS_WITH(store.campaign(), Contains("no campaign yet"));
  const auto first = store.create_campaign(sample_campaign());
  const auto second = store.create_campaign(sample_campaign());
  store.create_campaign(sample_campaign("other"));
  CHECK(store.find_campaign("plan-demo", "specimen-demo")->id == second);
  CHECK(second != first);
  store.set_finished(second, true);
  CHECK(store.find_campaign("plan-demo", "specimen-demo")->finished);
  CampaignInfo simulated = sample_campaign();
  simulated.rig_uri = "";
  store.create_campaign(simulated);
  CHECK(store.find_campaign("plan-demo", "specimen-demo")->id == second);
  CHECK_FALSE(store.find_campaign("plan-demo", "specimen-other").has_value());
  CHECK(store.campaign(second).finished);
  CHECK(store.campaigns().size() == 4);
  CHECK_THROWS_AS(store.campaign(999), StoreError);
  CHECK_THROWS_AS(store.shot(999), StoreError);
  CHECK_THROWS_AS(store.load_record(999), StoreError);
}

TEST_CASE("shots need their campaign", "[store]") {
  const Folder folder;
  Store store(folder.file());
  CHECK_THROWS_AS(store.store_shot(sample_shot(12, 0), nullptr, nullptr, extraction), StoreError);
}

TEST_CASE("a zero-length file is a new store, and a closed store is one file", "[store]") {
  const Folder folder;
  write_bytes(folder.file(), "");
  {
    Store store(folder.file());
    fill(store, 1);
  }
  {
    const Store reader(folder.file(), Store::Mode::read_only);
    CHECK(reader.shots(1).size() == 1);
  }
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    CAPTURE(entry.path());
    ++files;
  }
  CHECK(files == 1);
}

TEST_CASE("refused files get one sentence and stay as they are", "[store]") {
  const Folder folder;
  const auto refuse = [&](const std::string& file, const std::string& words) {
    const std::string before = bytes_of(file);
    for (const auto mode : {Store::Mode::read_write, Store::Mode::read_only})
      CHECK_THROWS_WITH(Store(file, mode), Contains(words) && Contains(file));
    CHECK(bytes_of(file) == before);
    CHECK_FALSE(fs::exists(file + "-wal"));
    CHECK_FALSE(fs::exists(file + "-shm"));
  };

  write_bytes(folder.file("notes.txt"), std::string(5000, 'x'));
  refuse(folder.file("notes.txt"), "a text file, not a powbench store");
  write_bytes(folder.file("short.txt"), "angles_deg = [0, 90]\n# \xc3\xa4\n");
  refuse(folder.file("short.txt"), "a text file, not a powbench store");
  write_bytes(folder.file("noise.bin"), std::string(5000, '\x01'));
  refuse(folder.file("noise.bin"), ": not a powbench store");
  sql(folder.file("other.db"), "CREATE TABLE t (x); INSERT INTO t VALUES (1)");
  refuse(folder.file("other.db"), "another program");
  { Store store(folder.file("newer.db")); }
  sql(folder.file("newer.db"), "PRAGMA user_version = 99");
  refuse(folder.file("newer.db"), "newer powbench");
  write_bytes(folder.file("short.db"), bytes_of(folder.file("newer.db")).substr(0, 60));
  refuse(folder.file("short.db"), "damaged");

  CHECK_THROWS_WITH(Store(folder.path().string()), Contains("folder"));
  CHECK_THROWS_WITH(Store(folder.file("nowhere/x.db")), Contains("there is no folder"));
  CHECK_THROWS_WITH(Store(folder.file("absent.db"), Store::Mode::read_only), Contains("no such store"));
  CHECK_FALSE(fs::exists(folder.file("absent.db")));
}

TEST_CASE("a newer schema is seen even while it stands in the log only", "[store]") {
  const Folder folder;
  { Store store(folder.file()); }
  sqlite3* db = nullptr;  // another program keeps the file open: its change is in the log
  REQUIRE(sqlite3_open(folder.file().c_str(), &db) == SQLITE_OK);
  REQUIRE(sqlite3_exec(db, "PRAGMA user_version = 99", nullptr, nullptr, nullptr) == SQLITE_OK);
  CHECK_THROWS_WITH(Store(folder.file()), Contains("newer powbench"));
  sqlite3_close(db);
}

TEST_CASE("two processes that make the same store at once both keep their campaign", "[store]") {
  for (int round = 0; round < 20; ++round) {
    const Folder folder;
    std::array<pid_t, 2> children{};
    for (pid_t& child : children) {
      child = fork();
      if (child == 0) {
        try {
          Store store(folder.file());
          fill(store, 1, 20);
          _exit(0);
        } catch (...) {
          _exit(1);
        }
      }
    }
    for (const pid_t child : children) {
      int status = 0;
      waitpid(child, &status, 0);
      CHECK(status == 0);
    }
    Store store(folder.file());
    REQUIRE(store.campaigns().size() == 2);
  }
}

TEST_CASE("a store that may not be written is read, and writing is refused in words", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 1);
  }
  fs::permissions(folder.path(), fs::perms(0555));
  fs::permissions(folder.file(), fs::perms(0444));
  const std::string before = bytes_of(folder.file());
  const pid_t child = fork();
  if (child == 0) {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(10);
    try {
      const Store reader(folder.file(), Store::Mode::read_only);
      if (!same(reader.load_record(reader.shots(1).at(0).id), sample_record(0))) _exit(1);
    } catch (const std::exception& e) {
      _exit(2);
    }
    try {
      Store writer(folder.file());
      writer.create_campaign(sample_campaign());
      _exit(3);
    } catch (const StoreError&) {
      _exit(0);
    } catch (...) {
      _exit(4);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  fs::permissions(folder.path(), fs::perms(0755));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(bytes_of(folder.file()) == before);
}
