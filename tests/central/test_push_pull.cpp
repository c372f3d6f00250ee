#include "host/store/points.h"
#include "tests/central/server.h"
#include "tests/host/bare_records.h"
#include "tests/host/overlapping_stores.h"

/// `powbench db push` and `pull` against PostgreSQL's own server.

using namespace powbench;
using namespace powbench::host;
using namespace powbench::test;
using Catch::Contains;

namespace {

std::int64_t count(pg::Connection& c, const std::string& table) {
  return c.run("SELECT count(*) FROM " + table).integer(0, 0);
}

/// What the database holds, as a store of its own.
std::string pulled(const host::Folder& folder, const std::string& base) {
  const std::string file = folder.file("pulled.db");
  std::filesystem::remove(file);
  pull_store(base, file);
  return content(file);
}

/// A store with one campaign of `n` measured closings.
void fill_store(const std::string& path, int n, std::uint64_t seed) {
  Store store(path);
  const auto c = store.create_campaign(sample_campaign("many"));
  for (int i = 0; i < n; ++i) put_shot(store, c, i, seed + static_cast<std::uint64_t>(i));
  store.set_finished(c, true);
}

}  // namespace

TEST_CASE("stores pushed in any order and repetition are one content, and pulled the same",
          "[central][.slow]") {
  const Three three;
  const auto& f = three.files;
  {
    Store store(f[1]);  // an angle that is not known, and a later extraction
    StoredShot s = sample_shot(2, 5, Outcome::not_judged);
    s.angle_deg = std::nan("");
    const Record r = sample_record(3);
    const Events e = sample_events(3);
    store.store_shot(s, &r, &e, sample_extraction());
    store.store_events(1, sample_events(77), {"b", "0.2"});
    store.annotate(1, "customer", "Müller & Söhne \"Werk 2\"");
  }
  const std::string base = Server::get().base("repeated");
  const Pushed first = push_store(f[0], base);
  CHECK(first.campaigns == 2);
  CHECK(first.shots == 4);
  CHECK(first.events == 3);
  CHECK(first.annotations == 1);
  CHECK(first.sweep_blocks == 1);
  CHECK(pulled(three.folder, base) == content(f[0]));
  const std::string before = state(base);
  const Pushed again = push_store(f[0], base);
  CHECK(again.campaigns + again.shots + again.events + again.annotations + again.sweep_blocks + again.bytes ==
        0);
  CHECK(state(base) == before);

  unpack_records(f[2]);  // a store from before records were packed
  for (const std::size_t i : {2, 1}) push_store(f[i], base);
  const std::string merged = three.folder.file("merged.db");
  merge_stores(merged, f);
  CHECK(pulled(three.folder, base) == content(merged));
  const std::string there = state(base);
  for (const auto& file : {merged, f[0], f[1], three.folder.file("pulled.db")}) push_store(file, base);
  CHECK(state(base) == there);

  // into a store that is there already, which has a part of it
  pull_store(base, f[0]);
  CHECK(content(f[0]) == content(merged));
  const Merged nothing = pull_store(base, f[0]);
  CHECK(nothing.shots + nothing.campaigns + nothing.events + nothing.sweep_blocks == 0);

  const auto of = [&](const std::string& customer) {
    return CampaignChoice([customer](const CampaignInfo&, const std::vector<Annotation>& list) {
      return std::any_of(list.begin(), list.end(), [&](const auto& a) { return a.text == customer; });
    });
  };
  CHECK(pull_store(base, three.folder.file("one.db"), of("Müller & Söhne \"Werk 2\"")).campaigns == 1);
  const StoreContent one = check_store(three.folder.file("one.db"));
  CHECK(one.campaigns == 1);
  CHECK(one.sweeps == 0);
  CHECK(one.damage.empty());
}

TEST_CASE("points of studies are pushed and pulled once, and another content is refused",
          "[central][.slow]") {
  const host::Folder folder;
  const std::string ours = folder.file("ours.db"), other = folder.file("other.db");
  {
    Points points(ours, "ladder"), others(other, "ladder");
    for (int i = 0; i < 600; ++i) {  // more than a transaction takes
      const std::string basis = "case " + std::to_string(i);
      points.get(i, basis, [&] { return "content " + std::to_string(i); });
      if (i % 3 == 0) others.get(i, basis, [&] { return "content " + std::to_string(i); });
    }
    others.get(700, "another case", [] { return std::string("\0\xff more", 7); });
  }
  const std::string base = Server::get().base("points");
  CHECK(push_store(other, base).points == 201);
  CHECK(push_store(ours, base).points == 400);
  CHECK(push_store(ours, base).points == 0);
  const std::string pulled_file = folder.file("pulled.db"), merged = folder.file("merged.db");
  CHECK(pull_store(base, pulled_file).points == 601);
  merge_stores(merged, {ours, other});
  CHECK(content(pulled_file) == content(merged));
  CHECK(check_store(pulled_file).points == 601);

  const std::string wrong = folder.file("wrong.db");
  Points(wrong, "ladder").get(5, "case 5", [] { return std::string("something else"); });
  CHECK_THROWS_WITH(push_store(wrong, base),
                    Contains("of ladder is not the same") && Contains("nothing was pushed"));
  CHECK(pull_store(base, folder.file("again.db")).points == 601);
}

TEST_CASE("a large sweep is pushed, pulled, checked and merged without being held in memory",
          "[central][.slow]") {
  const host::Folder folder;
  const std::string large = folder.file("large.db"), small = folder.file("small.db");
  const auto fill = [](const std::string& file, int blocks) {
    SweepStore store(file);
    SweepInfo info;
    info.design = "{}", info.design_hash = "large", info.points = 500 * blocks, info.columns = "x",
    info.program_version = "1";
    const auto sweep = store.open_sweep(info);
    std::vector<double> numbers(10'000);  // 80 kB: 500 points of 20 columns
    for (int i = 0; i < blocks; ++i) {
      for (std::size_t k = 0; k < numbers.size(); ++k)
        numbers[k] = static_cast<double>(k) + 1e-3 * static_cast<double>(i);
      store.put(sweep, std::vector{SweepBlock{500 * i, 500, numbers}});
    }
  };
  constexpr int blocks = 1500;  // 120 MB
  fill(small, 1);
  fill(large, blocks);
  const test::Folder out;
  const auto peak = [&](const std::vector<std::string>& words) {
    Program program(out, words);
    const int status = program.wait();
    INFO(program.err());
    CHECK(status == 0);
    return program.peak_megabytes();
  };
  const std::string base = Server::get().base("large_sweep"), other = Server::get().base("small_sweep");
  // a third of the sweep: a transaction holds 5 MB of it, which the program and the library of the server copy
#if defined(__SANITIZE_ADDRESS__)
  constexpr double room = 1000;  // the sanitizer keeps freed memory: only that it works
#else
  constexpr double room = 40;
#endif
  const double little = peak({"db", "push", other, "--db", small});
  CHECK(peak({"db", "push", base, "--db", large}) < little + room);
  CHECK(peak({"db", "push", base, "--db", large}) < little + room);  // compared block by block
  {
    pg::Connection c(base);
    CHECK(count(c, "sweep_block") == blocks);
  }
  CHECK(peak({"db", "pull", base, "--db", folder.file("pulled.db")}) < little + room);
  CHECK(peak({"db", "check", "--db", large}) < little + room);
  CHECK(peak({"db", "merge", large, "-o", folder.file("merged.db")}) < little + room);
  CHECK(content(folder.file("pulled.db")) == content(large));
}

TEST_CASE("a database answers in SQL what its stores would", "[central][.slow]") {
  const host::Folder folder;
  {
    Store store(folder.file());
    const auto campaign = store.create_campaign(sample_campaign("many"));
    for (int i = 0; i < 5; ++i) {
      const Record record = sample_record(static_cast<std::uint64_t>(40 + i));
      Events events = sample_events(static_cast<std::uint64_t>(40 + i));
      events.contact_voltage.present = false;  // so that times are those of the force
      store.store_shot(sample_shot(campaign, i), &record, &events, sample_extraction());
    }
    store.annotate(1, "customer", "first");
    store.annotate(1, "customer", "second");
  }
  const std::string base = Server::get().base("views");
  push_store(folder.file(), base);
  pg::Connection c(base);
  const auto campaigns = c.run("SELECT name, customer, measured FROM campaigns");
  REQUIRE(campaigns.size() == 1);
  CHECK(campaigns.text(0, 0) == "many");
  CHECK(campaigns.text(0, 1) == "second");
  CHECK(campaigns.integer(0, 2) == 5);
  const auto rows = c.run(
      "SELECT number, angle_deg, reached_deg, touch_ms, u_touch_ms, settled_ms FROM closings ORDER BY "
      "number");
  const auto lines = Store(folder.file(), Store::Mode::read_only).lines(1);
  REQUIRE(rows.size() == static_cast<int>(lines.size()));
  for (int i = 0; i < rows.size(); ++i) {
    const ShotLine& l = lines[static_cast<std::size_t>(i)];
    CHECK(rows.integer(i, 0) == l.shot.number);
    CHECK(rows.real(i, 1) == l.shot.angle_deg);
    CHECK(rows.real(i, 2) == Approx(l.reached.value * 180 / 3.14159265358979));
    CHECK(rows.real(i, 3) == Approx(l.touch.value * 1e3));
    CHECK(rows.real(i, 4) == Approx(l.touch.u * 1e3));
    CHECK(rows.real(i, 5) == Approx(l.settled.value * 1e3));
  }
}

TEST_CASE("many benches push at once, into a database that is new", "[central][.slow]") {
  Three three;
  for (int i = 0; i < 3; ++i) {
    Store store(three.files[static_cast<std::size_t>(i)]);
    for (int k = 0; k < 60; ++k)  // of the common campaign, each its own
      put_shot(store, 1, 10 + 3 * k + i, static_cast<std::uint64_t>(1000 + 3 * k + i));
  }
  merge_stores(three.folder.file("merged.db"), three.files);
  const std::string whole = content(three.folder.file("merged.db"));
  for (int round = 0; round < 2; ++round) {
    const std::string base = Server::get().base("at_once_" + std::to_string(round));
    std::vector<std::unique_ptr<test::Folder>> folders;
    std::vector<std::unique_ptr<Program>> benches;
    for (int i = 0; i < 6; ++i) {  // each of them twice, in another order every time
      const std::size_t file = static_cast<std::size_t>(i + round) % 3;
      folders.push_back(std::make_unique<test::Folder>());
      benches.push_back(std::make_unique<Program>(
          *folders.back(), std::vector<std::string>{"db", "push", base, "--db", three.files[file]}));
    }
    for (auto& bench : benches) {
      const int status = bench->wait();
      INFO(bench->err());
      CHECK(status == 0);
    }
    CHECK(pulled(three.folder, base) == whole);
  }
}

TEST_CASE("a push that is killed again and again goes on where it stopped", "[central][.slow]") {
  const host::Folder folder;
  constexpr int shots = 400;
  fill_store(folder.file(), shots, 5000);
  const std::string base = Server::get().base("killed");
  { const Store none(folder.file("none.db")); }
  push_store(folder.file("none.db"), base);  // the schema alone
  pg::Connection c(base);
  const test::Folder out;
  int killed = 0;
  std::int64_t before = 0;
  for (int k = 1; k <= 5; ++k) {
    Program push(out, {"db", "push", base, "--db", folder.file()});
    int status = -1000;
    wait_until("more shots", [&] {
      status = push.poll();
      return status != -1000 || count(c, "shot") > before;
    });
    push.send(SIGKILL);
    if (status == -1000) status = push.wait();
    wait_until("the server to notice", [&] {
      return c.run(
                  "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'powbench' AND datname = "
                  "'killed' "
                  "AND pid <> pg_backend_pid()")
                 .integer(0, 0) == 0;
    });
    const std::int64_t there = count(c, "shot");
    if (status == -SIGKILL && there > before && there < shots) ++killed;
    // whole shots, nothing of one that was begun; and a campaign is finished with its last shot
    CHECK(count(c, "record") == there);
    CHECK(count(c, "events") == there);
    CHECK(count(c, "channel") == there * static_cast<std::int64_t>(channel_count));
    CHECK(c.run("SELECT finished FROM campaign").flag(0, 0) == (there == shots));
    before = there;
  }
  CHECK(killed >= 3);
  const Pushed rest = push_store(folder.file(), base);
  CHECK(rest.shots == shots - before);
  CHECK(pulled(folder, base) == content(folder.file()));
}

TEST_CASE("content that conflicts with the database is refused, and the database stays as it was",
          "[central][.slow]") {
  const Three three;
  const auto& f = three.files;
  static int bases = 0;
  const std::string base = Server::get().base("conflict_" + std::to_string(bases++));
  const auto refused = [&](const std::string& why) {
    push_store(f[0], base);
    const std::string before = state(base);
    const test::Folder out;
    const Finished r = test::run(out, {"db", "push", base, "--db", f[1]});
    CHECK(r.status == 2);
    CHECK_THAT(r.err,
               Contains(why) && Contains("is not the same in " + f[1]) && Contains("nothing was pushed"));
    CHECK(state(base) == before);
    CHECK_THROWS_WITH(pull_store(base, f[1]), Contains("is not the same") && !Contains(".pull-"));
  };
  SECTION("a shot") {
    {
      Store a(f[0]), b(f[1]);
      put_shot(a, 1, 50, 90);
      put_shot(b, 1, 50, 91);
    }
    refused("shot number 50");
  }
  SECTION("a shot that is valid at another attempt") {
    {
      Store a(f[0]), b(f[1]);
      put_shot(a, 1, 1, 99);
      put_shot(b, 1, 1, 98, Outcome::error);
      put_shot(b, 1, 1, 98);
    }
    refused("shot number 1");
  }
  SECTION("its extraction") {
    {
      Store a(f[0]), b(f[1]);
      a.store_events(1, sample_events(77), {"b", "0.2"});
      b.store_events(1, sample_events(78), {"a", "0.3"});
    }
    refused("its extraction");
  }
  SECTION("its prediction") {
    for (const std::size_t i : {0, 1}) {
      Store store(f[i]);
      StoredShot s = sample_shot(1, 60);
      s.started = "2026-05-04T10:00:00Z";
      const Record r = sample_record(8);
      const Events e = sample_events(8);
      const auto id = store.store_shot(s, &r, &e, sample_extraction());
      store.store_prediction(id, {{{"t_ct1", 1e-6 * static_cast<double>(i + 1)}}, {}});
    }
    refused("its prediction");
  }
  SECTION("a block of a sweep") {
    SweepStore(f[1]).put(1, std::vector{SweepBlock{0, 10, std::vector<double>(10, 1.0)}});
    refused("its block 0");
  }
  SECTION("the cut of a sweep into blocks") {
    SweepStore(f[1]).put(1, std::vector{SweepBlock{5, 10, std::vector<double>(10, 1.0)}});
    refused("the cut into blocks");
  }
}
