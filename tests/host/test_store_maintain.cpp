#include "host/store/maintain.h"

#include <sqlite3.h>

#include <catch2/catch.hpp>

#include "core/quantities.h"
#include "host/store/open.h"
#include "host/store/sweep_store.h"
#include "tests/host/bare_records.h"
#include "tests/host/overlapping_stores.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

void sql(const std::string& path, const std::string& statement) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, statement.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

std::string hash(const std::string& file) {
  const StoreContent c = check_store(file);
  for (const std::string& d : c.damage) UNSCOPED_INFO(d);
  CHECK(c.damage.empty());
  CHECK(c.hash.size() == 64);
  return c.hash;
}

std::string text_of(const std::string& path, const std::string& query) {
  const sqlite::Database db = open_store(path, Store::Mode::read_only);
  sqlite::Statement s(db, query);
  REQUIRE(s.step());
  return s.text(0);
}

/// A closing with every quantity that a list of shots shows.
Events closing(std::uint64_t seed) {
  Random random(seed);
  const auto value = [&] { return Measured{0.01 + 0.01 * random.uniform(), 1e-6 * random.uniform()}; };
  Events e;
  e.coil.closing_angle = value();
  e.contact_voltage.present = true;
  Contact c;
  c.touch = value();
  e.contact_voltage.contacts = {c};
  e.contact_voltage.settled = value();
  e.contact_voltage.bounce_time = value();
  return e;
}

}  // namespace

TEST_CASE("a measured shot with a record and no events is damage", "[store][maintain]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 3);
  }
  CHECK(check_store(folder.file()).damage.empty());
  sql(folder.file(), "DELETE FROM digest WHERE shot_id = 2");
  sql(folder.file(), "DELETE FROM events WHERE record_id = (SELECT id FROM record WHERE shot_id = 2)");
  const StoreContent c = check_store(folder.file());
  REQUIRE(c.damage.size() == 1);
  CHECK_THAT(c.damage.front(), Contains("the events of shot 2 are missing"));
}

TEST_CASE("stores merged in any order, grouping and repetition have one content", "[store][maintain]") {
  const Three three;
  const auto& f = three.files;
  const auto at = [&](const std::string& name) { return three.folder.file(name); };
  merge_stores(at("abc.db"), {f[0], f[1], f[2]});
  merge_stores(at("cba.db"), {f[2], f[1], f[0]});
  merge_stores(at("bc.db"), {f[1], f[2]});
  merge_stores(at("a_bc.db"), {f[0], at("bc.db")});
  merge_stores(at("bc_a.db"), {at("bc.db"), f[0], at("bc.db"), f[0]});
  const std::string one = hash(at("abc.db"));
  CHECK(hash(at("cba.db")) == one);
  CHECK(hash(at("a_bc.db")) == one);
  CHECK(hash(at("bc_a.db")) == one);
  CHECK(hash(f[0]) != one);
  const Merged again = merge_stores(at("abc.db"), {f[1], f[2]});
  CHECK(again.shots + again.campaigns + again.events + again.sweep_blocks == 0);
  CHECK(hash(at("abc.db")) == one);

  const StoreContent c = check_store(at("abc.db"));
  CHECK(c.campaigns == 4);
  CHECK(c.shots == 8);
  CHECK(c.records == 7);
  CHECK(c.undigested == 0);
  const Store store(at("abc.db"), Store::Mode::read_only);
  CHECK(store.campaign(1).finished);
  CHECK(store.annotations(1).size() == 3);
  for (const StoredShot& s : store.shots(1)) {
    if (s.record_hash.empty()) continue;
    const std::uint64_t seed = s.number == 0 ? 10 : static_cast<std::uint64_t>(18 + s.number);
    CHECK(same(store.load_record(s.id), sample_record(seed)));
    CHECK(same(store.load_events(s.id).value(), sample_events(seed)));
    CHECK(store.prediction(s.id).u.at("t_ct1") == 1e-6 * static_cast<double>(seed));
  }
  CHECK(SweepStore(at("abc.db")).blocks(1).size() == 3);
}

TEST_CASE("a store taken apart and put together again is the same", "[store][maintain]") {
  const Three three;
  const auto at = [&](const std::string& name) { return three.folder.file(name); };
  merge_stores(at("all.db"), three.files);
  const auto parts = split_store(at("all.db"), at("parts"));
  REQUIRE(parts.size() == 5);
  merge_stores(at("again.db"), {parts[4], parts[2], parts[0], parts[1], parts[3]});
  CHECK(hash(at("again.db")) == hash(at("all.db")));
  CHECK_THROWS_WITH(split_store(at("all.db"), at("parts")), Contains("is there already"));
  CHECK_THROWS_WITH(split_store(at("all.db"), at("other"), 99), Contains("no campaign 99"));
  CHECK(split_store(at("all.db"), at("one"), 2).size() == 1);
}

TEST_CASE("conflicting content is refused and the target stays as it was", "[store][maintain]") {
  Three three;
  const auto& f = three.files;
  const auto at = [&](const std::string& name) { return three.folder.file(name); };
  merge_stores(at("target.db"), {f[0]});
  const std::string before = hash(at("target.db"));
  const auto refused = [&](const std::string& why) {
    INFO(why);
    CHECK_THROWS_WITH(merge_stores(at("target.db"), {f[2], f[1]}),
                      Contains(why) && Contains("nothing was merged"));
    CHECK(hash(at("target.db")) == before);
    CHECK_THROWS_WITH(merge_stores(at("fresh.db"), {f[0], f[1]}), Contains(why));
    CHECK_FALSE(std::filesystem::exists(at("fresh.db")));
  };
  const std::string whole = bytes_of(f[1]);
  SECTION("a shot") {
    {
      Store store(f[1]);
      put_shot(store, 1, 2, 99);
    }
    refused("shot number 2 is not the same");
  }
  SECTION("a shot that is valid at another attempt") {
    {
      Store store(f[1]);
      put_shot(store, 1, 1, 99);
    }
    {
      Store store(f[0]);
      put_shot(store, 1, 1, 98, Outcome::error);
      put_shot(store, 1, 1, 98);
    }
    CHECK_THROWS_WITH(merge_stores(at("fresh.db"), {f[0], f[1]}), Contains("is not the same"));
    CHECK_THROWS_WITH(merge_stores(at("fresh.db"), {f[1], f[0]}), Contains("is not the same"));
  }
  SECTION("its extraction") {
    {
      Store store(f[1]);
      store.store_events(1, sample_events(77), {"b", "0.2"});
    }
    {
      Store store(f[0]);
      store.store_events(1, sample_events(78), {"a", "0.3"});
    }
    CHECK_THROWS_WITH(merge_stores(at("fresh.db"), {f[0], f[1]}), Contains("extraction is not the same"));
  }
  SECTION("a block of a sweep") {
    SweepStore(f[1]).put(1, std::vector{SweepBlock{0, 10, std::vector<double>(10, 1.0)}});
    refused("block 0 is not the same");
  }
  SECTION("a source that is damaged") {
    sql(f[1], "UPDATE record SET scans = x'00' WHERE id = 1");
    refused("do not match");
  }
  CHECK_THROWS_WITH(merge_stores(at("target.db"), {at("target.db")}), Contains("is the target itself"));
}

TEST_CASE("a later extraction is the longer list, from whichever side", "[store][maintain]") {
  Three three;
  const auto& f = three.files;
  {
    Store store(f[1]);
    store.store_events(1, sample_events(77), {"b", "0.2"});
  }
  for (const auto& order : {std::vector{f[0], f[1]}, std::vector{f[1], f[0]}}) {
    const std::string to = three.folder.file("m" + order[0].substr(order[0].size() - 4));
    merge_stores(to, order);
    const Store store(to, Store::Mode::read_only);
    CHECK(same(store.load_events(1).value(), sample_events(77)));
    CHECK(store.lines(1).front().digested);
  }
}

TEST_CASE("a check names what is damaged, row by row, and the rest is counted", "[store][maintain]") {
  const Folder folder;
  {
    Store store(folder.file("whole.db"));
    const auto c = store.create_campaign(sample_campaign());
    for (int i = 0; i < 5; ++i) put_shot(store, c, i, static_cast<std::uint64_t>(i));
    store.annotate(c, "operator", "A");
  }
  const std::string whole = bytes_of(folder.file("whole.db"));
  const std::vector<std::pair<const char*, const char*>> cases{
      {"UPDATE record SET scans = x'00' WHERE id = 3", "shot 3: its samples"},
      {"UPDATE record SET packing = '' WHERE id = 3", "shot 3: its samples"},
      {"UPDATE record SET packing = 'other' WHERE id = 3", "packed as 'other'"},
      {"UPDATE channel SET delay = 1 WHERE record_id = 2", "shot 2: the record"},
      {"UPDATE events SET events = '{}' WHERE id = 4", "events of shot 4"},
      {"UPDATE digest SET touch = 1 WHERE shot_id = 5", "digest of shot 5"},
      {"DELETE FROM shot WHERE id = 1", "belongs to none"},
      {"UPDATE shot SET repeat = 9 WHERE id = 1", "shot 1 does not match"},
      {"UPDATE annotation SET text = 'B'", "annotation"},
      {"UPDATE prediction SET uncertainty = '{}' WHERE shot_id = 2", "prediction of shot 2"},
  };
  for (const auto& [change, what] : cases) {
    INFO(change);
    write_bytes(folder.file("damaged.db"), whole);
    sql(folder.file("damaged.db"), change);
    const StoreContent c = check_store(folder.file("damaged.db"));
    REQUIRE_FALSE(c.damage.empty());
    CHECK_THAT(c.damage.front(), Contains(what));
    CHECK(c.hash.empty());
  }
  CHECK(hash(folder.file("whole.db")).size() == 64);
}

TEST_CASE("bare records of an older store are read, packed by migrate, and stay the same content",
          "[store][maintain]") {
  const Folder folder;
  {
    Store store(folder.file());
    const auto c = store.create_campaign(sample_campaign());
    for (int i = 0; i < 5; ++i) put_shot(store, c, i, static_cast<std::uint64_t>(i));
  }
  const std::string one = hash(folder.file());
  unpack_records(folder.file());
  sql(folder.file(), "DELETE FROM digest");
  const auto read_all = [&] {
    const Store store(folder.file(), Store::Mode::read_only);
    const auto lines = store.lines(1);
    REQUIRE(lines.size() == 5);
    for (const ShotLine& l : lines) {
      const auto seed = static_cast<std::uint64_t>(l.shot.number);
      CHECK(same(l.reached, sample_events(seed).coil.closing_angle));
      CHECK(same(l.settled, find_quantity("t_ct2")->of(sample_events(seed))));
      CHECK(same(l.bounce, find_quantity("t_ct_bon")->of(sample_events(seed))));
      CHECK(same(store.load_record(l.shot.id), sample_record(seed)));
      CHECK(same(store.load_events(l.shot.id).value(), sample_events(seed)));
    }
    return lines[0].digested;
  };
  CHECK_FALSE(read_all());
  CHECK(hash(folder.file()) == one);
  CHECK(check_store(folder.file()).bare == 5);
  CHECK(check_store(folder.file()).undigested == 5);
  const Migrated m = migrate_store(folder.file(), true);
  CHECK(m.packed == 5);
  CHECK(m.digested == 5);
  CHECK(check_store(folder.file()).bare == 0);
  CHECK(read_all());
  CHECK(hash(folder.file()) == one);
  CHECK(migrate_store(folder.file(), false).packed == 0);
}

TEST_CASE("a list of shots shows the values of the last attempts, measured and simulated ones apart",
          "[store][maintain]") {
  const Folder folder;
  Store store(folder.file());
  const auto c = store.create_campaign(sample_campaign());
  const Record record = sample_record(1);
  for (const ShotKind kind : {ShotKind::measured, ShotKind::simulated})
    for (int number = 0; number < 2; ++number) {
      StoredShot shot = sample_shot(c, number, Outcome::error);
      shot.kind = kind;
      store.store_shot(shot, nullptr, nullptr, sample_extraction());
      shot.outcome = Outcome::pass;
      const Events events = closing(10 * static_cast<unsigned>(kind) + static_cast<unsigned>(number));
      store.store_shot(shot, &record, &events, sample_extraction());
    }
  const std::vector<ShotLine> lines = store.lines(c);
  REQUIRE(lines.size() == 4);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const ShotLine& l = lines[i];
    CHECK(l.shot.kind == (i < 2 ? ShotKind::measured : ShotKind::simulated));
    CHECK(l.shot.number == static_cast<int>(i % 2));
    CHECK(l.shot.outcome == Outcome::pass);
    CHECK(l.digested);
    const Events events = closing(10 * static_cast<unsigned>(l.shot.kind) + static_cast<unsigned>(i % 2));
    const auto of = [&](const char* symbol) { return find_quantity(symbol)->of(events); };
    REQUIRE(of("t_ct1").known());
    CHECK(same(l.reached, events.coil.closing_angle));
    CHECK(same(l.touch, of("t_ct1")));
    CHECK(same(l.bounce, of("t_ct_bon")));
    CHECK(same(l.settled, of("t_ct2")));
  }
}

TEST_CASE("without a digest the newest extraction is read, and every extraction is counted",
          "[store][maintain]") {
  const Folder folder;
  {
    Store store(folder.file());
    const auto c = store.create_campaign(sample_campaign());
    put_shot(store, c, 0, 1);
    put_shot(store, c, 1, 2);
    put_shot(store, c, 2, 3, Outcome::error);
    store.store_events(1, sample_events(77), {"b", "0.2"});
  }
  CHECK(check_store(folder.file()).events == 3);
  sql(folder.file(), "DELETE FROM digest");
  const Store store(folder.file(), Store::Mode::read_only);
  CHECK(same(store.load_events(1).value(), sample_events(77)));
  CHECK(same(store.load_events(2).value(), sample_events(2)));
}

TEST_CASE("each number of a sweep is part of the content", "[store][maintain]") {
  const Folder folder;
  const auto of = [&](const std::string& name, double last, std::int64_t first) {
    SweepStore sweeps(folder.file(name));
    SweepInfo info;
    info.design = "{}", info.design_hash = "h", info.points = 30, info.columns = "x",
    info.program_version = "1";
    const auto sweep = sweeps.open_sweep(info);
    std::vector<double> numbers(10, 0.5);
    numbers.back() = last;
    sweeps.put(sweep, std::vector{SweepBlock{first, 10, numbers}});
    return hash(folder.file(name));
  };
  const std::string one = of("one.db", 0.5, 10);
  CHECK(of("same.db", 0.5, 10) == one);
  CHECK(of("number.db", std::nextafter(0.5, 1.0), 10) != one);
  CHECK(of("place.db", 0.5, 20) != one);
}

TEST_CASE("the seal of a record is that of the programs before", "[store][maintain]") {
  const Folder folder;
  {
    Store store(folder.file());
    put_shot(store, store.create_campaign(sample_campaign()), 0, 5);
  }
  CHECK(text_of(folder.file(), "SELECT seal FROM record") ==
        "83c9ec7dd184c843afd575adf6aeade641ef470c70c6686453e05e401a54b3d2");
}

TEST_CASE("what a killed process left beside a store goes, what a living one makes stays",
          "[store][maintain]") {
  const Folder folder;
  const std::string mark = ".new-", at = folder.file() + mark;
  const std::string living = at + std::to_string(getppid()), dead = at + "2147483646";
  for (const std::string& file : {living, dead, at + "x", folder.file("other.db") + mark + "2147483646"})
    write_bytes(file, "left");
  CHECK(aside_file(folder.file(), mark) == at + std::to_string(getpid()));
  CHECK(std::filesystem::exists(living));
  CHECK_FALSE(std::filesystem::exists(dead));
  CHECK_FALSE(std::filesystem::exists(at + "x"));  // no process has this name
  CHECK(std::filesystem::exists(folder.file("other.db") + mark + "2147483646"));
}
